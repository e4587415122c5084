#include "train/importance.h"

#include "gpu/shaders.h"

const char even_role[] = "even samples", even_validation_role[] = "even samples, validation";

enum vw_status vw_importance_create_places(const struct vw_radiance_field *field, uint32_t rays,
                                           struct vw_buffer **places) {
    const struct vw_specialization *s = &field->model->specialization;
    if (!s->importance) return VW_OK;
    const struct vw_buffer_params params = {.name = "sample_places", .size_bytes = 4 * (uint64_t)rays * s->samples};
    return vw_buffer_create(field->gpu, &params, places);
}

static struct vw_specialization specialise(const struct vw_model *model, const struct vw_specialization *of_step) {
    struct vw_specialization even = *of_step;
    even.samples = even.strata;
    even.importance = even.stores_rows = 0;
    even.effect_transient = 0; // places are where the field itself has matter, as in NeRF-W
    if (model->coarse_columns) even.effect_appearance_code = even.effect_appearance_encoder = 0; // no codes, as there
    return even;
}

enum vw_status vw_importance_create(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    const struct vw_shader *backward_rays, struct vw_importance *importance) {
    const struct vw_model *model = field->model;
    if (!params->specialization->importance) return VW_OK;
    const struct vw_specialization even = specialise(model, params->specialization);
    struct vw_field_pass_params of_even = *params;
    of_even.specialization = &even;
    of_even.backward = backward_rays && model->coarse_columns;
    of_even.role = params->role ? even_validation_role : even_role;
    importance->even.specialization = even;
    importance->even.first_column = model->coarse_column;
    enum vw_status status = model->kind->create_passes(field, &of_even, &importance->even);
    if (!status && of_even.backward)
        status = vw_field_pass_create(field->gpu, &of_even, backward_rays, &even, &importance->backward_rays);
    return !status ? vw_field_pass_create(field->gpu, params, &vw_shader_place_samples, params->specialization,
                                          &importance->place)
                   : status;
}

void vw_importance_destroy(struct vw_importance *importance) {
    vw_field_passes_destroy(&importance->even);
    vw_pass_destroy(&importance->place);
    vw_pass_destroy(&importance->backward_rays);
}

void vw_importance_record(const struct vw_model *model, const struct vw_importance *importance,
                          struct vw_submission *batch, const struct vw_push_samples *chunk) {
    if (!importance->place) return;
    const struct vw_field_chunk samples = {.rays = chunk};
    model->kind->record_forward(model, &importance->even, batch, &samples);
    vw_submission_dispatch(batch, importance->place, chunk, sizeof *chunk, chunk->ray_count);
    if (!importance->backward_rays) return;
    // Into the buffers of the step, which its own backward_rays overwrites: so the step's loss, and the gradients of
    // the sky and of what belongs to photos, are those of the placed samples.
    vw_submission_dispatch(batch, importance->backward_rays, chunk, sizeof *chunk, chunk->ray_count);
    model->kind->record_backward(model, &importance->even, batch, &samples);
}
