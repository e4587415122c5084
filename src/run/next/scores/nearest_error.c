// The score nearest-error: the sum over validation photos of their squared error times exp(-d^2 / 2), d being the
// candidate's distance from the photo (vw_view_apart() in scene/view_distance.h). A pick removes that share of the
// error of each.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "run/next/candidate_scores.h"
#include "scene/view_distance.h"

struct nearest_error {
    const struct vw_known_views *known;    // borrowed
    const struct vw_candidate *candidates; // borrowed
    double *left;                          // owned; by validation photo: the error that picks leave
};

static double share(const struct nearest_error *nearest, uint32_t candidate, uint32_t val) {
    const struct vw_view *photo = &nearest->known->scene->views[nearest->known->val_views[val]];
    double apart = vw_view_apart(&nearest->known->scales, photo, &nearest->candidates[candidate].pose);
    return exp(-apart * apart / 2);
}

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    (void)count;
    struct nearest_error *nearest = *state = vw_allocate(1, sizeof *nearest);
    if (!nearest) return VW_ERROR_MEMORY;
    *nearest = (struct nearest_error){
        .known = known, .candidates = candidates, .left = vw_allocate(known->val_count, sizeof(double))};
    if (!nearest->left) return VW_ERROR_MEMORY;
    if (known->val_count) memcpy(nearest->left, known->val_mse, known->val_count * sizeof *nearest->left);
    return VW_OK;
}

static double gain(const void *state, uint32_t candidate) {
    const struct nearest_error *nearest = state;
    double sum = 0;
    for (uint32_t v = 0; v < nearest->known->val_count; v++) sum += nearest->left[v] * share(nearest, candidate, v);
    return sum;
}

static void add(void *state, uint32_t candidate) {
    struct nearest_error *nearest = state;
    for (uint32_t v = 0; v < nearest->known->val_count; v++) nearest->left[v] *= 1 - share(nearest, candidate, v);
}

static void destroy(void **state) {
    struct nearest_error *nearest = *state;
    if (nearest) free(nearest->left);
    free(nearest);
    *state = NULL;
}

const struct vw_candidate_score vw_score_nearest_error = {.name = "nearest-error",
                                                          .summary = "near validation photos that fit badly",
                                                          .create = create,
                                                          .gain = gain,
                                                          .add = add,
                                                          .destroy = destroy};
