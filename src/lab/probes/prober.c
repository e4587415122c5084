#include "lab/probes/prober.h"

#include <math.h>

const char *const vw_probe_kind_names[VW_PROBE_KINDS] = {
    [VW_PROBE_REPEATED] = "repeated",   [VW_PROBE_ZERO_LEARNING_RATE] = "zero_learning_rate",
    [VW_PROBE_RESAMPLED] = "resampled", [VW_PROBE_SAME_STATE] = "same_state",
    [VW_PROBE_LONGER] = "longer",       [VW_PROBE_SHORTER] = "shorter",
};

enum vw_status vw_prober_create(struct vw_trainer *trainer, struct vw_prober *prober) {
    const struct vw_trainer_parts *parts = vw_trainer_get_parts(trainer);
    const struct vw_photo_order *order = parts->photo_order;
    *prober =
        (struct vw_prober){.parts = parts, .zero_rate_model = *parts->field->model, .zero_rate_field = *parts->field};
    prober->zero_rate_model.specialization.learning_rate = 0.0f;
    prober->zero_rate_field.model = &prober->zero_rate_model;
    enum vw_status status = vw_step_create(&prober->zero_rate_field, parts->photo_order, parts->pixels, parts->scalars,
                                           parts->step->photos, &prober->zero_rate_step);
    if (!status) status = vw_snapshot_create(parts->step, &prober->snapshot);
    if (!status) status = vw_submission_create(parts->field->gpu, &prober->submission);
    return status ? status : vw_step_take_photos(parts->step, order->train_views, order->train_count);
}

void vw_prober_destroy(struct vw_prober *prober) {
    vw_submission_destroy(&prober->submission);
    vw_snapshot_destroy(&prober->snapshot);
    vw_step_destroy(&prober->zero_rate_step);
}

static uint32_t row_of(const struct vw_prober *prober, uint32_t place) {
    return place * vw_validation_rows_per_measurement(prober->parts->validation);
}

static const vw_float4 *rows_of(const struct vw_prober *prober, uint32_t place) {
    return (const vw_float4 *)vw_buffer_map(prober->parts->scalars) + row_of(prober, place);
}

static void record(const struct vw_prober *prober, uint64_t step, const struct vw_probe *probe, uint32_t place) {
    const struct vw_trainer_parts *parts = prober->parts;
    uint32_t first_pixel = place * parts->config->rays, row = row_of(prober, place);
    if (probe->kind != VW_PROBE_REPEATED) {
        const struct vw_step_passes *passes =
            probe->kind == VW_PROBE_ZERO_LEARNING_RATE ? &prober->zero_rate_step : parts->step;
        const struct vw_pixel_draw drawn = {vw_config_seed_of(parts->config, VW_VARY_PIXELS), step, probe->draw,
                                            parts->field->model->picture_side, // as those of the step would be
                                            parts->masks};
        vw_step_draw_pixels(passes, prober->submission, probe->view, &drawn, first_pixel);
        vw_step_record_passes(passes, prober->submission, step, first_pixel, row);
    }
    vw_validation_record(parts->validation, prober->submission, row);
    vw_snapshot_record_restore(&prober->snapshot, prober->submission);
}

// Reads a result. The first row of a probe that takes a step says whether the step was finite.
static void read(const struct vw_trainer_parts *parts, const vw_float4 *rows, struct vw_probe *probe) {
    const struct vw_field_measurement measured = vw_validation_read(parts->validation, rows, NULL);
    bool valid = measured.finite && (probe->kind == VW_PROBE_REPEATED || rows->z == 0.0f);
    probe->val_psnr = valid ? measured.val_psnr : NAN;
    probe->val_psnr_pooled = valid ? measured.val_psnr_pooled : NAN;
    probe->val_l1 = valid ? measured.val_l1 : NAN;
}

static enum vw_status run(const struct vw_prober *prober) {
    enum vw_status status = vw_submission_submit(prober->submission);
    return !status ? vw_submission_wait(prober->submission) : status;
}

static enum vw_status take_some(const struct vw_prober *prober, uint64_t step, struct vw_probe *probes,
                                uint32_t count) {
    vw_submission_begin(prober->submission);
    vw_snapshot_record_save(&prober->snapshot, prober->submission);
    for (uint32_t i = 0; i < count; i++) record(prober, step, &probes[i], i);
    enum vw_status status = run(prober);
    for (uint32_t i = 0; i < count && !status; i++) read(prober->parts, rows_of(prober, i), &probes[i]);
    return status;
}

// Records a step of the run in place `place` of a submission, longer where it is on the probe's photo.
static void record_step(const struct vw_prober *prober, uint64_t step, const struct vw_probe *probe, uint32_t place) {
    const struct vw_trainer_parts *parts = prober->parts;
    const struct vw_pixel_draw drawn = {vw_config_seed_of(parts->config, VW_VARY_PIXELS), step,
                                        .picture_side = parts->field->model->picture_side, .masks = parts->masks};
    uint32_t view = vw_photo_order_view_of_step(parts->photo_order, step), pixel = place * parts->config->rays;
    vw_step_draw_pixels(parts->step, prober->submission, view, &drawn, pixel);
    vw_step_record_gradients(parts->step, prober->submission, step, pixel);
    vw_step_record_update(parts->step, prober->submission, step, pixel, view == probe->view ? probe->extra : 0.0f);
    vw_step_record_loss(parts->step, prober->submission, pixel, row_of(prober, place));
}

// Takes the rest of the run with other steps on the probe's photo, validates, and restores the state.
static enum vw_status train_on(const struct vw_prober *prober, uint64_t next_step, struct vw_probe *probe) {
    const struct vw_photo_order *order = prober->parts->photo_order;
    uint64_t total = vw_photo_order_total_steps(order);
    uint32_t count = 0;
    enum vw_status status = VW_OK;
    for (uint64_t step = next_step; step <= total && !status; step += count) {
        count = total - step < order->submission_steps ? (uint32_t)(total - step + 1) : order->submission_steps;
        vw_submission_begin(prober->submission);
        if (step == next_step) vw_snapshot_record_save(&prober->snapshot, prober->submission);
        for (uint32_t i = 0; i < count; i++) record_step(prober, step + i, probe, i);
        if (step + count > total) {
            vw_validation_record(prober->parts->validation, prober->submission, row_of(prober, count - 1));
            vw_snapshot_record_restore(&prober->snapshot, prober->submission);
        }
        status = run(prober);
    }
    if (!status) read(prober->parts, rows_of(prober, count - 1), probe);
    return status;
}

enum vw_status vw_prober_take(const struct vw_prober *prober, uint64_t next_step, struct vw_probe *probes,
                              uint32_t count) {
    uint32_t room = prober->parts->photo_order->submission_steps, some = 0;
    enum vw_status status = VW_OK;
    for (uint32_t first = 0; first < count && !status; first += some) {
        bool trains = probes[first].kind >= VW_PROBE_LONGER; // such probes come first
        some = trains ? 1 : count - first < room ? count - first : room;
        status =
            trains ? train_on(prober, next_step, &probes[first]) : take_some(prober, next_step, probes + first, some);
    }
    return status;
}
