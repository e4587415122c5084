#include "train/field.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "train/effects/effects.h"
#include "train/effects/field_box.h"
#include "train/passes.h"
#include "train/pixels.h"
#include "train/renderers/registry.h"

struct vw_gpu_camera vw_field_camera(const struct vw_model *model, const struct vw_view *view,
                                     const struct vw_box *box) {
    struct vw_gpu_camera camera = vw_pixels_camera(view, box);
    if (model->specialization.effect_unbounded) vw_contraction_set_depths(view, box, &camera);
    return camera;
}

static enum vw_status fill_cameras(const struct vw_radiance_field *field, const struct vw_scene *scene) {
    struct vw_gpu_camera *cameras = vw_allocate(scene->view_count, sizeof *cameras);
    if (!cameras) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++)
        cameras[i] = vw_field_camera(field->model, &scene->views[i], &field->model->box);
    enum vw_status status = vw_buffer_write(field->cameras, 0, cameras, sizeof *cameras * scene->view_count);
    free(cameras);
    return status;
}

const struct vw_view *vw_field_view(const struct vw_radiance_field *field, uint32_t view) {
    return field->posed && view == field->posed_view ? field->posed : &field->scene->views[view];
}

enum vw_status vw_field_pose(struct vw_radiance_field *field, uint32_t view, const struct vw_view *posed) {
    field->posed = posed;
    field->posed_view = view;
    const struct vw_gpu_camera camera = vw_field_camera(field->model, vw_field_view(field, view), &field->model->box);
    return vw_buffer_write(field->cameras, view * sizeof camera, &camera, sizeof camera);
}

enum vw_status vw_model_initialise(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                   void *params) {
    uint64_t end = model->weights.offset_bytes + model->weights.size_bytes;
    const struct vw_drawn drawn = {(float *)((char *)params + model->weights.offset_bytes), model->drawn_before_weights,
                                   seed};
    memset((char *)params + end, 0, model->param_bytes - end);
    enum vw_status status = model->renderer->initialise(model, scene, &drawn, params);
    if (!status) status = vw_effects_initialise(model, scene, &drawn, params);
    return status;
}

static enum vw_status fill_params(const struct vw_radiance_field *field, uint64_t seed) {
    void *initial = vw_allocate(field->model->param_bytes, 1);
    if (!initial) return VW_ERROR_MEMORY;
    enum vw_status status = vw_model_initialise(field->model, field->scene, seed, initial);
    if (!status) status = vw_buffer_write(field->params, 0, initial, field->model->param_bytes);
    free(initial);
    return status;
}

enum vw_status vw_field_create(struct vw_gpu *gpu, const struct vw_model *model, const struct vw_scene *scene,
                               uint64_t seed, struct vw_radiance_field *field) {
    *field = (struct vw_radiance_field){.gpu = gpu, .objects = {.gpu = gpu}, .model = model, .scene = scene};
    const struct vw_buffer_row buffers[] = {
        {&field->cameras, "cameras", sizeof(struct vw_gpu_camera) * scene->view_count},
        {&field->params, "params", model->param_bytes},
        {&field->step_state, "step_state", sizeof(struct vw_step_state)},
    };
    enum vw_status status = vw_buffers_create(&field->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (!status && model->renderer->create_field) status = model->renderer->create_field(field);
    if (!status) status = fill_cameras(field, scene);
    if (!status) status = fill_params(field, seed);
    if (!status) status = vw_effects_create_buffers(model, &field->objects, true, 0, 0, field->effect_buffers);
    if (!status) status = vw_effects_fill(model, gpu, scene, field->effect_buffers);
    if (status) vw_field_destroy(field);
    return status;
}

void vw_field_destroy(struct vw_radiance_field *field) { vw_gpu_objects_destroy(&field->objects); }

void vw_field_bind(const struct vw_radiance_field *field, bool training, struct vw_binding *bindings, uint32_t *count) {
    const struct vw_model *model = field->model;
    const struct vw_binding shared[] = {
        {.slot = VW_SLOT_WEIGHTS,
         .buffer = field->params,
         .offset_bytes = model->weights.offset_bytes,
         .size_bytes = 16 * (uint64_t)model->moved_columns},
        {.slot = VW_SLOT_CAMERAS, .buffer = field->cameras},
        {.slot = VW_SLOT_STEP_STATE, .buffer = field->step_state, .unused = !training}, // unread then
    };
    memcpy(bindings + *count, shared, sizeof shared);
    *count += VW_ARRAY_COUNT(shared);
    if (model->renderer->bind_field) model->renderer->bind_field(field, training, bindings, count);
}
