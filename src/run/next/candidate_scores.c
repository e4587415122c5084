#include "run/next/candidate_scores.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static const struct vw_candidate_score *const scores[] = {
    &vw_score_farthest, &vw_score_coverage,       &vw_score_nearest_error,
    &vw_score_fisher,   &vw_score_farthest_error, &vw_score_spread}; // the first is the default

enum vw_status vw_candidate_score_find(const char *name, const struct vw_candidate_score **score) {
    char names[256] = "";
    for (size_t i = 0; i < VW_ARRAY_COUNT(scores); i++) {
        if (name && strcmp(name, scores[i]->name) != 0) {
            strncat(names, i ? ", " : "", sizeof names - strlen(names) - 1);
            strncat(names, scores[i]->name, sizeof names - strlen(names) - 1);
            continue;
        }
        *score = scores[i];
        return VW_OK;
    }
    return vw_fail(VW_ERROR_USAGE, "--method %s: does not score places; one of these does: %s", name, names);
}

// Returns whether a gain is larger than another; NaN is the least.
static bool is_larger(double gain, double other) { return gain > other || (isnan(other) && !isnan(gain)); }

// Finds the best candidate that is left.
static uint32_t find_best(const struct vw_candidate_score *score, const void *state, const bool *picked, uint32_t count,
                          double *best_gain) {
    uint32_t best = count;
    for (uint32_t i = 0; i < count; i++) {
        double gain = picked[i] ? 0 : score->gain(state, i);
        if (picked[i] || (best < count && !is_larger(gain, *best_gain))) continue;
        best = i;
        *best_gain = gain;
    }
    return best;
}

enum vw_status vw_next_candidates_pick(const struct vw_candidate_score *score, const struct vw_known_views *known,
                                       const struct vw_candidate *candidates, uint32_t count, uint32_t wanted,
                                       uint32_t *picks, double *gains, double *first_gains) {
    void *state = NULL;
    bool *picked = vw_allocate(count, sizeof *picked);
    enum vw_status status = picked ? score->create(known, candidates, count, &state) : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++) first_gains[i] = score->gain(state, i);
    for (uint32_t k = 0; k < wanted && !status; k++) {
        picks[k] = find_best(score, state, picked, count, &gains[k]);
        picked[picks[k]] = true;
        score->add(state, picks[k]);
    }
    score->destroy(&state);
    free(picked);
    return status;
}
