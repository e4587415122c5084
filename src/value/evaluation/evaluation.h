// Evaluation of scorers where ground truth is known. Every vw_evaluate_ function appends rows to a list of metrics.
// None knows how scores are made, and training is known only as a vw_retrain_function.
#ifndef VIEWWORTH_VALUE_EVALUATION_H
#define VIEWWORTH_VALUE_EVALUATION_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/subsets.h"
#include "viewworth/status.h"
#include "ledger/retrainings.h"

extern const char vw_reference_scorer[]; // the scorer that others are compared with: "dv_psnr"

struct vw_scorer {
    const char *name;     // borrowed, as the scores
    const double *scores; // [valued seed][photo]; positive = helps
};

struct vw_evaluation {
    const uint32_t *photos;           // image_ids of those that are valued, ascending
    const char *const *ground_truths; // labels, per photo: "clean", or what corrupts it
    uint32_t photo_count;
    const struct vw_scorer *scorers;
    uint32_t scorer_count;
    uint32_t seed_count; // valued seeds
};

// A growing list; begins all zero. Free `rows`.
struct vw_metrics {
    struct vw_metric *rows;
    size_t count, capacity;
};
// Appends a row whose metric is "<group>/<name>".
enum vw_status vw_metrics_add(struct vw_metrics *metrics, const char *group, const char *name, struct vw_metric row);
// NULL when there is none.
const struct vw_metric *vw_metrics_find(const struct vw_metrics *metrics, const char *group, const char *name,
                                        const char *method);

// ---- detection.c ----

bool vw_photo_is_clean(const struct vw_evaluation *evaluation, uint32_t photo);
// The share of pairs of a photo of `kind` (NULL: of every kind that `counts` admits; NULL: all) and a clean one of
// which the clean one has the higher score, ties as half. NaN and no pairs where either is missing.
typedef bool vw_kind_filter(const void *context, const char *kind);
double vw_auc(const struct vw_evaluation *evaluation, const double *scores, vw_kind_filter *counts, const void *context,
              uint32_t *pairs);
// auc/<kind> for every kind there is, and auc/corrupted; the mean over the valued seeds.
enum vw_status vw_evaluate_detection(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);
// auc/harmful: over the kinds with a harm/<kind> whose interval lies above 0 (vw_evaluate_harm).
enum vw_status vw_evaluate_harmful(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);
// seed_pearson/ and seed_spearman/ all and clean: how scores of the first two valued seeds agree, over all photos and
// the clean ones, as far as both have a finite score for them.
enum vw_status vw_evaluate_seeds(const struct vw_evaluation *evaluation, struct vw_metrics *metrics);

// ---- lds.c ----

// Rows for val_psnr and test_psnr. Subsets whose trainings have no value are left out.
// - lds/<quality>: Spearman's correlation over the subsets between the sum of their photos' scores and the quality of
//   training on them (mean of its seeds); the mean over the valued seeds.
// - lds_gain/<quality>: the LDS of a method less that of the reference scorer.
// - lds/<quality> of "noise ceiling": the largest LDS that noise permits: the square root of the correlation between
// the
//   mean of two trainings and that of two others (Spearman-Brown formula).
// - agreement/<quality>: Spearman's correlation between the two trainings on the same subset.
// - lds/<quality> of "chance": the mean LDS of random scores, and its middle 95 %.
// Intervals are the middle 95 % over resampled subsets, the same resamples for all methods. They hold for these photos;
// other scenes vary more.
enum vw_status vw_evaluate_subsets(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                   struct vw_metrics *metrics);
// harm/<kind>, method "retrainings", in dB of val_psnr: how much less a photo of that kind adds to a training than a
// clean one. What a photo adds: the mean over the subsets with it less that over the subsets without it. Intervals as
// above.
enum vw_status vw_evaluate_harm(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                struct vw_metrics *metrics);

// ---- curves.c ----

// Trains without the 10, 20, 30 and 50 % of photos with the lowest scores, without those with the highest, and on these
// shares alone. Rows removal_low/<%>, removal_high/<%>, addition_low/<%>, addition_high/<%>: test PSNR (validation PSNR
// without test photos), mean of two seeds, less that of the training on all photos with the same seeds. The order is by
// the scores of the first valued seed; when one is not finite there are no rows and no training.
// vw_evaluate_random_curve: the mean over VW_CURVE_ORDERS random orders, rows removal_low and addition_high of the
// baseline "random".
enum { VW_CURVE_ORDERS = 3 };
enum vw_status vw_evaluate_curve(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                 uint64_t first_seed, vw_retrain_function *retrain, void *context,
                                 struct vw_metrics *metrics);
enum vw_status vw_evaluate_random_curve(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                        vw_retrain_function *retrain, void *context, struct vw_metrics *metrics);
// The most trainings that the curve of one order takes, those on all photos included.
uint32_t vw_curve_trainings(void);

// Trains without each photo in turn, with as many seeds as are valued. scores[seed][photo]: the val_psnr of training on
// all photos less that without the photo, with the same seed.
enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, double *scores);
// leave_one_out/spearman: Spearman's correlation over the photos between a method's scores and those, both as means
// over the seeds.
enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const double *scores,
                                         struct vw_metrics *metrics);

#endif
