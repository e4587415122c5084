// A sweep while it is made: what the files of this folder share.
#ifndef VIEWWORTH_EXPERIMENT_SWEEP_STATE_H
#define VIEWWORTH_EXPERIMENT_SWEEP_STATE_H

#include <stdbool.h>

#include "base/hash.h"
#include "experiment/sweep/configurations.h"
#include "experiment/sweep/store.h"
#include "run/out_lock.h"

struct vw_sweep; // and its params: experiment/sweep/sweep.h
struct vw_sweep_params;

// Time of a step, median over rounds.
struct vw_step_times {
    double wall_ms, cpu_ms; // cpu_ms: of all threads of the program
};

struct vw_measured_configuration {
    struct vw_step_times train, value; // steps without and with scoring
    struct vw_step_times base;         // the base with scoring, in the same rounds
    double device_bytes;
    double val_psnr; // dB, mean over the seeds; NaN where other pixels are measured than at the base
};

struct vw_sweep_state {
    const struct vw_sweep_params *params;           // borrowed
    struct vw_out_lock *lock;                       // lock of OUT
    struct vw_session session;                      // the base's
    struct vw_sweep_configurations *configurations; // borrowed from the sweep
    struct vw_measured_configuration measured[VW_CONFIGURATIONS_MAX];
    char base_id[VW_HASH_HEX_BYTES]; // run_id of the base's training
    char configuration_ids[VW_CONFIGURATIONS_MAX][VW_HASH_HEX_BYTES];
    struct vw_sweep_store store;
};

// ---- measure.c ----

// Times the first steps of every configuration, unless they are recorded. VW_ERROR_INTERRUPTED keeps the configurations
// that are measured.
enum vw_status vw_sweep_time_steps(struct vw_sweep_state *state);
// Returns the folder of a configuration's runs, owned by the caller; NULL when memory is short.
char *vw_sweep_folder(const struct vw_sweep_state *state, uint32_t configuration);
// Finds or measures the validation PSNR of the fields of a configuration's runs, on the photos of the base. A measured
// one is recorded in the store.
bool vw_sweep_find_psnr(struct vw_sweep_state *state, uint32_t configuration);
enum vw_status vw_sweep_measure_psnr(struct vw_sweep_state *state, uint32_t configuration);
// Returns the steps of a configuration's run.
uint64_t vw_sweep_steps(const struct vw_sweep_state *state, uint32_t configuration);
// Returns the wall clock of a step of a configuration without and with scoring, in ms: its ratio to the base in the
// same rounds, times the median of the base over all configurations, so that a busy machine does not make one
// configuration look slower. The ratio is of wall clock times, or, on a device that is the CPU, of CPU times, which
// other programs do not lengthen.
void vw_sweep_step_ms(const struct vw_sweep_state *state, uint32_t configuration, double *train_ms, double *value_ms);

// ---- metrics.c ----

// Computes the metrics from the ledgers of all configurations' runs and the measurements, and calls the follower.
enum vw_status vw_sweep_make_metrics(struct vw_sweep_state *state, struct vw_sweep *sweep);

#endif
