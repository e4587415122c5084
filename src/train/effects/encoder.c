#include "train/effects/encoder.h"

#include "gpu/shaders.h"
#include "train/field.h"
#include "train/passes.h"

struct vw_param_range vw_encoder_network(const struct vw_model *model) {
    const struct vw_specialization *s = &model->specialization;
    if (!s->effect_appearance_encoder) return (struct vw_param_range){0};
    return vw_model_columns(model, s->encoder_column, VW_ENCODER_COLUMNS(s->width4));
}

enum vw_status vw_encoder_set_thumbnail(const struct vw_radiance_field *field, const struct vw_scene *scene,
                                        uint32_t view, const struct vw_thumbnail_choice *choice) {
    vw_float4 thumbnail[THUMBNAIL_PIXELS];
    if (!field->model->specialization.effect_appearance_encoder) return VW_OK;
    vw_thumbnail_make(&scene->views[view], choice, thumbnail);
    return vw_buffer_write(field->effect_buffers[VW_SLOT_THUMBNAILS], (uint64_t)view * sizeof thumbnail, thumbnail,
                           sizeof thumbnail);
}

enum vw_status vw_encoder_create_passes(struct vw_gpu_objects *objects, const struct vw_pass_params *common, bool back,
                                        struct vw_effect_passes *set) {
    const struct vw_pass_row rows[ENCODER_PASSES] = {
        {&vw_shader_convolve_photo, &set->passes[ENCODER_CONVOLVE]},
        {&vw_shader_pool_photo, &set->passes[ENCODER_POOL]},
        {&vw_shader_spread_photo_codes, &set->passes[ENCODER_SPREAD]},
        {&vw_shader_convolve_photo_back, &set->passes[ENCODER_CONVOLVE_BACK]},
        {&vw_shader_gradient_photo, &set->passes[ENCODER_GRADIENT]},
    };
    return vw_passes_create(objects, common, rows, back ? ENCODER_PASSES : ENCODER_SPREAD);
}

void vw_encoder_record_forward(struct vw_pass *const *passes, struct vw_submission *batch, uint32_t view) {
    struct vw_push_photo push = {.view = view};
    for (; push.layer < ENCODER_LAYERS; push.layer++)
        vw_submission_dispatch(batch, passes[ENCODER_CONVOLVE], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * (push.layer + 1));
    vw_submission_dispatch(batch, passes[ENCODER_POOL], NULL, 0, 1);
}

void vw_encoder_record_back(struct vw_pass *const *passes, const struct vw_push_codes *codes,
                            struct vw_submission *batch) {
    struct vw_push_photo push = {.layer = ENCODER_LAYERS - 1};
    vw_submission_dispatch(batch, passes[ENCODER_SPREAD], codes, codes ? sizeof *codes : 0, 1);
    for (; push.layer > 0; push.layer--)
        vw_submission_dispatch(batch, passes[ENCODER_CONVOLVE_BACK], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * push.layer);
    vw_submission_dispatch(batch, passes[ENCODER_GRADIENT], NULL, 0, ENCODER_CODE);
}
