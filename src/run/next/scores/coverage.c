// The score coverage: the mean, over the pixels of a coarse picture from the candidate, of 1 / (1 + number of photos
// that see the pixel's cell), and 0 for a pixel that sees nothing (COVER, and before it next-best-view by counts).
#include <stdlib.h>

#include "base/memory.h"
#include "run/next/seen_surface.h"

struct coverage {
    struct vw_seen_surface surface;
    struct vw_seen_cells *seen; // owned; by candidate
    uint32_t count;
};

static enum vw_status create(const struct vw_known_views *known, const struct vw_candidate *candidates, uint32_t count,
                             void **state) {
    struct coverage *coverage = *state = vw_allocate(1, sizeof *coverage);
    if (!coverage) return VW_ERROR_MEMORY;
    enum vw_status status = vw_seen_surface_create(known, &coverage->surface);
    coverage->seen = vw_allocate(count, sizeof *coverage->seen);
    coverage->count = coverage->seen ? count : 0;
    if (!coverage->seen) status = VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count && !status; i++)
        status = vw_seen_surface_look(&coverage->surface, &candidates[i].pose, &coverage->seen[i]);
    return status;
}

static double gain(const void *state, uint32_t candidate) {
    const struct coverage *coverage = state;
    const struct vw_seen_cells *seen = &coverage->seen[candidate];
    double sum = 0;
    for (uint32_t i = 0; i < seen->count; i++)
        if (seen->cells[i] != VW_SEEN_NOTHING) sum += 1.0 / (1.0 + coverage->surface.counts[seen->cells[i]]);
    return sum / seen->count;
}

static void add(void *state, uint32_t candidate) {
    struct coverage *coverage = state;
    vw_seen_surface_add(&coverage->surface, &coverage->seen[candidate]);
}

static void destroy(void **state) {
    struct coverage *coverage = *state;
    if (!coverage) return;
    for (uint32_t i = 0; i < coverage->count; i++) free(coverage->seen[i].cells);
    free(coverage->seen);
    vw_seen_surface_destroy(&coverage->surface);
    free(coverage);
    *state = NULL;
}

const struct vw_candidate_score vw_score_coverage = {.name = "coverage",
                                                     .summary = "sees most of the surface that few photos see",
                                                     .create = create,
                                                     .gain = gain,
                                                     .add = add,
                                                     .destroy = destroy};
