// Evaluation of scorers where ground truth is known. Every vw_evaluate_ function appends rows to a list of metrics.
// None knows how scores are made, and training is known only as a vw_retrain_function.
#ifndef VIEWWORTH_LAB_EVALUATION_EVALUATION_H
#define VIEWWORTH_LAB_EVALUATION_EVALUATION_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/outcomes.h"
#include "viewworth/status.h"

extern const char vw_subset_worth_name[]; // "subset_worth": worths by regression over subsets

extern const char vw_reference_scorer[]; // the scorer that others are compared with: "dv_psnr"

enum { VW_TRUTH_COUNT = 2 };
extern const enum vw_outcome vw_truths[VW_TRUTH_COUNT]; // target of scores: val_psnr and test_psnr
extern const char vw_noise_ceiling_name[], vw_chance_name[];

struct vw_scorer {
    const char *name;     // borrowed, as the scores
    const double *scores; // [valued seed][photo]; positive = helps
    bool has_sign;        // a score below 0 says that the photo harms
    bool of_subsets;      // worths of photos from trainings on subsets: such a scorer predicts these by its own fits
};

struct vw_evaluation {
    const uint32_t *photos;           // image_ids of those that are valued, ascending
    const char *const *ground_truths; // labels, per photo: "clean", or what corrupts it
    uint32_t photo_count;
    const struct vw_scorer *scorers;
    uint32_t scorer_count;
    uint32_t seed_count; // valued seeds
};

// One value of a benchmark.
enum { VW_METRIC_BYTES = 48 };
struct vw_metric {
    char metric[VW_METRIC_BYTES]; // "auc/blur", "lds/val_psnr", ...
    const char *method;           // evaluated: the name of a method or of a baseline; borrowed
    double value;                 // NaN becomes NULL
    double ci_low, ci_high;       // 95 % interval; NaN where there is none
    uint32_t count;               // sample size: pairs, photos, subsets or trainings
};

// A growing list; begins all zero. Free `rows`.
struct vw_metrics {
    struct vw_metric *rows;
    size_t count, capacity;
};
// Appends a row whose metric is "<group>/<name>".
enum vw_status vw_metrics_add(struct vw_metrics *metrics, const char *group, const char *name, struct vw_metric row);
// Returns NULL when there is none.
const struct vw_metric *vw_metrics_find(const struct vw_metrics *metrics, const char *group, const char *name,
                                        const char *method);

// Returns NULL when there is none.
const struct vw_scorer *vw_find_scorer(const struct vw_evaluation *evaluation, const char *name);
// Averages over the rows of values[row][column] into means[column].
void vw_mean_of_rows(const double *values, uint32_t row_count, uint32_t column_count, double *means);
// Averages scores[valued seed][photo] into means[photo].
void vw_mean_over_seeds(const struct vw_evaluation *evaluation, const double *scores, double *means);

// ---- reliability.c ----

// The reliability of values[seed][count].
struct vw_reliability {
    double agreement; // mean of Spearman's correlation over all pairs of seeds; NaN with one seed
    double ceiling;   // the largest correlation with the mean of the seeds that noise permits: the square root of that
                      // mean's reliability, which follows from the agreement by the formula of Spearman and Brown
                      // (1910); NaN where the seeds do not agree
};
enum vw_status vw_reliability_find(const double *values, uint32_t seed_count, uint32_t count,
                                   struct vw_reliability *reliability);
// Adds rows <group>/<name> of "noise ceiling" and agreement_<group>/<name> of "outcomes".
enum vw_status vw_evaluate_reliability(const double *values, uint32_t seed_count, uint32_t count, const char *group,
                                       const char *name, struct vw_metrics *metrics);

// ---- detection.c ----

bool vw_photo_is_clean(const struct vw_evaluation *evaluation, uint32_t photo);
// Adds auc/<kind> for every kind that exists, and auc/corrupted; the mean over the valued seeds, and the middle 95 %
// over resampled photos.
enum vw_status vw_evaluate_detection(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);
// Adds auc/harmful over the kinds with a harm/<kind> whose interval lies above 0 (vw_evaluate_harm).
enum vw_status vw_evaluate_harmful(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);
// Adds seed_pearson/ and seed_spearman/ all and clean: the agreement of scores of the first two valued seeds, over all
// photos and the clean ones that have a finite score by both.
enum vw_status vw_evaluate_seeds(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);

