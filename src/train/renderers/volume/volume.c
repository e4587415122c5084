// The renderer `volume`: samples along rays, of which a field (train/fields/) makes colour and density, composited.
#include "train/renderers/volume/volume.h"

#include <assert.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/fields/registry.h"
#include "train/model.h"
#include "train/passes.h"
#include "train/renderers/registry.h"

static const struct vw_field_kind *const kinds[] = {[VW_FIELD_HASH] = &field_hash, [VW_FIELD_MLP] = &field_mlp};

static const uint64_t ROWS_BYTES_MAX = 1 << 28; // the rows of a chunk: enough samples to fill a large device

static uint32_t greatest_common_divisor(uint32_t a, uint32_t b) { return b ? greatest_common_divisor(b, a % b) : a; }

static enum vw_status specialise(struct vw_model *model) {
    const struct vw_config *config = model->config;
    struct vw_specialization *s = &model->specialization;
    struct vw_volume_model *volume = model->of_renderer = vw_allocate(1, sizeof *volume);
    if (!volume) return VW_ERROR_MEMORY;
    volume->kind = kinds[config->field];
    s->strata = config->samples;
    s->importance = config->importance_samples > 0;
    s->samples = s->importance ? config->importance_samples : s->strata;
    volume->ray_samples = s->samples > s->strata ? s->samples : s->strata;
    s->stores_rows = 1;
    return VW_OK;
}

static void lay_out(const struct vw_scene *scene, struct vw_model *model) {
    (void)scene;
    vw_volume_of(model)->kind->lay_out(model);
}

static void lay_out_unfollowed(struct vw_model *model) {
    struct vw_volume_model *volume = vw_volume_of(model);
    if (!volume->coarse_columns) return;
    volume->coarse_column = vw_model_append_columns(model, volume->coarse_columns, 0); // the field counts its params
    volume->coarse = vw_model_columns(model, volume->coarse_column, volume->coarse_columns);
}

static enum vw_status initialise(const struct vw_model *model, const struct vw_scene *scene,
                                 const struct vw_drawn *drawn, void *params) {
    (void)scene;
    vw_volume_of(model)->kind->initialise(model, drawn, params);
    return VW_OK;
}

// Chooses whole groups of rays whose rows fit into one binding, and no more than a step has.
static enum vw_status choose_chunk(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                                   struct vw_model *model) {
    const struct vw_volume_model *volume = vw_volume_of(model);
    uint32_t samples = volume->ray_samples, chunk = choices->chunk_samples, group_samples = model->ray_group * samples,
             step_samples = vw_model_pad_rays(model, model->config->rays) * samples;
    uint64_t row_bytes = (uint64_t)volume->row_bytes * volume->row_count,
             layer_row_bytes = (uint64_t)VW_LAYER_ROW_BYTES * volume->head_row_count,
             bytes = VW_ROWS_SIZE(row_bytes > layer_row_bytes ? row_bytes : layer_row_bytes, VW_FIELD_GROUP),
             most = limits->storage_binding_bytes < ROWS_BYTES_MAX ? limits->storage_binding_bytes : ROWS_BYTES_MAX;
    assert(group_samples > 0); // the configuration has samples
    if (bytes * (group_samples / VW_FIELD_GROUP) > limits->storage_binding_bytes)
        return vw_fail(
            VW_ERROR_USAGE,
            "--samples: %u per ray make groups of %u samples, too many for this device; take a multiple of 16", samples,
            group_samples);
    uint64_t fits = VW_FIELD_GROUP * (most / bytes);
    if (chunk > fits) chunk = (uint32_t)fits;
    if (chunk > step_samples) chunk = step_samples;
    model->specialization.chunk_samples = chunk < group_samples ? group_samples : chunk / group_samples * group_samples;
    return VW_OK;
}

static void specialise_for_device(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                                  struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    s->skip_zeros = choices->skip_zeros;
    s->slice_samples = choices->slice_samples;
    s->slice_parts = choices->slice_parts;
    s->ray_lanes = choices->ray_lanes;
    const struct vw_volume_model *volume = vw_volume_of(model);
    uint64_t rows = volume->row_count > volume->head_row_count ? volume->row_count : volume->head_row_count;
    s->rows_texel = choices->rows_texel && VW_ROWS_SIZE(rows, s->chunk_samples) <= limits->texel_elements;
}

