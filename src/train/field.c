#include "train/field.h"

#include <stdlib.h>
#include <string.h>

#include "train/effects/appearance.h"
#include "train/effects/contraction.h"
#include "gpu/shaders.h"
#include "train/pixels.h"
#include "gpu/compute.h"
#include "base/memory.h"

enum { EVALUATOR_CHUNK_SAMPLES = 1 << 16 }; // 1 MiB of samples at a time

const char evaluator_role[] = "validation";

struct vw_gpu_camera field_camera(const struct model *model, const struct vw_view *view, const struct vw_box *box) {
    struct vw_gpu_camera camera = pixels_camera(view, box);
    if (model->specialization.effect_unbounded) contraction_set_depths(view, box, &camera);
    return camera;
}

const struct vw_shader *field_forward_shader(const struct model *model) {
    return model->half_grid ? &vw_shader_forward_field_half : &vw_shader_forward_field;
}

static enum vw_status create_cameras(struct field *field, const struct vw_scene *scene) {
    uint64_t size_bytes = sizeof(struct vw_gpu_camera) * scene->view_count;
    struct vw_gpu_camera *cameras = vw_allocate(scene->view_count, sizeof *cameras);
    if (!cameras) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++)
        cameras[i] = field_camera(field->model, &scene->views[i], &field->model->box);
    enum vw_status status = vw_buffer_create(
        field->gpu, &(struct vw_buffer_params){.name = "cameras", .size_bytes = size_bytes}, &field->cameras);
    if (status == VW_OK) status = vw_buffer_write(field->cameras, 0, cameras, size_bytes);
    free(cameras);
    return status;
}

static enum vw_status create_params(struct field *field, uint64_t seed) {
    const struct model *model = field->model;
    void *initial = vw_allocate(model->param_bytes, 1);
    if (!initial) return VW_ERROR_MEMORY;
    model_initialise(model, seed, initial);
    enum vw_status status = vw_buffer_create(
        field->gpu, &(struct vw_buffer_params){.name = "params", .size_bytes = model->param_bytes}, &field->params);
    if (status == VW_OK) status = vw_buffer_write(field->params, 0, initial, model->param_bytes);
    free(initial);
    return status;
}

enum vw_status field_create(struct vw_gpu *gpu, const struct model *model, const struct vw_scene *scene, uint64_t seed,
                            struct field *field) {
    *field = (struct field){.gpu = gpu, .model = model};
    uint64_t chunk = model->specialization.chunk_samples;
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } scratch[] = {
        {&field->rows, {.name = "rows", .size_bytes = 16 * (uint64_t)VW_ROW_STRIDE(chunk) * model->row_count}},
        {&field->relu, {.name = "relu", .size_bytes = 16 * chunk}},
        {&field->step_state, {.name = "step_state", .size_bytes = sizeof(struct vw_step_state)}},
    };
    enum vw_status status = create_cameras(field, scene);
    if (status == VW_OK) status = create_params(field, seed);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scratch) && status == VW_OK; i++)
        status = vw_buffer_create(gpu, &scratch[i].params, scratch[i].buffer);
    if (status == VW_OK && model->specialization.effect_occupancy)
        status =
            vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "occupancy", .size_bytes = 4 * VW_OCCUPANCY_CELLS},
                             &field->occupancy);
    if (status != VW_OK) field_destroy(field);
    return status;
}

void field_destroy(struct field *field) {
    vw_buffer_destroy(&field->params);
    vw_buffer_destroy(&field->cameras);
    vw_buffer_destroy(&field->rows);
    vw_buffer_destroy(&field->relu);
    vw_buffer_destroy(&field->step_state);
    vw_buffer_destroy(&field->occupancy);
}

// Where there is no sky, shared passes declare it but do not read it.
static struct vw_binding sky_binding(const struct field *field) {
    const struct param_range *sky = &field->model->sky;
    if (!sky->size_bytes) return (struct vw_binding){.slot = VW_SLOT_SKY, .buffer = field->step_state};
    return (struct vw_binding){
        .slot = VW_SLOT_SKY, .buffer = field->params, .offset_bytes = sky->offset_bytes, .size_bytes = sky->size_bytes};
}

