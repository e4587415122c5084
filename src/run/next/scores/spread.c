// The score spread: by how much a photo there shortens the mean distance from all candidates to the nearest view that
// is known or added (vw_view_apart() in scene/view_distance.h). Picked one by one this is the greedy choice of k
// medoids (facility location; Nemhauser, Wolsey and Fisher 1978): unlike the score farthest it shuns places beside all
// others.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "run/next/candidate_scores.h"
#include "scene/view_distance.h"

struct spread {
    struct vw_view_scales scales;
    const struct vw_candidate *candidates; // borrowed
    uint32_t count;
    double *least; // owned; by candidate: its distance to the nearest view
};

static double apart(const struct spread *spread, const struct vw_view *view, uint32_t candidate) {
    return vw_view_apart(&spread->scales, view, &spread->candidates[candidate].pose);
}

static void update_distances(struct spread *spread, const struct vw_view *view) {
    for (uint32_t i = 0; i < spread->count; i++) spread->least[i] = fmin(spread->least[i], apart(spread, view, i));
}

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    struct spread *spread = *state = vw_allocate(1, sizeof *spread);
    if (!spread) return VW_ERROR_MEMORY;
    *spread = (struct spread){
        .scales = known->scales, .candidates = candidates, .count = count, .least = vw_allocate(count, sizeof(double))};
    if (!spread->least) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) spread->least[i] = INFINITY;
    for (uint32_t k = 0; k < known->count; k++) update_distances(spread, &known->scene->views[known->views[k]]);
    return VW_OK;
}

static double gain(const void *state, uint32_t candidate) {
    const struct spread *spread = state;
    const struct vw_view *pose = &spread->candidates[candidate].pose;
    double sum = 0;
    for (uint32_t i = 0; i < spread->count; i++) sum += fmax(0, spread->least[i] - apart(spread, pose, i));
    return sum / spread->count;
}

static void add(void *state, uint32_t candidate) {
    struct spread *spread = state;
    update_distances(spread, &spread->candidates[candidate].pose);
}

static void destroy(void **state) {
    struct spread *spread = *state;
    if (spread) free(spread->least);
    free(spread);
    *state = NULL;
}

const struct vw_candidate_score vw_score_spread = {.name = "spread",
                                                   .summary = "brings the nearest photo nearer to all places",
                                                   .create = create,
                                                   .gain = gain,
                                                   .add = add,
                                                   .destroy = destroy};
