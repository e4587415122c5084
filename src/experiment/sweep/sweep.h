// A sweep over settings on its way from trainings to metrics: what the parts of `sweep` share.
#ifndef VIEWWORTH_TRADEOFF_H
#define VIEWWORTH_TRADEOFF_H

#include "experiment/retrain.h"
#include "cli/options.h"
#include "experiment/sweep/configurations.h"
#include "value/evaluation/subsets.h"
#include "base/hash.h"
#include "viewworth/status.h"
#include "ledger/sweeps.h"

// What steps took, median over turns.
struct vw_step_times {
    double wall_ms, cpu_ms; // wall clock; what all threads of the program computed
};

// What was measured at a configuration.
struct vw_measured_configuration {
    struct vw_step_times train, value; // steps without and with scoring
    struct vw_step_times base;         // of the base with scoring, in the same turns
    double device_bytes;
    double val_psnr; // dB, mean over the seeds; NaN where other pixels count than at the base
};

struct vw_sweep {
    const struct vw_options *options;
    struct vw_retrainer retrainer; // its session is the base's
    struct vw_sweep_configurations configurations;
    struct vw_measured_configuration measured[VW_CONFIGURATIONS_MAX];
    char configuration_ids[VW_CONFIGURATIONS_MAX][VW_HASH_HEX_BYTES];
    struct vw_sweeps *tradeoffs;
    struct vw_subsets subsets;        // count 0: no trainings on halves
    struct vw_sweep_metrics *metrics; // owned; a row per configuration and method
    uint32_t metric_count;
};

// ---- tradeoff_measure.c ----

// Times the first steps of every configuration, or recalls what they took. VW_ERROR_INTERRUPTED keeps the
// configurations that are measured.
enum vw_status vw_sweep_time_steps(struct vw_sweep *sweep);
// The folder of a configuration's runs, owned by the caller; NULL when memory is short.
char *vw_sweep_folder(const struct vw_sweep *sweep, uint32_t configuration);
// The validation PSNR of the fields that a configuration's runs left, all on the base's photos: recalled where it is
// known, or measured.
enum vw_status vw_sweep_recall_psnr(struct vw_sweep *sweep, uint32_t configuration, bool *found);
enum vw_status vw_sweep_measure_psnr(struct vw_sweep *sweep, uint32_t configuration);
// Steps of a configuration's run.
uint64_t vw_sweep_steps(const struct vw_sweep *sweep, uint32_t configuration);
// Wall clock of a step of a configuration without and with scoring, in ms: what its turns took beside the base's, times
// what the base takes in the median over all configurations, so that a machine that was busy for one configuration's
// turns does not make that configuration dearer. Turns are compared by wall clock, or on a device that is the CPU by
// CPU time, which other programs do not lengthen.
void vw_sweep_step_ms(const struct vw_sweep *sweep, uint32_t configuration, double *train_ms, double *value_ms);

// ---- tradeoff_figures.c ----

// Makes the metrics from the ledgers of all configurations' runs, what was measured, and the trainings on halves.
enum vw_status vw_sweep_make_metrics(struct vw_sweep *sweep);

// ---- tradeoff_output.c ----

// OUT/sweep.csv: a row per configuration and method, with the columns of vw_sweep_columns().
enum vw_status vw_sweep_write_csv(const struct vw_sweep *sweep, const char *path);
// On stdout; `report_path` is NULL where there is no report.
void vw_sweep_print(const struct vw_sweep *sweep, const char *csv_path, const char *report_path);
enum vw_status vw_sweep_print_json(const struct vw_sweep *sweep, const char *csv_path, const char *report_path);

#endif
