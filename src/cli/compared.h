// What comparing lists of photos has found, and how it is told.
#ifndef VIEWWORTH_CLI_COMPARED_H
#define VIEWWORTH_CLI_COMPARED_H

#include "cli/compared_lists.h"
#include "viewworth/hash.h"
#include "viewworth/trial.h"

// Two lists whose trainings with the same seeds are held against one another.
struct vw_compared_pair {
    uint32_t list, against;
};

struct vw_compared {
    const struct vw_options *options; // borrowed, as are scene and lists
    const struct vw_scene *scene;
    struct vw_compared_lists *lists;
    const char *scene_hash;
    bool half_views;                // figures are of right halves: appearance is fitted on the left ones
    struct vw_outcome *outcomes;    // owned; [list][seed]
    struct vw_compared_pair *pairs; // owned; every list against the first one, then against each random one
    uint32_t pair_count;
    uint32_t *shown_views, shown_count; // owned; of which there are renders: scene indices
};

const struct vw_outcome *vw_compared_outcomes(const struct vw_compared *compared, uint32_t list); // by seed

// compare.csv (a row per list and seed), pairs.csv (a row per pair and measure) and disagreements.csv (a row for every photo that one list
// has and another has not, random ones left out) into the --out folder.
enum vw_status vw_compared_write_csv(const struct vw_compared *compared);
// compare.json, also to stdout when `print`.
enum vw_status vw_compared_write_json(const struct vw_compared *compared, bool print);
// The tables for people, to stdout.
void vw_compared_print(const struct vw_compared *compared);

#endif
