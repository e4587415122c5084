// The diagonal of the Fisher information of what a pose sees: by param, the sum over the pixels of a coarse picture and
// their channels of the squared slope of the colour, sum (d colour / d param)^2.
//
// It comes from a few backward passes: a gradient of the sum of colours with random signs, squared, has that mean
// (Hutchinson 1990; Bekas et al. 2007). The same signs are drawn for every pose.
#ifndef VIEWWORTH_RUN_NEXT_FISHER_DIAGONAL_H
#define VIEWWORTH_RUN_NEXT_FISHER_DIAGONAL_H

#include "run/next/candidate_scores.h"
#include "train/adjoint/adjoint_passes.h"

enum { VW_FISHER_RAYS_MOST = 192, VW_FISHER_DRAWS = 4 };

struct vw_fisher {
    struct vw_radiance_field *field; // borrowed
    struct vw_adjoint_passes passes;
    struct vw_evaluator evaluator;
    struct vw_submission *submission;
    struct vw_ray *rays;  // owned
    float *gradient;      // owned
    uint64_t param_count; // floats of the params block
    uint32_t view, draws;
    uint32_t ray_count; // rays of a pose, at most; no more than validation has
};

// Refuses, naming the reason, a field or an effect that has no backward pass from given slopes (VW_ERROR_USAGE). The
// trainer validates. Destroy it also after a failure.
enum vw_status vw_fisher_create(const struct vw_known_views *known, uint32_t draws, struct vw_fisher *fisher);
void vw_fisher_destroy(struct vw_fisher *fisher);
// Adds the diagonal of a pose to `diagonal`, by param.
enum vw_status vw_fisher_add(struct vw_fisher *fisher, const struct vw_view *pose, float *diagonal);

#endif