static enum vw_status fit(const struct vw_device_choices *choices, const struct vw_gpu_limits *limits,
                          struct vw_model *model) {
    const struct vw_specialization *s = &model->specialization;
    uint32_t both = greatest_common_divisor(s->samples, s->strata); // the even samples fill whole workgroups, too
    model->ray_group = VW_FIELD_GROUP / greatest_common_divisor(VW_FIELD_GROUP, both);
    enum vw_status status = choose_chunk(choices, limits, model);
    if (status) return status;
    specialise_for_device(choices, limits, model);
    status = vw_volume_of(model)->kind->fit(choices, limits, model);
    model->renderer_flags = vw_volume_of(model)->window_count;
    return status;
}

// ---- The field's activations ----------------------------------------------------------------------------------------

static enum vw_status create_field(struct vw_radiance_field *field) {
    const struct vw_volume_model *volume = vw_volume_of(field->model);
    uint64_t chunk = field->model->specialization.chunk_samples;
    const struct vw_buffer_row buffers[] = {
        // buffers of another kind of field are not created
        {&field->rows, "rows", volume->row_bytes * VW_ROWS_SIZE((uint64_t)volume->row_count, chunk)},
        {&field->grid_rows, "grid_rows", VW_GRID_ROW_BYTES * VW_ROWS_SIZE(volume->grid_row_count, chunk)},
        {&field->head_rows, "head_rows", VW_LAYER_ROW_BYTES * VW_ROWS_SIZE(volume->head_row_count, chunk)},
        {&field->d_rows, "d_rows", VW_LAYER_ROW_BYTES * VW_ROWS_SIZE(volume->d_row_count, chunk)},
    };
    return vw_buffers_create(&field->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

static void bind_field(const struct vw_radiance_field *field, bool training, struct vw_binding *bindings,
                       uint32_t *count) {
    uint64_t binding_bytes = vw_gpu_get_limits(field->gpu)->storage_binding_bytes;
    uint64_t grid_bytes = vw_volume_of(field->model)->grid.size_bytes;
    bool grid = grid_bytes > 0, of_grid = grid && training; // rendering does not read its rows
    struct vw_buffer *layers = grid ? field->head_rows : field->rows;
    const struct vw_binding own[] = {
        // The storage view is declared but not read where the texel view gathers a grid larger than one storage
        // binding.
        {.slot = VW_SLOT_GRID,
         .buffer = field->params,
         .size_bytes = grid_bytes < binding_bytes ? grid_bytes : binding_bytes,
         .unused = !grid},
        {.slot = VW_SLOT_GRID_TEXEL,
         .buffer = field->params,
         .size_bytes = grid_bytes,
         .texel = VW_TEXEL_FLOAT2,
         .unused = !grid},
        {.slot = VW_SLOT_ROWS, .buffer = field->rows, .unused = !of_grid},
        {.slot = VW_SLOT_ROWS_TEXEL, .buffer = field->rows, .texel = VW_TEXEL_UINT2, .unused = !of_grid},
        {.slot = VW_SLOT_GRID_ROWS, .buffer = field->grid_rows, .unused = !of_grid},
        {.slot = VW_SLOT_GRID_ROWS_TEXEL, .buffer = field->grid_rows, .texel = VW_TEXEL_FLOAT4, .unused = !of_grid},
        {.slot = VW_SLOT_LAYER_ROWS, .buffer = layers, .unused = !layers},
        {.slot = VW_SLOT_LAYER_ROWS_TEXEL, .buffer = layers, .texel = VW_TEXEL_FLOAT4, .unused = !layers},
        {.slot = VW_SLOT_D_LAYER_ROWS, .buffer = field->d_rows, .unused = !field->d_rows},
        {.slot = VW_SLOT_D_LAYER_ROWS_TEXEL,
         .buffer = field->d_rows,
         .texel = VW_TEXEL_FLOAT4,
         .unused = !field->d_rows},
    };
    memcpy(bindings + *count, own, sizeof own);
    *count += VW_ARRAY_COUNT(own);
}

const struct vw_renderer_kind renderer_volume = {
    .specialise = specialise,
    .lay_out = lay_out,
    .lay_out_unfollowed = lay_out_unfollowed,
    .fit = fit,
    .initialise = initialise,
    .create_field = create_field,
    .bind_field = bind_field,
    .step = &vw_volume_renderer_step,
    .evaluation = &vw_volume_renderer_evaluation,
};
