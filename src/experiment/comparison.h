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

enum { VW_COMPARISON_SEEDS_MAX = 64 };

struct vw_comparison_params {
    struct vw_experiment_params common;
    struct vw_photo_sets_params sets;
};

// A training of a list.
struct vw_comparison_outcome {
    const char *list;
    uint64_t seed;
    uint32_t photo_count, epochs;
    struct vw_retrain_result result;
};

// The difference of two lists in one outcome, over trainings with the same seeds.
struct vw_comparison_pair {
    const char *list, *against, *measure;
    enum vw_outcome outcome; // that the measure is
    struct vw_paired_difference paired;
};

struct vw_comparison {
    const struct vw_comparison_params *params; // borrowed
    struct vw_session session;                 // owned; its scene is what was trained on
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_photo_sets sets;              // owned
    bool half_views;                        // right halves are measured: appearance is taken from the left ones
    struct vw_comparison_outcome *outcomes; // owned; [list][seed]
    struct vw_comparison_pair *pairs;       // owned; every list against the first one, then against each random one;
                                            // a row per outcome
    uint32_t pair_count;
    uint32_t *rendered_views, rendered_count; // owned: scene indices
    char *report_path;                        // owned; NULL when there is no report
};

// Makes the comparison, or resumes it. Writes to OUT: retrainings.db, compare.json (vw_comparison_to_json),
// report.html, renders/, and
// - compare.csv: a row per list and seed
// - pairs.csv: a row per pair and measure
// VW_ERROR_USAGE and VW_ERROR_INPUT name the list or option that is wrong; nothing is written then. Free the result
// also after a failure.
enum vw_status vw_comparison_make(const struct vw_comparison_params *params, struct vw_comparison *comparison);
void vw_comparison_free(struct vw_comparison *comparison);

// Returns the mean of a list in one outcome, and its error, over the seeds.
struct vw_outcome_mean vw_comparison_mean(const struct vw_comparison *comparison, uint32_t list,
                                          enum vw_outcome outcome);
// Makes the content of compare.json; NULL when memory is short.
json_t *vw_comparison_to_json(const struct vw_comparison *comparison);

#endif
