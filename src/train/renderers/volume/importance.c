// Importance samples: a first pass of even samples, from whose weights the second pass places its own.
#include "gpu/shaders.h"
#include "train/fields/registry.h"
#include "train/model.h"
#include "train/passes.h"
#include "train/renderers/volume/volume.h"

static const char even_role[] = "even samples", even_validation_role[] = "even samples, validation";

uint64_t vw_importance_places_bytes(const struct vw_model *model, uint32_t rays) {
    return model->specialization.importance ? 4 * (uint64_t)rays * model->specialization.samples : 0;
}

static struct vw_specialization specialise_even(const struct vw_model *model, const struct vw_specialization *of_step) {
    struct vw_specialization even = *of_step;
    even.samples = even.strata;
    even.importance = even.stores_rows = 0;
    even.effect_transient = 0; // places are where the field itself has matter, as in NeRF-W
    if (vw_volume_of(model)->coarse_columns)
        even.effect_appearance_code = even.effect_appearance_encoder = 0; // no codes, as there
    return even;
}

enum vw_status vw_importance_create(const struct vw_radiance_field *field, const struct vw_field_pass_params *params,
                                    const struct vw_specialization *specialization,
                                    const struct vw_shader *backward_rays, struct vw_importance *importance) {
    const struct vw_model *model = field->model;
    const struct vw_volume_model *volume = vw_volume_of(model);
    if (!specialization->importance) return VW_OK;
    struct vw_field_pass_params of_even = *params;
    importance->even.specialization = specialise_even(model, specialization);
    importance->even.first_column = volume->coarse_column;
    of_even.common.specialization = (const uint32_t *)&importance->even.specialization;
    of_even.common.role = params->common.role ? even_validation_role : even_role;
    of_even.backward = backward_rays && volume->coarse_columns;
    enum vw_status status = volume->kind->create_passes(field, &of_even, &importance->even);
    if (!status && of_even.backward)
        status = vw_pass_create_of(params->objects, &of_even.common, backward_rays, &importance->backward_rays);
    return !status ? vw_pass_create_of(params->objects, &params->common, &vw_shader_place_samples, &importance->place)
                   : status;
}

void vw_importance_record(const struct vw_model *model, const struct vw_importance *importance,
                          struct vw_submission *submission, const struct vw_push_samples *chunk) {
    if (!importance->place) return;
    const struct vw_field_kind *kind = vw_volume_of(model)->kind;
    kind->record_forward(model, &importance->even, submission, chunk);
    uint64_t lanes = (uint64_t)chunk->ray_count * model->specialization.ray_lanes;
    vw_submission_dispatch(submission, importance->place, chunk, sizeof *chunk, lanes);
    if (!importance->backward_rays) return;
    // Into the buffers of the step, which its own backward_rays overwrites: so the step's loss, and the gradients of
    // the sky and of what belongs to photos, are those of the placed samples.
    vw_submission_dispatch(submission, importance->backward_rays, chunk, sizeof *chunk, lanes);
    kind->record_backward(model, &importance->even, submission, chunk);
}
