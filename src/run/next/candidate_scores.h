// Scores of places for a next photo, in one registry, and the choice of a batch by one of them. A new score is a file
// in scores/ and a row.
#ifndef VIEWWORTH_RUN_NEXT_CANDIDATE_SCORES_H
#define VIEWWORTH_RUN_NEXT_CANDIDATE_SCORES_H

#include "run/next/candidates.h"
#include "scene/view_distance.h"

struct vw_trainer;

// The sources of every score; all of them are borrowed, and outlive its state.
struct vw_known_views {
    const struct vw_scene *scene;
    struct vw_view_scales scales; // units of distances between poses
    struct vw_trainer *trainer;   // has the run's field, and makes no steps
    const uint32_t *views;        // photos trained on, scene indices
    uint32_t count;
    const uint32_t *val_views; // validation photos, scene indices
    const double *val_mse;     // the field's error at each of them
    uint32_t val_count;
};

struct vw_candidate_score {
    const char *name;
    const char *summary; // a clause, for help
    // Makes the state, which may keep pointers to the candidates. Destroy it also after a failure.
    enum vw_status (*create)(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state);
    // Returns what adding the candidate to the known and the added ones is thought to gain, in units of the score's
    // own: more is better.
    double (*gain)(const void *state, uint32_t candidate);
    void (*add)(void *state, uint32_t candidate);
    void (*destroy)(void **state);
};

extern const struct vw_candidate_score vw_score_farthest, vw_score_coverage, vw_score_nearest_error, vw_score_fisher,
    vw_score_farthest_error, vw_score_spread;

// Returns the score of this name, NULL: the default. VW_ERROR_USAGE lists the names there are.
enum vw_status vw_candidate_score_find(const char *name, const struct vw_candidate_score **score);

// Picks `wanted` <= `count` candidates, one after another: always the one with the largest gain beside those picked
// before, of equal ones the first; NaN is the least. `gains` has what each gained then, and `first_gains`, by
// candidate, what each would gain alone.
enum vw_status vw_next_candidates_pick(const struct vw_candidate_score *score, const struct vw_known_views *known,
                                       const struct vw_candidate *candidates, uint32_t count, uint32_t wanted,
                                       uint32_t *picks, double *gains, double *first_gains);

#endif