void field_bind(const struct field *field, struct vw_binding *bindings, uint32_t *count) {
    const struct model *model = field->model;
    uint64_t binding_bytes = vw_gpu_get_limits(field->gpu)->storage_binding_bytes;
    uint64_t grid_bytes = model->grid.size_bytes;
    const struct vw_binding shared[] = {
        // Where the texel view gathers a grid larger than one storage binding, the storage view is declared but not
        // read.
        {.slot = VW_SLOT_GRID,
         .buffer = field->params,
         .size_bytes = grid_bytes < binding_bytes ? grid_bytes : binding_bytes},
        {.slot = VW_SLOT_GRID_TEXEL,
         .buffer = field->params,
         .size_bytes = grid_bytes,
         .texel = model->half_grid ? VW_TEXEL_HALF2 : VW_TEXEL_FLOAT2},
        {.slot = VW_SLOT_WEIGHTS,
         .buffer = field->params,
         .offset_bytes = model->weights.offset_bytes,
         .size_bytes = 16 * (uint64_t)model->moved_columns},
        sky_binding(field),
        {.slot = VW_SLOT_CAMERAS, .buffer = field->cameras},
        {.slot = VW_SLOT_ROWS, .buffer = field->rows},
        {.slot = VW_SLOT_ROWS_TEXEL, .buffer = field->rows, .texel = VW_TEXEL_FLOAT4},
        {.slot = VW_SLOT_RELU, .buffer = field->relu},
        {.slot = VW_SLOT_STEP_STATE, .buffer = field->step_state},
    };
    memcpy(bindings + *count, shared, sizeof shared);
    *count += VW_ARRAY_COUNT(shared);
}

static enum vw_status create_evaluator_buffers(uint32_t rays, struct evaluator *evaluator) {
    struct vw_gpu *gpu = evaluator->field->gpu;
    uint64_t samples = (uint64_t)evaluator->chunk_rays * evaluator->field->model->specialization.samples;
    const struct {
        struct vw_buffer **buffer;
        struct vw_buffer_params params;
    } buffers[] = {
        {&evaluator->pixels,
         {.name = "evaluated_pixels", .size_bytes = sizeof(struct vw_pixel) * rays, .memory = VW_BUFFER_UPLOAD}},
        {&evaluator->rays, {.name = "evaluated_rays", .size_bytes = sizeof(struct vw_ray) * evaluator->ray_count}},
        {&evaluator->samples, {.name = "evaluated_samples", .size_bytes = 16 * samples}},
        {&evaluator->colours, {.name = "colours", .size_bytes = 16 * (uint64_t)evaluator->ray_count}},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(buffers) && status == VW_OK; i++)
        status = vw_buffer_create(gpu, &buffers[i].params, buffers[i].buffer);
    return status;
}

static enum vw_status create_evaluator_passes(struct evaluator *evaluator) {
    struct vw_specialization specialization = evaluator->field->model->specialization;
    specialization.training = 0;
    specialization.effect_occupancy = 0; // decision 1: nothing is skipped
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_PIXELS, .buffer = evaluator->pixels},
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
        {.slot = VW_SLOT_FIELD, .buffer = evaluator->samples},
        {.slot = VW_SLOT_COLOURS, .buffer = evaluator->colours},
        {.slot = VW_SLOT_KEPT_SAMPLES, .buffer = evaluator->field->cameras}, // declared, not read
    };
    uint32_t count = 5;
    field_bind(evaluator->field, bindings, &count);
    appearance_bind(evaluator->field, NULL, bindings, &count);
    const struct {
        const struct vw_shader *shader;
        struct vw_pass **pass;
    } passes[] = {
        {&vw_shader_generate_rays, &evaluator->generate},
        {field_forward_shader(evaluator->field->model), &evaluator->forward},
        {&vw_shader_composite_rays, &evaluator->composite},
    };
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < VW_ARRAY_COUNT(passes) && status == VW_OK; i++) {
        struct vw_pass_params params = {.shader = passes[i].shader,
                                        .specialization = (const uint32_t *)&specialization,
                                        .specialization_count = VW_SPECIALIZATION_COUNT,
                                        .bindings = bindings,
                                        .binding_count = count,
                                        .role = evaluator_role};
        status = vw_pass_create(evaluator->field->gpu, &params, passes[i].pass);
    }
    return status;
}

