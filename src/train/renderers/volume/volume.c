// The renderer `volume`: samples along rays, of which a field (train/fields/) makes colour and density, composited.
#include "train/renderers/volume/volume.h"

#include <assert.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/fields/registry.h"
#include "train/model.h"
#include "train/passes.h"
#include "train/renderers/registry.h"

static const struct vw_field_kind *const kinds[] = {[VW_FIELD_HASH] = &field_hash, [VW_FIELD_MLP] = &field_mlp};

const struct vw_field_kind *vw_field_kind_of(enum vw_field field) {
    assert((size_t)field < VW_ARRAY_COUNT(kinds));
    return kinds[field];
}

static const uint64_t ROWS_BYTES_MAX = 1 << 28; // the rows of a chunk: enough samples to fill a large device

static uint32_t greatest_common_divisor(uint32_t a, uint32_t b) { return b ? greatest_common_divisor(b, a % b) : a; }

static enum vw_status specialise(const struct vw_config *config, struct vw_model *model) {
    struct vw_specialization *s = &model->specialization;
    model->kind = vw_field_kind_of(config->field);
    s->strata = config->samples;
    s->importance = config->importance_samples > 0;
    s->samples = s->importance ? config->importance_samples : s->strata;
    model->ray_samples = s->samples > s->strata ? s->samples : s->strata;
    s->stores_rows = 1;
    return VW_OK;
}

static void lay_out(const struct vw_config *config, const struct vw_scene *scene, struct vw_model *model) {
    (void)scene;
    model->kind->lay_out(config, model);
}

static void lay_out_unfollowed(struct vw_model *model) {
    if (!model->coarse_columns) return;
    model->coarse_column = vw_model_append_columns(model, model->coarse_columns, 0); // the field counts its params
    model->coarse = vw_model_columns(model, model->coarse_column, model->coarse_columns);
}

static enum vw_status initialise(const struct vw_model *model, const struct vw_scene *scene,
                                 const struct vw_drawn *drawn, void *params) {
    (void)scene;
    model->kind->initialise(model, drawn, params);
    return VW_OK;
}

// Chooses whole groups of rays whose rows fit into one binding, and no more than a step has.
static enum vw_status choose_chunk(const struct vw_config *config, const struct vw_device_choices *choices,
                                   const struct vw_gpu_limits *limits, struct vw_model *model) {
    uint32_t samples = model->ray_samples, chunk = choices->chunk_samples, group_samples = model->ray_group * samples,
             step_samples = vw_model_pad_rays(model, config->rays) * samples;
    uint64_t row_bytes = (uint64_t)model->row_bytes * model->row_count,
             layer_row_bytes = (uint64_t)VW_LAYER_ROW_BYTES * model->head_row_count,
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
    uint64_t rows = model->row_count > model->head_row_count ? model->row_count : model->head_row_count;
    s->rows_texel = choices->rows_texel && VW_ROWS_SIZE(rows, s->chunk_samples) <= limits->texel_elements;
}

static enum vw_status fit(const struct vw_config *config, const struct vw_device_choices *choices,
                          const struct vw_gpu_limits *limits, struct vw_model *model) {
    const struct vw_specialization *s = &model->specialization;
    uint32_t both = greatest_common_divisor(s->samples, s->strata); // the even samples fill whole workgroups, too
    model->ray_group = VW_FIELD_GROUP / greatest_common_divisor(VW_FIELD_GROUP, both);
    enum vw_status status = choose_chunk(config, choices, limits, model);
    if (status) return status;
    specialise_for_device(choices, limits, model);
    status = model->kind->fit(config, choices, limits, model);
    model->renderer_flags = model->window_count;
    return status;
}

const struct vw_renderer_kind renderer_volume = {
    .specialise = specialise,
    .lay_out = lay_out,
    .lay_out_unfollowed = lay_out_unfollowed,
    .fit = fit,
    .initialise = initialise,
    .step = &vw_volume_renderer_step,
    .evaluation = &vw_volume_renderer_evaluation,
};
