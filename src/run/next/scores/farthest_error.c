// The score farthest-error: the distance to the nearest view that is known or added, as the score farthest has it,
// times the root of the field's squared error there. That error is the mean over validation photos, weighted by 1 /
// (d^2 + 1/4), d being the candidate's distance from each.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "run/next/candidate_scores.h"
#include "scene/view_distance.h"

static const double NEAR = 0.25; // added to the square of a distance

struct farthest_error {
    void *farthest; // owned: the state of that score
    double *error;  // owned; by candidate
};

static double error_at(const struct vw_known_views *known, const struct vw_view *pose) {
    double sum = 0, weights = 0;
    for (uint32_t v = 0; v < known->val_count; v++) {
        double apart = vw_view_apart(&known->scales, &known->scene->views[known->val_views[v]], pose);
        sum += known->val_mse[v] / (apart * apart + NEAR);
        weights += 1 / (apart * apart + NEAR);
    }
    return weights > 0 ? sqrt(sum / weights) : 1;
}

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    struct farthest_error *made = *state = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    enum vw_status status = vw_score_farthest.create(known, candidates, count, &made->farthest);
    if (status) return status;
    made->error = vw_allocate(count, sizeof *made->error);
    for (uint32_t i = 0; made->error && i < count; i++) made->error[i] = error_at(known, &candidates[i].pose);
    return made->error ? VW_OK : VW_ERROR_MEMORY;
}

static double gain(const void *state, uint32_t candidate) {
    const struct farthest_error *made = state;
    return vw_score_farthest.gain(made->farthest, candidate) * made->error[candidate];
}

static void add(void *state, uint32_t candidate) {
    struct farthest_error *made = state;
    vw_score_farthest.add(made->farthest, candidate);
}

static void destroy(void **state) {
    struct farthest_error *made = *state;
    if (!made) return;
    vw_score_farthest.destroy(&made->farthest);
    free(made->error);
    free(made);
    *state = NULL;
}

const struct vw_candidate_score vw_score_farthest_error = {.name = "farthest-error",
                                                           .summary = "far from all photos where the field errs",
                                                           .create = create,
                                                           .gain = gain,
                                                           .add = add,
                                                           .destroy = destroy};
