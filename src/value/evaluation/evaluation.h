// What evaluates methods where truth is known: the photos, what they are, and what each method says of them. Every
// evaluate appends rows to a list; none knows what the methods are, and training only as a vw_retrain_function.
#ifndef VIEWWORTH_VALUE_EVALUATION_H
#define VIEWWORTH_VALUE_EVALUATION_H

#include <stdbool.h>
#include <stdint.h>

#include "value/evaluation/subsets.h"
#include "viewworth/status.h"
#include "ledger/retrainings.h"

extern const char vw_reference_scorer[]; // the method that others are compared with: "dv_psnr"

struct vw_scorer {
    const char *name;     // borrowed, as the scores
    const double *scores; // [valued seed][photo]; positive = helps
};

struct vw_evaluation {
    const uint32_t *photos;           // image_ids of those that are valued, ascending
    const char *const *ground_truths; // per photo: "clean", or what corrupts it
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

// ---- predicting.c ----

// lds/<outcome>: Spearman's correlation over the subsets between the sum of their photos' scores and what training on
// them reaches, mean of its seeds; the mean over the valued seeds. lds_gain/<outcome>: that of the method less that of
// the reference. Intervals are the middle 95 % over resampled subsets, the same for all methods. Rows of the method
// "noise ceiling": the most that noise permits, the square root of how well the mean of two trainings would agree with
// that of two others (Spearman and Brown's formula from how the two agree); and agreement/<outcome>: Spearman's
// correlation of the two. Those of the method "chance": the mean of what random scores reach, and its middle 95 %.
// Subsets whose training has no value are left out. The intervals hold for these photos: what another scene of the kind
// would give lies wider apart.
enum vw_status vw_evaluate_subsets(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                   struct vw_metrics *metrics);
// harm/<kind>, method "retrainings", in dB of val_psnr: by how much less a photo of that kind adds to a training than a
// clean one. What a photo adds is the mean over the subsets with it less that over those without it; intervals as
// above.
enum vw_status vw_evaluate_harm(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                struct vw_metrics *metrics);

// ---- curves.c ----

// Trains on what is left when the lowest, or highest, 10, 20, 30 and 50 % are taken away, and on these shares alone:
// rows removal_low/<%>, removal_high/<%>, addition_high/<%>, addition_low/<%> are the test PSNR (val, where nothing is
// for tests), mean of two seeds, less that of the training on all photos with the same seeds; photos in order of the
// scores of the first valued seed; no rows, and no training, where one of these is not finite. Of the baseline "random"
// the mean over VW_CURVE_ORDERS random orders, the rows named removal_low and addition_high.
enum { VW_CURVE_ORDERS = 3 };
enum vw_status vw_evaluate_curve(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                 uint64_t first_seed, vw_retrain_function *retrain, void *context,
                                 struct vw_metrics *metrics);
enum vw_status vw_evaluate_random_curve(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                        vw_retrain_function *retrain, void *context, struct vw_metrics *metrics);
// How many trainings the curve of one order takes at most, those on all photos included.
uint32_t vw_curve_trainings(void);

// Trains without each photo in turn, with as many seeds as are valued: scores[seed][photo] is what val_psnr loses.
// Deltas are of equal seeds, so that what a seed does to all trainings is not in them.
enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, double *scores);
// leave_one_out/spearman: how every method's scores agree with those, both as means over the seeds, over the photos.
enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const double *scores,
                                         struct vw_metrics *metrics);

#endif
