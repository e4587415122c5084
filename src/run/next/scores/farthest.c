// The score farthest: the distance to the nearest view that is known or added, in position and direction
// (vw_view_apart() in scene/view_distance.h). Picked one by one this is farthest view sampling of NeRF Director
// (Xiao et al., CVPR 2024).
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "run/next/candidate_scores.h"
#include "scene/view_distance.h"

struct farthest {
    struct vw_view_scales scales;
    const struct vw_candidate *candidates; // borrowed
    uint32_t count;
    double *least; // owned; by candidate
};

static void update_distances(struct farthest *farthest, const struct vw_view *view) {
    for (uint32_t i = 0; i < farthest->count; i++)
        farthest->least[i] =
            fmin(farthest->least[i], vw_view_apart(&farthest->scales, view, &farthest->candidates[i].pose));
}

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    struct farthest *farthest = *state = vw_allocate(1, sizeof *farthest);
    if (!farthest) return VW_ERROR_MEMORY;
    *farthest = (struct farthest){
        .scales = known->scales, .candidates = candidates, .count = count, .least = vw_allocate(count, sizeof(double))};
    if (!farthest->least) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) farthest->least[i] = INFINITY;
    for (uint32_t k = 0; k < known->count; k++) update_distances(farthest, &known->scene->views[known->views[k]]);
    return VW_OK;
}

static double gain(const void *state, uint32_t candidate) {
    const struct farthest *farthest = state;
    return farthest->least[candidate];
}

static void add(void *state, uint32_t candidate) {
    struct farthest *farthest = state;
    update_distances(farthest, &farthest->candidates[candidate].pose);
}

static void destroy(void **state) {
    struct farthest *farthest = *state;
    if (farthest) free(farthest->least);
    free(farthest);
    *state = NULL;
}

const struct vw_candidate_score vw_score_farthest = {.name = "farthest",
                                                     .summary = "farthest from all photos in position and direction",
                                                     .create = create,
                                                     .gain = gain,
                                                     .add = add,
                                                     .destroy = destroy};
