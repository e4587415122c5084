// Networks that say how much a ray counts, of `visibility` and of `uncertainty` (shaders/effects/ray_network.glsl).
#ifndef VIEWWORTH_TRAIN_EFFECTS_RAY_NETWORK_H
#define VIEWWORTH_TRAIN_EFFECTS_RAY_NETWORK_H

#include "train/effects/kind.h"

// The sizes of such a network.
struct vw_ray_network {
    uint32_t input4, layer2, logit, columns, params;
    uint32_t code4; // the inputs / 4 that are the same for all rays
};

enum { VW_RAY_NETWORK_PREDICT, VW_RAY_NETWORK_GRADIENT, VW_RAY_NETWORK_REDUCE }; // places of its passes

// Draws its initial values: every ray counts about half.
void vw_ray_network_initialise(const struct vw_ray_network *network, const struct vw_drawn *drawn, float *values);
// Lists its buffers for a step of so many rays; returns how many.
uint32_t vw_ray_network_list_buffers(const struct vw_ray_network *network, uint32_t padded_rays,
                                     struct vw_effect_buffer *buffers);
void vw_ray_network_record_rays(const struct vw_step_passes *step, struct vw_pass *const *passes,
                                struct vw_submission *submission, const struct vw_push_rays *rays);
void vw_ray_network_record_gradient(const struct vw_ray_network *network, const struct vw_step_passes *step,
                                    struct vw_pass *const *passes, struct vw_submission *submission,
                                    const struct vw_push_rays *rays);

#endif
