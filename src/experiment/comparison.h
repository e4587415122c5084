// Comparison: which list of photos makes the better reconstruction. Every list is trained on with the same seeds and
// measured on whole validation and test photos.
#ifndef VIEWWORTH_EXPERIMENT_COMPARISON_H
#define VIEWWORTH_EXPERIMENT_COMPARISON_H

#include <jansson.h>

#include "base/hash.h"
#include "experiment/experiment.h"
#include "experiment/photo_sets.h"
#include "ledger/retraining.h"
#include "value/evaluation/outcomes.h"

enum { VW_VALUATIONS_MAX = 20, VW_COMPARISON_SAMPLES_MAX = 64 }; // seeds or valuations

struct vw_comparison_params {
    struct vw_experiment_params common;
    struct vw_photo_sets_params sets;
    // So many valuations of the scene, made in OUT/seed_N, select the lists in place of sets.scores, which is NULL
    // then; 0: none. Each has `common.seeds` trainings of every list, with seeds of their own, so that intervals over
    // the valuations contain the noise of selection and of training.
    uint32_t valuation_seeds;
};

// Two lists whose trainings with the same seeds are compared.
struct vw_set_pair {
    uint32_t list, against;
};

struct vw_comparison {
    const struct vw_comparison_params *params; // borrowed
    struct vw_session session;                 // owned; its scene is what was trained on
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_photo_sets sets;         // owned; by the first valuation
    struct vw_photo_sets *other_sets;  // owned; by valuation, from the second one on
    uint32_t training_count;           // per list
    bool half_views;                   // right halves are measured: appearance is taken from the left ones
    struct vw_retrain_result *results; // owned; [list][training]; the seed of a training is common.config->seed + its
                                       // number; the trainings of a valuation are neighbours
    struct vw_set_pair *pairs;         // owned; every list against the first one, then against each random one
    uint32_t pair_count;
    uint32_t *rendered_views, rendered_count; // owned: scene indices
    char *report_path;                        // owned; NULL when there is no report
};

// Makes the comparison, or resumes it. Writes to OUT: retrainings.db, compare.json (vw_comparison_to_json),
// report.html, renders/, and
// - compare.csv: a row per list and seed
// - pairs.csv: a row per pair and measure
// - disagreements.csv: a row per photo that one list has and another one has not, random lists left out
// VW_ERROR_USAGE and VW_ERROR_INPUT name the list or option that is wrong; nothing is written then. Free the result
// also after a failure.
enum vw_status vw_comparison_make(const struct vw_comparison_params *params, struct vw_comparison *comparison);
void vw_comparison_free(struct vw_comparison *comparison);

// ---- comparison_files.c ----

// Returns the list of a training: that of its valuation.
const struct vw_photo_set *vw_comparison_list(const struct vw_comparison *comparison, uint32_t list, uint32_t training);
// Returns whether a list has other photos by seed or by valuation.
bool vw_comparison_varies(const struct vw_comparison *comparison, uint32_t list);
// Returns the mean of a list in one outcome, and its error, over the seeds or the valuations.
struct vw_outcome_mean vw_comparison_mean(const struct vw_comparison *comparison, uint32_t list,
                                          enum vw_outcome outcome);
// Returns the difference of a pair in one outcome, over the seeds; with valuations over their means.
struct vw_paired_difference vw_comparison_difference(const struct vw_comparison *comparison,
                                                     const struct vw_set_pair *pair, enum vw_outcome outcome);
// Makes the content of compare.json; NULL when memory is short.
json_t *vw_comparison_to_json(const struct vw_comparison *comparison);
// Writes compare.csv, pairs.csv and disagreements.csv.
enum vw_status vw_comparison_write_csv(const struct vw_comparison *comparison);

#endif
