// The measurements and metrics of sweeps in an SQLite file of their own (OUT/tradeoff.db), so that an interrupted sweep
// resumes. Ordinary tables:
// - measurement(configuration_id, quantity, value, row_hash): what is expensive to measure again, or would not come out
//   the same to the last digit (times). configuration_id: 64 hex digits, hash of all that the value depends on.
//   row_hash: hash of the other columns; an edited row is refused. It catches mistakes, not a forger, who can hash
//   anew.
// - metric(sweep_id, place, ...): the results, a row per configuration and method, with the columns of
//   vw_sweep_rows().
// Each append is one synced transaction.
#ifndef VIEWWORTH_LEDGER_SWEEPS_H
#define VIEWWORTH_LEDGER_SWEEPS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rows.h"
#include "viewworth/status.h"

// A configuration, and the quality of one method's scores there. Reals are NaN where there is no value; correlations
// are in [-1,1].
struct vw_sweep_metrics {
    const char *configuration; // "base", "rays-125", "full_resolution", ...
    const char *parameter;     // the parameter that it changes in the base configuration
    const char *value;         // to what; of the base: every parameter with its value
    uint32_t base;             // 1 for the base itself, else 0; the same for the Pareto fronts
    uint32_t epochs;
    uint32_t steps;
    // Wall clock of a step without and with scoring, by paired timing with the base; where the device is the CPU, the
    // base's wall clock times the ratio of CPU times. Of the first steps, before the effect occupancy skips any sample.
    double train_ms, value_ms;
    double scoring_ratio; // value_ms / train_ms
    double run_seconds;   // steps with scoring
    double device_mib;
    // dB, of the trained field on validation photos of the base's size, on 65,536 pixels spread evenly over those that
    // have more; mean over the seeds. NaN where the configuration measures other pixels than the base (without masks,
    // or appearance).
    double val_psnr;
    uint32_t psnr_pareto_front; // no other configuration takes less time for as high a val_psnr
    const char *method;
    uint32_t score_pareto_front;                  // the same for agreement_pearson
    double seed_pearson, seed_spearman;           // scores of two seeds; mean over pairs
    double agreement_pearson, agreement_spearman; // with the scores of the full_resolution configuration with the same
                                                  // seed; mean over the seeds
    double all_pixels_pearson,
        all_pixels_spearman;             // the same with those of the same trainings, scored on all validation pixels
    double auc;                          // probability that a clean photo scores above a corrupted one
    double lds, lds_ci_low, lds_ci_high; // Spearman's correlation of summed scores of random halves with what trainings
                                         // on them reach, and its 95 % interval over the halves
};

// Returns the rows of tradeoff.csv: all columns in the order above, with the names of the members.
struct vw_rows vw_sweep_rows(const struct vw_sweep_metrics *metrics, uint32_t count);

struct vw_sweeps;

// Opens the file, or makes it. VW_ERROR_INPUT when it is something else, of another version, or damaged.
enum vw_status vw_sweeps_open(const char *path, struct vw_sweeps **sweeps);
void vw_sweeps_close(struct vw_sweeps **sweeps);

// Looks up a quantity of a configuration: `*found` tells if it is recorded, `*value` is its value (NaN for NULL).
// VW_ERROR_MISMATCH if its row was edited.
enum vw_status vw_sweeps_find(struct vw_sweeps *sweeps, const char *configuration_id, const char *quantity, bool *found,
                              double *value);
struct vw_measurement {
    const char *quantity; // borrowed
    double value;
};
// Records several measurements of a configuration at once; they replace older ones of the same quantities.
enum vw_status vw_sweeps_keep(struct vw_sweeps *sweeps, const char *configuration_id,
                              const struct vw_measurement *measurements, uint32_t count);
// Replaces the metrics of a sweep.
enum vw_status vw_sweeps_set_metrics(struct vw_sweeps *sweeps, const char *sweep_id,
                                     const struct vw_sweep_metrics *metrics, uint32_t count);

#endif
