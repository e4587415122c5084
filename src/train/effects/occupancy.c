#include "train/effects/occupancy.h"

#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"

// Of a cell's density, at each refresh. Short runs begin with fog everywhere, which at 0.95 (instant-ngp's) would take
// 1,000 steps to be forgotten; a surface of density 30 is still believed after 20 refreshes that miss it.
static const float REMAINS = 0.8f;

_Static_assert(VW_OCCUPANCY_CELLS == VW_OCCUPANCY_SIDE * VW_OCCUPANCY_SIDE * VW_OCCUPANCY_SIDE, "cells fill a cube");
_Static_assert(VW_OCCUPANCY_CELLS % VW_FIELD_GROUP == 0, "cells fill workgroups");

enum vw_status vw_occupancy_create_buffers(const struct vw_radiance_field *field,
                                           struct vw_occupancy_effect *occupancy) {
    const struct vw_specialization *s = &field->model->specialization;
    uint64_t rays = s->chunk_samples / s->samples;
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&occupancy->bits, {.name = "kept_bits", .size_bytes = 4 * rays * VW_KEPT_WORDS(s->samples)}},
        {&occupancy->begins, {.name = "kept_begins", .size_bytes = 4 * (rays + 1)}},
        {&occupancy->kept_samples, {.name = "kept_samples", .size_bytes = 4 * (uint64_t)s->chunk_samples}},
        {&occupancy->kept, {.name = "kept", .size_bytes = sizeof(struct vw_kept)}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && !status; i++)
        status = vw_buffer_create(field->gpu, &buffers[i].params, buffers[i].buffer);
    return status;
}

void vw_occupancy_bind(const struct vw_radiance_field *field, const struct vw_occupancy_effect *occupancy,
                       struct vw_binding *bindings, uint32_t *count) {
    bool off = occupancy->kept == NULL;
    const struct vw_binding bound[] = {
        {.slot = VW_SLOT_OCCUPANCY, .buffer = field->occupancy, .unused = off},
        {.slot = VW_SLOT_KEPT_BITS, .buffer = occupancy->bits, .unused = off},
        {.slot = VW_SLOT_KEPT_BEGINS, .buffer = occupancy->begins, .unused = off},
        {.slot = VW_SLOT_KEPT, .buffer = occupancy->kept, .unused = off},
    };
    memcpy(bindings + *count, bound, sizeof bound);
    *count += VW_ARRAY_COUNT(bound);
}

static enum vw_status create_pass(const struct vw_radiance_field *field, const struct vw_shader *shader,
                                  const struct vw_binding *bindings, uint32_t count, struct vw_pass **pass) {
    struct vw_pass_params params = {.shader = shader,
                                    .specialization = (const uint32_t *)&field->model->specialization,
                                    .specialization_count = VW_SPECIALIZATION_COUNT,
                                    .bindings = bindings,
                                    .binding_count = count};
    return vw_pass_create(field->gpu, &params, pass);
}

enum vw_status vw_occupancy_create_passes(const struct vw_radiance_field *field, const struct vw_binding *bindings,
                                          uint32_t count, struct vw_occupancy_effect *occupancy) {
    const struct vw_shader *refresh =
        field->model->half_grid ? &vw_shader_refresh_occupancy_half : &vw_shader_refresh_occupancy;
    enum vw_status status = create_pass(field, refresh, bindings, count, &occupancy->refresh);
    if (!status) status = create_pass(field, &vw_shader_mark_samples, bindings, count, &occupancy->mark);
    if (!status) status = create_pass(field, &vw_shader_place_rays, bindings, count, &occupancy->place);
    if (!status) status = create_pass(field, &vw_shader_list_samples, bindings, count, &occupancy->list);
    return status;
}

void vw_occupancy_destroy(struct vw_occupancy_effect *occupancy) {
    vw_pass_destroy(&occupancy->refresh);
    vw_pass_destroy(&occupancy->mark);
    vw_pass_destroy(&occupancy->place);
    vw_pass_destroy(&occupancy->list);
    vw_buffer_destroy(&occupancy->bits);
    vw_buffer_destroy(&occupancy->begins);
    vw_buffer_destroy(&occupancy->kept_samples);
    vw_buffer_destroy(&occupancy->kept);
}

void vw_occupancy_record_refresh(const struct vw_occupancy_effect *occupancy, struct vw_submission *batch,
                                 uint64_t number, vw_uint4 key) {
    if (number % OCCUPANCY_STEPS) return;
    struct vw_push_refresh push = {.key = key, .remains = REMAINS};
    vw_submission_dispatch(batch, occupancy->refresh, &push, sizeof push, VW_OCCUPANCY_CELLS);
}

void vw_occupancy_record_chunk(const struct vw_occupancy_effect *occupancy, struct vw_submission *batch,
                               const struct vw_push_samples *push) {
    vw_submission_dispatch(batch, occupancy->mark, push, sizeof *push, push->ray_count);
    vw_submission_dispatch(batch, occupancy->place, push, sizeof *push, 1);
    vw_submission_dispatch(batch, occupancy->list, push, sizeof *push, push->ray_count);
}
