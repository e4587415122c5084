#include "train/effects/ray_network.h"

#include "base/memory.h"
#include "train/step_passes.h"

void vw_ray_network_initialise(const struct vw_ray_network *sizes, const struct vw_drawn *drawn, float *values) {
    vw_fill_matrix(values, drawn, VISIBILITY4, sizes->input4);
    vw_fill_matrix(values + 4 * sizes->layer2, drawn, VISIBILITY4, VISIBILITY4);
    vw_fill_weights(values + 4 * sizes->logit, drawn, 4 * VISIBILITY4, 0.5f / VISIBILITY4);
}

static uint32_t groups_of(uint32_t rays) { return (rays + VISIBILITY_GROUP - 1) / VISIBILITY_GROUP; }

uint32_t vw_ray_network_list_buffers(const struct vw_ray_network *sizes, uint32_t padded_rays,
                                     struct vw_effect_buffer *buffers) {
    uint64_t rays = padded_rays, groups = groups_of(padded_rays);
    buffers[0] =
        (struct vw_effect_buffer){VW_SLOT_VISIBILITY, "visibility", 2 * sizeof(float) * rays, VW_EFFECT_OF_STEP};
    buffers[1] = (struct vw_effect_buffer){VW_SLOT_VISIBILITY_PARTIALS, "visibility_partials",
                                           sizeof(vw_float4) * sizes->columns * groups, VW_EFFECT_OF_STEP};
    return 2;
}

void vw_ray_network_record_rays(const struct vw_step_passes *step, struct vw_pass *const *passes,
                                struct vw_submission *submission, const struct vw_push_rays *rays) {
    vw_submission_dispatch(submission, passes[VW_RAY_NETWORK_PREDICT], rays, sizeof *rays, step->padded_rays);
}

void vw_ray_network_record_gradient(const struct vw_ray_network *sizes, const struct vw_step_passes *step,
                                    struct vw_pass *const *passes, struct vw_submission *submission,
                                    const struct vw_push_rays *rays) {
    uint32_t padded_rays = vw_model_pad_rays(step->field->model, rays->ray_count);
    struct vw_push_reduce reduce = {.count = groups_of(padded_rays)};
    vw_submission_dispatch(submission, passes[VW_RAY_NETWORK_GRADIENT], rays, sizeof *rays, padded_rays);
    vw_submission_dispatch(submission, passes[VW_RAY_NETWORK_REDUCE], &reduce, sizeof reduce, sizes->columns);
}
