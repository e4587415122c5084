// A sweep over settings on its way from trainings to figures: what the parts of `tradeoff` share.
#ifndef VIEWWORTH_CLI_TRADEOFF_H
#define VIEWWORTH_CLI_TRADEOFF_H

#include "cli/laboratory.h"
#include "cli/options.h"
#include "cli/tradeoff_points.h"
#include "value/subsets.h"
#include "viewworth/hash.h"
#include "viewworth/status.h"
#include "viewworth/tradeoffs.h"

// What steps took, median over turns.
struct vw_step_times {
    double wall_ms, cpu_ms; // wall clock; what all threads of the program computed
};

// What was measured at a point.
struct vw_measured_point {
    struct vw_step_times train, value; // steps without and with scoring
    struct vw_step_times base;         // of the base with scoring, in the same turns
    double device_bytes;
    double val_psnr; // dB, mean over the seeds; NaN where other pixels count than at the base
};

struct vw_tradeoff {
    const struct vw_options *options;
    struct vw_laboratory laboratory; // its stage is the base's
    struct vw_tradeoff_points points;
    struct vw_measured_point measured[VW_POINTS_MAX];
    char point_ids[VW_POINTS_MAX][VW_HASH_HEX_BYTES];
    struct vw_tradeoffs *tradeoffs;
    struct vw_subsets subsets;          // count 0: no trainings on halves
    struct vw_tradeoff_figure *figures; // owned; a row per point and method
    uint32_t figure_count;
};

// ---- tradeoff_measure.c ----

// Times the first steps of every point, or recalls what they took. VW_ERROR_INTERRUPTED keeps the points that are measured.
enum vw_status vw_tradeoff_time_steps(struct vw_tradeoff *tradeoff);
// The folder of a point's runs, owned by the caller; NULL when memory is short.
char *vw_tradeoff_folder(const struct vw_tradeoff *tradeoff, uint32_t point);
// The validation PSNR of the fields that a point's runs left, all on the base's photos: recalled where it is known, or measured.
enum vw_status vw_tradeoff_recall_psnr(struct vw_tradeoff *tradeoff, uint32_t point, bool *found);
enum vw_status vw_tradeoff_measure_psnr(struct vw_tradeoff *tradeoff, uint32_t point);
// Steps of a point's run.
uint64_t vw_tradeoff_steps(const struct vw_tradeoff *tradeoff, uint32_t point);
// Wall clock of a step of a point without and with scoring, in ms: what its turns took beside the base's, times what the base takes in the
// median over all points, so that a machine that was busy for one point's turns does not make that point dearer. Turns are compared by
// wall clock, or on a device that is the CPU by CPU time, which other programs do not lengthen.
void vw_tradeoff_step_ms(const struct vw_tradeoff *tradeoff, uint32_t point, double *train_ms, double *value_ms);

// ---- tradeoff_figures.c ----

// Makes the figures from the ledgers of all points' runs, what was measured, and the trainings on halves.
enum vw_status vw_tradeoff_make_figures(struct vw_tradeoff *tradeoff);

// ---- tradeoff_output.c ----

// OUT/tradeoff.csv: a row per point and method, with the columns of vw_tradeoff_columns().
enum vw_status vw_tradeoff_write_csv(const struct vw_tradeoff *tradeoff, const char *path);
// On stdout; `report_path` is NULL where there is no report.
void vw_tradeoff_print(const struct vw_tradeoff *tradeoff, const char *csv_path, const char *report_path);
enum vw_status vw_tradeoff_print_json(const struct vw_tradeoff *tradeoff, const char *csv_path, const char *report_path);

#endif
