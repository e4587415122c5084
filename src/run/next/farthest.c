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

// Computes distance and error of each candidate, and what it gains alone.
static void measure(const struct vw_known_photos *known, struct vw_next *next, double *least, double *errors) {
    for (uint32_t i = 0; i < next->candidates.count; i++) {
        const struct vw_view *pose = &next->candidates.frames[i];
        vw_view_nearest(known->scene, &known->scales, known->views, known->count, pose, &least[i]);
        errors[i] = error_at(known, pose);
        next->first_gains[i] = least[i] * errors[i];
    }
}

static void pick(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next, double *least,
                 double *errors) {
    for (; next->proposal_count < wanted; next->proposal_count++) {
        uint32_t best = find_best(least, errors, next->candidates.count);
        next->proposals[next->proposal_count] =
            (struct vw_proposal){.pose = &next->candidates.frames[best], .gain = least[best] * errors[best]};
        take(known, &next->candidates, best, least);
    }
}

enum vw_status vw_farthest_pick(const struct vw_known_photos *known, uint32_t wanted, struct vw_next *next) {
    uint32_t count = next->candidates.count;
    double *least = vw_allocate(count, sizeof *least), *errors = vw_allocate(count, sizeof *errors);
    next->first_gains = vw_allocate(count, sizeof *next->first_gains);
    next->proposals = vw_allocate(wanted, sizeof *next->proposals);
    bool made = least && errors && next->first_gains && next->proposals;
    if (made) measure(known, next, least, errors);
    if (made) pick(known, wanted < count ? wanted : count, next, least, errors);
    free(least);
    free(errors);
    return made ? VW_OK : VW_ERROR_MEMORY;
}
