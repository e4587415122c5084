// What comparing lists of photos has found, and how it is told.
#ifndef VIEWWORTH_COMPARED_H
#define VIEWWORTH_COMPARED_H

#include "experiment/photo_sets.h"
#include "base/hash.h"
#include "ledger/retraining.h"

// Two lists whose trainings with the same seeds are held against one another.
struct vw_set_pair {
    uint32_t list, against;
};

struct vw_set_comparison {
    const struct vw_options *options; // borrowed, as are scene and lists
    const struct vw_scene *scene;
    struct vw_photo_sets *lists;
    const char *scene_hash;
    bool half_views;                    // figures are of right halves: appearance is fitted on the left ones
    struct vw_retrain_result *outcomes; // owned; [list][seed]
    struct vw_set_pair *pairs;          // owned; every list against the first one, then against each random one
    uint32_t pair_count;
    uint32_t *shown_views, shown_count; // owned; of which there are renders: scene indices
};

const struct vw_retrain_result *vw_set_comparison_outcomes(const struct vw_set_comparison *compared,
                                                           uint32_t list); // by seed

// compare.csv (a row per list and seed), pairs.csv (a row per pair and measure) and disagreements.csv (a row for every
// photo that one list has and another has not, random ones left out) into the --out folder.
enum vw_status vw_set_comparison_write_csv(const struct vw_set_comparison *compared);
// compare.json, also to stdout when `print`.
enum vw_status vw_set_comparison_write_json(const struct vw_set_comparison *compared, bool print);
// The tables for people, to stdout.
void vw_set_comparison_print(const struct vw_set_comparison *compared);

#endif
