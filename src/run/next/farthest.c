#include "run/next/farthest.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"

static const double NEAR = 0.25;        // added to the square of a distance
static const double ERROR_LEAST = 1e-6; // without errors, distances decide alone
static const double PICKED = -1;        // in place of a distance

static double error_at(const struct vw_known_photos *known, const struct vw_view *pose) {
    double sum = 0, weights = 0;
    for (uint32_t v = 0; v < known->val_count; v++) {
        double apart = vw_view_apart(&known->scales, &known->scene->views[known->val_views[v]], pose);
        sum += known->val_mse[v] / (apart * apart + NEAR);
        weights += 1 / (apart * apart + NEAR);
    }
    return weights > 0 ? fmax(sqrt(sum / weights), ERROR_LEAST) : 1;
}

// Finds the candidate of largest gain.
static uint32_t find_best(const double *least, const double *errors, uint32_t count) {
    uint32_t best = 0;
    for (uint32_t i = 1; i < count; i++)
        if (least[i] * errors[i] > least[best] * errors[best]) best = i;
    return best;
}

static void take(const struct vw_known_photos *known, const struct vw_camera_path *candidates, uint32_t pick,
                 double *least) {
    for (uint32_t i = 0; i < candidates->count; i++)
        least[i] = fmin(least[i], vw_view_apart(&known->scales, &candidates->frames[pick], &candidates->frames[i]));
    least[pick] = PICKED;
}

enum vw_status vw_farthest_pick(const struct vw_known_photos *known, const struct vw_camera_path *candidates,
                                uint32_t wanted, uint32_t *picks, double *gains, double *first_gains) {
    uint32_t count = candidates->count;
    double *least = vw_allocate(count, sizeof *least), *errors = vw_allocate(count, sizeof *errors);
    bool made = least && errors;
    for (uint32_t i = 0; i < count && made; i++) {
        const struct vw_view *pose = &candidates->frames[i];
        vw_view_nearest(known->scene, &known->scales, known->views, known->count, pose, &least[i]);
        errors[i] = error_at(known, pose);
        first_gains[i] = least[i] * errors[i];
    }
    for (uint32_t k = 0; k < wanted && made; k++) {
        picks[k] = find_best(least, errors, count);
        gains[k] = least[picks[k]] * errors[picks[k]];
        take(known, candidates, picks[k], least);
    }
    free(least);
    free(errors);
    return made ? VW_OK : VW_ERROR_MEMORY;
}