enum vw_status evaluator_create(struct field *field, uint32_t rays, struct evaluator *evaluator) {
    const struct model *model = field->model;
    *evaluator = (struct evaluator){.field = field, .ray_count = model_pad_rays(model, rays)};
    uint32_t chunk_rays = EVALUATOR_CHUNK_SAMPLES / model->specialization.samples / model->ray_group * model->ray_group;
    if (chunk_rays < model->ray_group) chunk_rays = model->ray_group;
    evaluator->chunk_rays = chunk_rays < evaluator->ray_count ? chunk_rays : evaluator->ray_count;
    enum vw_status status = create_evaluator_buffers(rays, evaluator);
    if (status == VW_OK) status = create_evaluator_passes(evaluator);
    if (status == VW_OK) status = vw_batch_create(field->gpu, &evaluator->batch);
    if (status != VW_OK) evaluator_destroy(evaluator);
    return status;
}

void evaluator_destroy(struct evaluator *evaluator) {
    vw_batch_destroy(&evaluator->batch);
    vw_pass_destroy(&evaluator->generate);
    vw_pass_destroy(&evaluator->forward);
    vw_pass_destroy(&evaluator->composite);
    vw_buffer_destroy(&evaluator->pixels);
    vw_buffer_destroy(&evaluator->rays);
    vw_buffer_destroy(&evaluator->samples);
    vw_buffer_destroy(&evaluator->colours);
}

enum vw_status evaluator_set_pixels(struct evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    memcpy(vw_buffer_map(evaluator->pixels), pixels, count * sizeof *pixels);
    struct vw_push_rays push = {.first_pixel = 0, .ray_count = count};
    vw_batch_begin(evaluator->batch);
    vw_batch_dispatch(evaluator->batch, evaluator->generate, &push, sizeof push, evaluator->ray_count);
    enum vw_status status = vw_batch_submit(evaluator->batch);
    return status == VW_OK ? vw_batch_wait(evaluator->batch) : status;
}

void evaluator_record(const struct evaluator *evaluator, struct vw_batch *batch) {
    uint32_t samples = evaluator->field->model->specialization.samples;
    for (uint32_t first = 0; first < evaluator->ray_count; first += evaluator->chunk_rays) {
        uint32_t left = evaluator->ray_count - first;
        struct vw_push_samples push = {.first_ray = first,
                                       .ray_count = left < evaluator->chunk_rays ? left : evaluator->chunk_rays};
        vw_batch_dispatch(batch, evaluator->forward, &push, sizeof push, (uint64_t)push.ray_count * samples);
        vw_batch_dispatch(batch, evaluator->composite, &push, sizeof push, push.ray_count);
    }
}

enum vw_status evaluator_run(struct evaluator *evaluator) {
    vw_batch_begin(evaluator->batch);
    evaluator_record(evaluator, evaluator->batch);
    enum vw_status status = vw_batch_submit(evaluator->batch);
    return status == VW_OK ? vw_batch_wait(evaluator->batch) : status;
}

enum vw_status evaluator_render(struct evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count,
                                vw_float4 *colours) {
    enum vw_status status = evaluator_set_pixels(evaluator, pixels, count);
    if (status == VW_OK) status = evaluator_run(evaluator);
    return status == VW_OK ? vw_buffer_read(evaluator->colours, 0, colours, count * sizeof *colours) : status;
}
