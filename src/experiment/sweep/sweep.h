// Sweep: what accuracy costs in time. The scene is valued at a base configuration and at configurations around it, each
// with one parameter changed, and at one with all validation pixels (full_resolution), whose scores the others are
// compared with.
#ifndef VIEWWORTH_EXPERIMENT_SWEEP_SWEEP_H
#define VIEWWORTH_EXPERIMENT_SWEEP_SWEEP_H

#include <stdint.h>

#include "experiment/experiment.h"
#include "experiment/retrain.h"
#include "experiment/sweep/configurations.h"
#include "ledger/sweeps.h"
#include "value/evaluation/score_tables.h"
#include "viewworth/status.h"

// An evaluation of the scores by further trainings, which a caller may add: it fills auc and lds of the metrics.
struct vw_sweep_evaluator {
    uint32_t seeds;     // that its trainings take, after those of the runs
    uint32_t trainings; // number of trainings of the base's steps; for the estimate of the duration
    enum vw_status (*train)(void *context, struct vw_retrainer *retrainer, uint64_t first_seed);
    // `metrics` has one entry per table.
    enum vw_status (*evaluate)(void *context, const struct vw_retrainer *retrainer,
                               const struct vw_score_tables *tables, struct vw_sweep_metrics *metrics);
    void *context;
};

struct vw_sweep_params {
    struct vw_experiment_params common;         // seeds: of every configuration
    uint32_t parameters;                        // that are varied: bits of vw_sweep_parameters_parse(); 0: all
    const struct vw_sweep_evaluator *evaluator; // NULL: none
};

struct vw_sweep {
    const struct vw_sweep_params *params;           // borrowed
    struct vw_sweep_configurations *configurations; // owned
    struct vw_sweep_metrics *metrics;               // owned; a row per configuration and method
    uint32_t metric_count;
    char *csv_path;    // owned
    char *report_path; // owned; NULL when there is no report
};

// Makes the sweep, or resumes it. Writes to OUT: configurations/<name>/seed_<seed>/ (experiment/experiment.h),
// retrainings.db, tradeoff.db, report.html, and tradeoff.csv with a row per configuration and method and the columns of
// vw_sweep_rows(). Free the result also after a failure.
enum vw_status vw_sweep_make(const struct vw_sweep_params *params, struct vw_sweep *sweep);
void vw_sweep_free(struct vw_sweep *sweep);

#endif