// ---- lds.c ----

// Rows for val_psnr and test_psnr. Subsets whose trainings have no value are left out.
// - lds/<outcome>: Spearman's correlation over the halves between the sum of their photos' scores and the outcome of
//   training on them (mean of its seeds); the mean over the valued seeds.
// - lds_sizes/<outcome>: the same over the subsets of random sizes, with the mean of their photos' scores: trainings of
//   equal steps share these among the photos, so that a photo's part falls with the number of photos.
// - lds_mean/<outcome>, lds_sizes_mean/<outcome>: the LDS of the mean scores of all valued seeds.
// - lds_gain/<outcome>, lds_sizes_gain/<outcome>: the LDS of a method less that of the reference scorer.
// - of "subset_worth" (with worths, one per truth): each subset as a regression over the other subsets predicts it; the
//   LDS within reach of a linear score.
// - of "noise ceiling", and agreement_lds/, agreement_lds_sizes/: see outcomes.h.
// - of "chance": the mean LDS of random scores, and its middle 95 %.
// Intervals are the middle 95 % over resampled subsets, the same resamples for all methods. They hold for these photos;
// other scenes vary more. `worths`: NULL for none.
struct vw_worths;
enum vw_status vw_evaluate_subsets(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                   const struct vw_worths *worths, struct vw_metrics *metrics);

// ---- worths.c ----

// Adds harm/<kind>, method "retrainings", in dB: how much less a photo of that kind is worth than a clean one.
// Intervals are over resampled subsets.
enum vw_status vw_evaluate_harm(const struct vw_evaluation *evaluation, const struct vw_worths *worths,
                                struct vw_metrics *metrics);
// Measures how well signs of scores tell helpful from harmful photos, for every scorer that has_sign. A photo is known
// to be harmful, or helpful, if the interval of its worth lies below, or above, 0. Shares over all valued seeds; NaN
// where they are of no photo.
// - sign_accuracy/<name>: of the known photos, those whose score has the sign of their worth.
// - harmful_precision/<name>: of those with a score below 0, those that are known to be harmful.
// - harmful_recall/<name>, helpful_recall/<name>: of the photos known to be so, those whose score has that sign.
enum vw_status vw_evaluate_signs(const struct vw_evaluation *evaluation, const struct vw_worths *worths,
                                 const char *name, struct vw_metrics *metrics);
// Adds left_out_pearson/<name>, left_out_r2/<name> of "subset_worth": how well the worths predict subsets that they
// were not fitted to.
enum vw_status vw_evaluate_worths(const struct vw_worths *worths, const char *name, struct vw_metrics *metrics);

// ---- curves.c ----

// Trains without the 10, 20, 30 and 50 % of photos with the lowest scores, without those with the highest, and on these
// shares alone. Rows removal_low/<%>, removal_high/<%>, addition_low/<%>, addition_high/<%>: test PSNR (validation PSNR
// without test photos) less that of the training on all photos with the same seed; mean over the seeds, with a 95 %
// interval by Student's t over these differences. The order is by the scores of the first valued seed; when one is not
// finite there are no rows and no training.
// vw_evaluate_random_curve: the mean over VW_CURVE_ORDERS random orders, rows removal_low and addition_high of the
// baseline "random"; the interval adds the spread over the orders.
enum { VW_CURVE_ORDERS = 3 };
struct vw_curve_params {
    const struct vw_evaluation *evaluation;
    uint64_t first_seed;
    uint32_t seed_count; // retrainings of each set of photos
    vw_retrain_function *retrain;
    void *context;  // argument of `retrain`
    bool gain_only; // only removal_low/20: what leaving out the lowest fifth gains
};
enum vw_status vw_evaluate_curve(const struct vw_curve_params *params, const struct vw_scorer *scorer,
                                 struct vw_metrics *metrics);
enum vw_status vw_evaluate_random_curve(const struct vw_curve_params *params, struct vw_metrics *metrics);
// Returns the most trainings that the curve of one order takes, those on all photos included.
uint32_t vw_curve_trainings(uint32_t seed_count, bool gain_only);

#endif
