// What judges methods where truth is known: the photos, what they are, and what each method says of them. Every judge appends rows to a
// list; none knows what the methods are, and training only as a vw_trial_function.
#ifndef VIEWWORTH_VALUE_CONTEST_H
#define VIEWWORTH_VALUE_CONTEST_H

#include <stdbool.h>
#include <stdint.h>

#include "value/subsets.h"
#include "viewworth/status.h"
#include "viewworth/trials.h"

extern const char vw_contest_reference[]; // the method that others are compared with: "dv_psnr"

struct vw_contestant {
    const char *name;     // borrowed, as the scores
    const double *scores; // [valued seed][photo]; positive = helps
};

struct vw_contest {
    const uint32_t *photos;    // image_ids of those that are valued, ascending
    const char *const *truths; // per photo: "clean", or what spoils it
    uint32_t photo_count;
    const struct vw_contestant *contestants;
    uint32_t contestant_count;
    uint32_t seed_count; // valued seeds
};

// A growing list; begins all zero. Free `rows`.
struct vw_judgements {
    struct vw_judgement *rows;
    size_t count, capacity;
};
// Appends a row whose judgement is "<group>/<name>".
enum vw_status vw_judgements_add(struct vw_judgements *judgements, const char *group, const char *name, struct vw_judgement row);
// NULL when there is none.
const struct vw_judgement *vw_judgements_find(const struct vw_judgements *judgements, const char *group, const char *name,
                                              const char *method);

// ---- detection.c ----

bool vw_photo_is_clean(const struct vw_contest *contest, uint32_t photo);
// The share of pairs of a photo of `kind` (NULL: of every kind that `counts` admits; NULL: all) and a clean one of which the clean one has
// the higher score, ties as half. NaN and no pairs where either is missing.
typedef bool vw_kind_filter(const void *context, const char *kind);
double vw_auc(const struct vw_contest *contest, const double *scores, vw_kind_filter *counts, const void *context, uint32_t *pairs);
// auc/<kind> for every kind there is, and auc/spoiled; the mean over the valued seeds.
enum vw_status vw_judge_detection(const struct vw_contest *contest, struct vw_judgements *judgements);
// auc/harmful: over the kinds with a harm/<kind> whose interval lies above 0 (vw_judge_harm).
enum vw_status vw_judge_harmful(const struct vw_contest *contest, struct vw_judgements *judgements);
// seed_pearson/ and seed_spearman/ all and clean: how scores of the first two valued seeds agree, over all photos and the clean ones, as
// far as both have a finite score for them.
enum vw_status vw_judge_seeds(const struct vw_contest *contest, struct vw_judgements *judgements);

// ---- foretelling.c ----

// lds/<outcome>: Spearman's correlation over the subsets between the sum of their photos' scores and what training on them reaches, mean of
// its seeds; the mean over the valued seeds. lds_gain/<outcome>: that of the method less that of the reference. Intervals are the middle
// 95 % over resampled subsets, the same for all methods. Rows of the method "noise ceiling": the most that noise permits, the square root
// of how well the mean of two trainings would agree with that of two others (Spearman and Brown's formula from how the two agree); and
// agreement/<outcome>: Spearman's correlation of the two. Those of the method "chance": the mean of what random scores reach, and its
// middle 95 %. Subsets whose training has no value are left out. The intervals hold for these photos: what another scene of the kind would
// give lies wider apart.
enum vw_status vw_judge_subsets(const struct vw_contest *contest, const struct vw_subsets *subsets, struct vw_judgements *judgements);
// harm/<kind>, method "trials", in dB of val_psnr: by how much less a photo of that kind adds to a training than a clean one. What a photo
// adds is the mean over the subsets with it less that over those without it; intervals as above.
enum vw_status vw_judge_harm(const struct vw_contest *contest, const struct vw_subsets *subsets, struct vw_judgements *judgements);

// ---- curves.c ----

// Trains on what is left when the lowest, or highest, 10, 20, 30 and 50 % are taken away, and on these shares alone: rows removal_low/<%>,
// removal_high/<%>, addition_high/<%>, addition_low/<%> are the test PSNR (val, where nothing is for tests), mean of two seeds, less that
// of the training on all photos with the same seeds; photos in order of the scores of the first valued seed; no rows, and no training,
// where one of these is not finite. Of the control "random" the mean over VW_CURVE_ORDERS random orders, the rows named removal_low and
// addition_high.
enum { VW_CURVE_ORDERS = 3 };
enum vw_status vw_judge_curve(const struct vw_contest *contest, const struct vw_contestant *contestant, uint64_t first_seed,
                              vw_trial_function *try_trial, void *context, struct vw_judgements *judgements);
enum vw_status vw_judge_random_curve(const struct vw_contest *contest, uint64_t first_seed, vw_trial_function *try_trial, void *context,
                                     struct vw_judgements *judgements);
// How many trainings the curve of one order takes at most, those on all photos included.
uint32_t vw_curve_trainings(void);

// Trains without each photo in turn, with as many seeds as are valued: scores[seed][photo] is what val_psnr loses. Deltas are of equal
// seeds, so that what a seed does to all trainings is not in them.
enum vw_status vw_leave_one_out(const struct vw_contest *contest, uint64_t first_seed, vw_trial_function *try_trial, void *context,
                                double *scores);
// leave_one_out/spearman: how every method's scores agree with those, both as means over the seeds, over the photos.
enum vw_status vw_judge_leave_one_out(const struct vw_contest *contest, const double *scores, struct vw_judgements *judgements);

#endif
