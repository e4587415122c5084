#include "train/importance.h"

#include "gpu/shaders.h"

const char even_role[] = "even samples", even_validation_role[] = "even samples, validation";

enum vw_status importance_create_places(const struct field *field, uint32_t rays, struct vw_buffer **places) {
    const struct vw_specialization *s = &field->model->specialization;
    if (!s->importance) return VW_OK;
    const struct vw_buffer_params params = {.name = "sample_places", .size_bytes = 4 * (uint64_t)rays * s->samples};
    return vw_buffer_create(field->gpu, &params, places);
}

enum vw_status importance_create(const struct field *field, const struct field_pass_params *params,
                                 struct importance *importance) {
    struct vw_specialization even = *params->specialization;
    if (!even.importance) return VW_OK;
    struct field_pass_params of_even = *params;
    even.samples = even.strata;
    even.importance = even.stores_rows = 0;
    even.effect_transient = 0; // places are where the field itself has matter, as in NeRF-W
    of_even.specialization = &even;
    of_even.backward = false;
    of_even.role = params->role ? even_validation_role : even_role;
    importance->even.specialization = even;
    enum vw_status status = field->model->kind->create_passes(field, &of_even, &importance->even);
    return status == VW_OK ? field_pass_create(field->gpu, params, &vw_shader_place_samples, params->specialization,
                                               &importance->place)
                           : status;
}

void importance_destroy(struct importance *importance) {
    field_passes_destroy(&importance->even);
    vw_pass_destroy(&importance->place);
}

void importance_record(const struct model *model, const struct importance *importance, struct vw_batch *batch,
                       const struct vw_push_samples *chunk) {
    if (!importance->place) return;
    model->kind->record_forward(model, &importance->even, batch, &(struct field_chunk){.rays = chunk});
    vw_batch_dispatch(batch, importance->place, chunk, sizeof *chunk, chunk->ray_count);
}
