// What a comparison is asked for and what it finds: read by those who make it, write it and print it.
#ifndef VIEWWORTH_COMPARISON_DATA_H
#define VIEWWORTH_COMPARISON_DATA_H

#include "base/hash.h"
#include "experiment/experiment.h"
#include "experiment/photo_sets.h"
#include "ledger/retraining.h"
#include "value/evaluation/paired_comparison.h"

struct vw_comparison_params {
    struct vw_experiment_params common;
    struct vw_photo_sets_params sets;
    uint32_t rendered_views; // test photos (validation photos when there are none) to render side by side
};

// Two lists whose trainings with the same seeds are compared.
struct vw_set_pair {
    uint32_t list, against;
};

struct vw_comparison {
    const struct vw_comparison_params *params; // borrowed
    struct vw_session session;                 // owned; its scene is what was trained on
    char scene_hash[VW_HASH_HEX_BYTES];
    struct vw_photo_sets sets;         // owned
    bool half_views;                   // right halves are measured: an effect is fitted to the left ones
    struct vw_retrain_result *results; // owned; [list][seed]
    struct vw_set_pair *pairs;         // owned; every list against the first one, then against each random one
    uint32_t pair_count;
    uint32_t *rendered_views, rendered_count; // owned: scene indices
    char *report_path;                        // owned; NULL when there is no report
};

const struct vw_retrain_result *vw_comparison_results(const struct vw_comparison *comparison,
                                                      uint32_t list); // by seed
// The difference of a pair in one quality, over the seeds.
struct vw_paired_difference vw_comparison_difference(const struct vw_comparison *comparison,
                                                     const struct vw_set_pair *pair, enum vw_quality quality);

#endif
