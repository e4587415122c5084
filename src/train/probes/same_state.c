#include "train/probes/same_state.h"

#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "train/pixels.h"

static uint32_t probe_count(const struct vw_probe_context *context) {
    return context->schedule->train_count * SAME_STATE_DRAWS;
}

enum vw_status vw_same_state_create(const struct vw_probe_context *context, uint32_t others,
                                    struct vw_same_state_probes *probes) {
    probes->probes = vw_allocate((size_t)others + probe_count(context), sizeof *probes->probes);
    return probes->probes ? VW_OK : VW_ERROR_MEMORY;
}

void vw_same_state_destroy(struct vw_same_state_probes *probes) { free(probes->probes); }

// Returns how many of the middles (2 i + 1) counted / (2 states), i = 0, 1, ..., are before the beginning of epoch
// `place` of those that are counted.
static uint64_t middles_before(uint64_t states, uint64_t counted, uint64_t place) {
    return (2 * states * place + counted - 1) / (2 * counted);
}

bool vw_same_state_due(const struct vw_probe_context *context, uint64_t step) {
    const struct vw_config *config = context->config;
    uint32_t epoch = vw_photo_order_epoch_of_step(context->schedule, step);
    if (!config->same_state || step == 0 || step % context->schedule->train_count != 0 ||
        epoch < config->burn_in_epochs)
        return false;
    uint64_t counted = config->epochs - config->burn_in_epochs, place = epoch - config->burn_in_epochs;
    return middles_before(config->same_state, counted, place + 1) > middles_before(config->same_state, counted, place);
}

// Some of a state's probes, as many as a batch of steps has, so that a submission takes no longer than one of the run.
struct part {
    uint64_t step; // that the probes take
    uint32_t first, count;
    uint32_t first_draw;
};

// Draws the pixels of probe `index` as those of the next step would be, by a draw that nothing else takes.
static void draw_pixels(const struct vw_probe_context *context, const struct part *part, uint32_t index,
                        struct vw_pixel *pixels) {
    uint32_t view = context->schedule->train_views[index / SAME_STATE_DRAWS], rays = context->config->rays;
    const struct vw_pixel_draw drawn = {vw_config_seed_of(context->config, VW_VARY_PIXELS), part->step,
                                        part->first_draw + index, context->field->model->picture_side};
    vw_pixels_draw(context->scene, view, &drawn, rays, pixels);
    if (!context->masks) vw_pixels_unmask(context->scene, pixels, rays);
}

static enum vw_status take_part(const struct vw_probe_context *context, struct vw_submission *batch,
                                const struct part *part) {
    uint32_t stride = vw_validation_rows_per_measurement(context->validation), rays = context->config->rays;
    struct vw_pixel *pixels = vw_buffer_map(context->pixels);
    vw_submission_begin(batch);
    if (part->first == 0) vw_snapshot_record_save(context->snapshot, batch);
    for (uint32_t i = 0; i < part->count; i++) {
        draw_pixels(context, part, part->first + i, pixels + (size_t)i * rays);
        vw_step_record_passes(context->step, batch, part->step, i * rays, i * stride);
        vw_validation_record(context->validation, batch, i * stride);
        vw_snapshot_record_restore(context->snapshot, batch);
    }
    enum vw_status status = vw_submission_submit(batch);
    return !status ? vw_submission_wait(batch) : status;
}

static void read_part(struct vw_same_state_probes *probes, const struct vw_probe_context *context,
                      const struct vw_step_record *record, const struct part *part) {
    const vw_float4 *rows = vw_buffer_map(context->scalars);
    uint32_t stride = vw_validation_rows_per_measurement(context->validation);
    for (uint32_t i = 0; i < part->count; i++, rows += stride) {
        uint32_t index = record->probe_count + part->first + i;
        struct vw_probe *probe = &probes->probes[index];
        *probe = (struct vw_probe){.step = record->step,
                                   .index = index,
                                   .kind = VW_PROBE_SAME_STATE,
                                   .view = context->schedule->train_views[(part->first + i) / SAME_STATE_DRAWS]};
        vw_probe_read(context, rows, true, probe);
    }
}

enum vw_status vw_same_state_take(struct vw_same_state_probes *probes, const struct vw_probe_context *context,
                                  struct vw_submission *batch, uint32_t first_draw, struct vw_step_record *record) {
    double started_s = vw_now_s();
    const struct vw_photo_order *schedule = context->schedule;
    enum vw_status status = vw_scene_decode(context->scene, schedule->train_views, schedule->train_count);
    uint32_t total = probe_count(context), batch_steps = context->schedule->batch_steps;
    struct part part = {.step = record->step + 1, .first_draw = first_draw};
    for (; part.first < total && !status; part.first += part.count) {
        part.count = total - part.first < batch_steps ? total - part.first : batch_steps;
        status = take_part(context, batch, &part);
        if (!status) read_part(probes, context, record, &part);
    }
    if (status) return status;
    if (record->probe_count) memcpy(probes->probes, record->probes, record->probe_count * sizeof *probes->probes);
    record->probes = probes->probes;
    record->probe_count += total;
    probes->probed_step = record->step;
    probes->taken_count += total;
    probes->taken_s += vw_now_s() - started_s;
    return VW_OK;
}
