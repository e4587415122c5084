// Sweep: what accuracy costs in time. The scene is valued at a base configuration and at configurations around it, each
// with one parameter changed, and at one with all validation pixels (full_resolution), whose scores the others are
// compared with.
#ifndef VIEWWORTH_EXPERIMENT_SWEEP_SWEEP_H
#define VIEWWORTH_EXPERIMENT_SWEEP_SWEEP_H

#include <stdint.h>

#include "base/rows.h"
#include "experiment/experiment.h"
#include "experiment/sweep/configurations.h"
#include "value/evaluation/score_tables.h"
#include "viewworth/status.h"

// A configuration, and the quality of one method's scores there. Reals are NaN where there is no value.
struct vw_sweep_metrics {
    const char *configuration; // "base", "rays-125", "full_resolution", ...
    const char *parameter;     // the parameter that it changes in the base configuration
    const char *value;         // to what; of the base: every parameter with its value
    uint32_t base;             // 1 for the base itself, 0 for the others; the same for the Pareto front
    uint32_t epochs;
    uint32_t steps;
    double train_ms, value_ms; // wall clock of a step without and with scoring
    double scoring_ratio;      // value_ms / train_ms
    double run_seconds;        // steps with scoring
    double device_mib;
    // dB, of the trained field on an even share of the validation photos' pixels (experiment/measured_views.h); mean
    // over the seeds. NaN where the configuration measures other pixels than the base (without masks, or appearance).
    double val_psnr;
    uint32_t psnr_pareto_front; // no other configuration takes less time for as high a val_psnr
    const char *method;
    double seed_pearson;      // correlation of the scores of two seeds; mean over pairs
    double agreement_pearson; // with the scores of the full_resolution configuration with the same seed; mean over the
                              // seeds
};

// Returns the rows of tradeoff.csv: all columns in the order above, with the names of the members.
struct vw_rows vw_sweep_rows(const struct vw_sweep_metrics *metrics, uint32_t count);

struct vw_sweep_measures {
    uint64_t steps;          // steps of a run
    double train_s, value_s; // time of a step without and with scoring
    double device_bytes;
    double val_psnr;
};

// A sweep, which ends with the tables of its scores, by configuration.
struct vw_sweep {
    const struct vw_sweep_params *params;                     // borrowed
    struct vw_session session;                                // the base's; open until the follower has been called
    struct vw_sweep_configurations *configurations;           // owned
    struct vw_sweep_measures measured[VW_CONFIGURATIONS_MAX]; // by configuration
    struct vw_sweep_metrics *metrics;                         // owned; a row per configuration and method
    uint32_t metric_count;
    char *csv_path;    // owned
    char *report_path; // owned; NULL when there is no report
};

// A function that is called with a sweep that is done, before it closes; `tables` has the scores of each configuration.
struct vw_sweep_follower {
    enum vw_status (*follow)(void *context, struct vw_sweep *sweep, const struct vw_score_tables *tables);
    void *context;
};

struct vw_sweep_params {
    struct vw_experiment_params common;       // seeds: of every configuration
    uint32_t parameters;                      // that are varied: bits of vw_sweep_parameters_parse(); 0: all
    const struct vw_sweep_follower *follower; // NULL: none
};

// Makes the sweep, or resumes its runs. Writes to OUT: configurations/<name>/seed_<seed>/ (experiment/experiment.h),
// report.html, and tradeoff.csv with a row per configuration and method and the columns of vw_sweep_rows(). Free the
// result also after a failure.
enum vw_status vw_sweep_make(const struct vw_sweep_params *params, struct vw_sweep *sweep);
void vw_sweep_free(struct vw_sweep *sweep);

#endif
