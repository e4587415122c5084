// Steps in batches: draw the pixels, record training and validation, submit, read the scalars back as step records.
#include "train/trainer_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "train/effects/registry.h"
#include "gpu/shaders.h"
#include "train/pixels.h"
#include "base/clock.h"
#include "base/memory.h"
#include "base/psnr.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "base/random.h"

enum {
    STEPS_PER_BATCH_MAX = 64,
    PIXELS_PER_BATCH_MAX = 1 << 20,
    VAL_RAYS_PER_VIEW_MIN = 32,
};
static const double BATCH_SECONDS =
    0.25; // long enough to hide submission, short enough for a watchdog and a progress bar

// ---- Creation
// ---------------------------------------------------------------------------------------------------------

static uint32_t val_rays_of_view(const struct vw_trainer *trainer, uint32_t index) {
    uint64_t total = trainer->config.val_rays;
    uint32_t share = (uint32_t)(total * (index + 1) / trainer->val_count - total * index / trainer->val_count);
    return share < VAL_RAYS_PER_VIEW_MIN ? VAL_RAYS_PER_VIEW_MIN : share;
}

static struct pixel_columns scored_columns(const struct vw_trainer *trainer, uint32_t view) {
    return appearance_fits_views(&trainer->model) ? view_fit_right_half(trainer->scene, view)
                                                  : pixels_all_columns(trainer->scene, view);
}

// The fixed pixels of every validation view, one after another, and each view's range.
static enum vw_status choose_val_pixels(struct vw_trainer *trainer, struct vw_pixel *pixels,
                                        struct vw_ray_range *ranges) {
    uint32_t written = 0;
    for (uint32_t i = 0; i < trainer->val_count; i++) {
        uint32_t view = trainer->val_views[i];
        uint32_t count = pixels_stratify(trainer->scene, view, scored_columns(trainer, view),
                                         val_rays_of_view(trainer, i), pixels + written);
        ranges[i] = (struct vw_ray_range){.first = written, .count = count};
        if (!trainer->masks) pixels_unmask(trainer->scene, pixels + written, count);
        for (uint32_t ray = 0; ray < count; ray++) trainer->val_pixel_counts[i] += pixels[written + ray].weight != 0.0f;
        if (!trainer->val_pixel_counts[i])
            return vw_fail(
                VW_ERROR_INPUT, "%s: this validation view has no usable pixel%s; leave it out of the validation list",
                trainer->scene->views[view].name,
                appearance_fits_views(&trainer->model) ? " in its right half, where appearance is scored" : "");
        written += count;
    }
    trainer->val_rays = written;
    return VW_OK;
}

static enum vw_status create_validation_passes(struct vw_trainer *trainer, const struct vw_pixel *pixels,
                                               uint32_t pixel_count, const struct vw_ray_range *ranges) {
    uint64_t range_bytes = sizeof *ranges * trainer->val_count;
    enum vw_status status = evaluator_create(&trainer->field, pixel_count, &trainer->validation);
    if (status == VW_OK) status = evaluator_set_pixels(&trainer->validation, pixels, pixel_count);
    if (status == VW_OK)
        status =
            vw_buffer_create(trainer->gpu, &(struct vw_buffer_params){.name = "val_ranges", .size_bytes = range_bytes},
                             &trainer->val_ranges);
    if (status == VW_OK) status = vw_buffer_write(trainer->val_ranges, 0, ranges, range_bytes);
    if (status == VW_OK && appearance_fits_views(&trainer->model))
        status =
            view_fit_create(&trainer->validation, ranges + trainer->val_count, trainer->val_count, &trainer->view_fit);
    if (status != VW_OK) return status;
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_RAYS, .buffer = trainer->validation.rays},
        {.slot = VW_SLOT_COLOURS, .buffer = trainer->validation.colours},
        {.slot = VW_SLOT_VAL_VIEWS, .buffer = trainer->val_ranges},
        {.slot = VW_SLOT_SCALARS, .buffer = trainer->scalars},
        {.slot = VW_SLOT_FITS, .buffer = trainer->view_fit.fits ? trainer->view_fit.fits : trainer->field.step_state},
    };
    struct vw_pass_params params = {.shader = &vw_shader_reduce_views,
                                    .specialization = (const uint32_t *)&trainer->model.specialization,
                                    .specialization_count = VW_SPECIALIZATION_COUNT,
                                    .bindings = bindings,
                                    .binding_count = VW_ARRAY_COUNT(bindings)};
    return vw_pass_create(trainer->gpu, &params, &trainer->reduce_views);
}

static enum vw_status create_validation(struct vw_trainer *trainer) {
    bool fits = appearance_fits_views(&trainer->model);
    uint64_t most = 0;
    for (uint32_t i = 0; i < trainer->val_count; i++) most += (fits ? 2 : 1) * val_rays_of_view(trainer, i);
    struct vw_pixel *pixels = vw_allocate(most, sizeof *pixels);
    struct vw_ray_range *ranges = vw_allocate(trainer->val_count, 2 * sizeof *ranges); // scored, then to fit on
    trainer->val_pixel_counts = vw_allocate(trainer->val_count, sizeof *trainer->val_pixel_counts);
    enum vw_status status = pixels && ranges && trainer->val_pixel_counts ? VW_OK : VW_ERROR_MEMORY;
    if (status == VW_OK) status = choose_val_pixels(trainer, pixels, ranges);
    uint32_t count = trainer->val_rays;
    if (status == VW_OK && fits)
        view_fit_choose_pixels(trainer->scene, trainer->val_views, trainer->val_count, ranges, pixels, &count,
                               ranges + trainer->val_count);
    if (status == VW_OK && !trainer->masks) pixels_unmask(trainer->scene, pixels, count);
    if (status == VW_OK) status = create_validation_passes(trainer, pixels, count, ranges);
    free(pixels);
    free(ranges);
    return status;
}

// A step is measured once, and by its probes, if any.
uint32_t trainer_rows_per_measurement(const struct vw_trainer *trainer) { return 1 + trainer->val_count; }
static uint32_t noise_rows(const struct vw_trainer *trainer) {
    return trainer->config.noise_floor ? PROBES_PER_STEP * trainer_rows_per_measurement(trainer) : 0;
}
static uint32_t rows_per_step(const struct vw_trainer *trainer) {
    uint32_t others = trainer->config.first_order ? FIRST_ORDER_MEASUREMENTS : 0;
    return noise_rows(trainer) + (1 + others) * trainer_rows_per_measurement(trainer);
}
static uint32_t probes_per_step(const struct vw_trainer *trainer) {
    return (trainer->config.noise_floor ? PROBES_PER_STEP : 0) + trainer->config.first_order;
}
static uint32_t pixels_per_step(const struct vw_trainer *trainer) {
    return trainer->config.rays * (trainer->config.noise_floor ? 1 + PROBE_RESAMPLES : 1);
}
static uint32_t rows_per_slot(const struct vw_trainer *trainer) {
    return (trainer->steps_capacity + 1) * rows_per_step(trainer);
}

static enum vw_status create_transfers(struct vw_trainer *trainer, uint32_t steps_per_batch) {
    uint32_t most = PIXELS_PER_BATCH_MAX / pixels_per_step(trainer);
    trainer->steps_capacity = most < STEPS_PER_BATCH_MAX ? most : STEPS_PER_BATCH_MAX;
    trainer->adapt_batches = steps_per_batch == 0;
    trainer->steps_per_batch = steps_per_batch == 0                        ? 1
                               : steps_per_batch < trainer->steps_capacity ? steps_per_batch
                                                                           : trainer->steps_capacity;
    uint64_t pixel_bytes = sizeof(struct vw_pixel) * pixels_per_step(trainer) * trainer->steps_capacity;
    uint32_t records = trainer->steps_capacity + 1;
    trainer->records = vw_allocate(records, sizeof *trainer->records);
    trainer->view_errors = vw_allocate((size_t)records * trainer->val_count, sizeof *trainer->view_errors);
    trainer->probes = vw_allocate((size_t)records * probes_per_step(trainer), sizeof *trainer->probes);
    trainer->probe_errors = vw_allocate(trainer->val_count, sizeof *trainer->probe_errors);
    bool allocated = trainer->records && trainer->view_errors && trainer->probes && trainer->probe_errors;
    enum vw_status status = allocated ? VW_OK : VW_ERROR_MEMORY;
    if (status == VW_OK)
        status = vw_buffer_create(trainer->gpu,
                                  &(struct vw_buffer_params){.name = "pixels",
                                                             .size_bytes = BATCHES_IN_FLIGHT * pixel_bytes,
                                                             .memory = VW_BUFFER_UPLOAD},
                                  &trainer->pixels);
    if (status == VW_OK)
        status = vw_buffer_create(
            trainer->gpu,
            &(struct vw_buffer_params){.name = "scalars",
                                       .size_bytes = 16ull * BATCHES_IN_FLIGHT * rows_per_slot(trainer),
                                       .memory = VW_BUFFER_READBACK},
            &trainer->scalars);
    for (int i = 0; i < BATCHES_IN_FLIGHT && status == VW_OK; i++)
        status = vw_batch_create(trainer->gpu, &trainer->slots[i].batch);
    return status;
}

static enum vw_status copy_train_views(struct vw_trainer *trainer, const uint32_t *views, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (views[i] >= trainer->scene->view_count || (i > 0 && views[i] <= views[i - 1]))
            return vw_fail(VW_ERROR_USAGE,
                           "train_views[%u] is %u; give indices of the scene's %u views in ascending order", i,
                           views[i], trainer->scene->view_count);
    trainer->train_views = vw_allocate(count, sizeof *views);
    if (!trainer->train_views) return VW_ERROR_MEMORY;
    memcpy(trainer->train_views, views, count * sizeof *views);
    trainer->train_count = count;
    return VW_OK;
}

static enum vw_status choose_views(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    enum vw_status status =
        params->train_views
            ? copy_train_views(trainer, params->train_views, params->train_view_count)
            : vw_scene_list_views(trainer->scene, VW_SPLIT_TRAIN, &trainer->train_views, &trainer->train_count);
    if (status == VW_OK && trainer->validate)
        status = vw_scene_list_views(trainer->scene, VW_SPLIT_VAL, &trainer->val_views, &trainer->val_count);
    if (status != VW_OK) return status;
    if (!trainer->train_count)
        return vw_fail(VW_ERROR_INPUT, "%s: no view is left to train on; check the splits", trainer->scene->path);
    if (trainer->validate && !trainer->val_count)
        return vw_fail(VW_ERROR_INPUT, "%s: no view is left to validate on; check the splits or give --val FILE",
                       trainer->scene->path);
    trainer->order = vw_allocate(trainer->train_count, sizeof *trainer->order);
    trainer->ordered_epoch = UINT64_MAX;
    return trainer->order ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status take_effects(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    if (!params->effects || params->effect_count > VW_EFFECT_COUNT_MAX)
        return vw_fail(VW_ERROR_USAGE, "the trainer has no verdicts on effects; decide or list them first");
    trainer->effect_count = params->effect_count;
    memcpy(trainer->effects, params->effects, params->effect_count * sizeof *params->effects);
    trainer->masks =
        !trainer->scene->masked_view_count || vw_effects_is_on(trainer->effects, trainer->effect_count, "masks");
    return VW_OK;
}

// What puts the state back after it has probed.
static enum vw_status create_probes(struct vw_trainer *trainer) {
    const struct vw_config *config = &trainer->config;
    enum vw_status status = VW_OK;
    if (config->noise_floor || config->same_state) status = snapshot_create(&trainer->step, &trainer->snapshot);
    if (status == VW_OK && config->noise_floor) status = noise_probe_create(trainer, &trainer->noise_probe);
    if (status == VW_OK && config->first_order)
        status = first_order_create(&trainer->field, vw_gpu_get_limits(trainer->gpu)->storage_binding_bytes,
                                    &trainer->first_order);
    if (status == VW_OK && config->same_state)
        status = same_state_create(trainer, probes_per_step(trainer), &trainer->same_state);
    return status;
}

static enum vw_status check_probes(const struct vw_trainer *trainer) {
    const struct vw_config *config = &trainer->config;
    const char *option = config->noise_floor   ? "noise-floor"
                         : config->same_state  ? "same-state"
                         : config->first_order ? "first-order"
                                               : NULL;
    if (!option || trainer->validate) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--%s: needs validation after every step; use viewworth value", option);
}

enum vw_status vw_trainer_create(const struct vw_trainer_params *params, struct vw_trainer **out) {
    struct vw_trainer *trainer = vw_allocate(1, sizeof *trainer);
    if (!trainer) return VW_ERROR_MEMORY;
    trainer->gpu = params->gpu;
    trainer->scene = params->scene;
    trainer->config = *params->config;
    trainer->validate = params->validate;
    trainer->stop_step = UINT64_MAX;
    enum vw_status status = vw_config_check(&trainer->config);
    if (status == VW_OK) status = check_probes(trainer);
    if (status == VW_OK) status = take_effects(trainer, params);
    if (status == VW_OK) status = choose_views(trainer, params);
    if (status == VW_OK)
        status =
            model_create(&trainer->config, trainer->scene, trainer->train_views, trainer->train_count, trainer->effects,
                         vw_gpu_get_info(trainer->gpu), vw_gpu_get_limits(trainer->gpu), &trainer->model);
    if (status == VW_OK)
        status = field_create(trainer->gpu, &trainer->model, trainer->scene,
                              vw_config_seed_of(&trainer->config, VW_VARY_INIT), &trainer->field);
    if (status == VW_OK) status = create_transfers(trainer, params->steps_per_batch);
    if (status == VW_OK)
        status = step_create(&trainer->field, &trainer->config, trainer->pixels, trainer->scalars, &trainer->step);
    if (status == VW_OK && trainer->validate) status = create_validation(trainer);
    if (status == VW_OK) status = create_probes(trainer);
    if (status != VW_OK) {
        vw_trainer_destroy(&trainer);
        return status;
    }
    *out = trainer;
    return VW_OK;
}

void vw_trainer_destroy(struct vw_trainer **pointer) {
    struct vw_trainer *trainer = *pointer;
    if (!trainer) return;
    for (int i = 0; i < BATCHES_IN_FLIGHT; i++) vw_batch_destroy(&trainer->slots[i].batch); // waits
    noise_probe_destroy(&trainer->noise_probe);
    first_order_destroy(&trainer->first_order);
    same_state_destroy(&trainer->same_state);
    snapshot_destroy(&trainer->snapshot);
    vw_pass_destroy(&trainer->reduce_views);
    view_fit_destroy(&trainer->view_fit);
    evaluator_destroy(&trainer->validation);
    vw_buffer_destroy(&trainer->val_ranges);
    step_destroy(&trainer->step);
    field_destroy(&trainer->field);
    vw_buffer_destroy(&trainer->pixels);
    vw_buffer_destroy(&trainer->scalars);
    free(trainer->train_views);
    free(trainer->order);
    free(trainer->val_views);
    free(trainer->val_pixel_counts);
    free(trainer->records);
    free(trainer->view_errors);
    free(trainer->probes);
    free(trainer->probe_errors);
    free(trainer);
    *pointer = NULL;
}

uint64_t vw_trainer_total_steps(const struct vw_trainer *trainer) {
    return (uint64_t)trainer->config.epochs * trainer->train_count;
}

uint64_t vw_trainer_epoch_end(const struct vw_trainer *trainer, uint64_t step) {
    return ((uint64_t)trainer_epoch_of_step(trainer, step) + 1) * trainer->train_count;
}

void vw_trainer_stop_after(struct vw_trainer *trainer, uint64_t step) { trainer->stop_step = step; }

const struct vw_effect_verdict *vw_trainer_effects(const struct vw_trainer *trainer, uint32_t *count) {
    *count = trainer->effect_count;
    return trainer->effects;
}

const uint32_t *vw_trainer_validation_views(const struct vw_trainer *trainer, uint32_t *count) {
    *count = trainer->val_count;
    return trainer->val_views;
}

// ---- Recording
// --------------------------------------------------------------------------------------------------------

uint32_t trainer_epoch_of_step(const struct vw_trainer *trainer, uint64_t step) {
    return step > 0 ? (uint32_t)((step - 1) / trainer->train_count) : 0;
}

uint32_t trainer_photo_of_step(struct vw_trainer *trainer, uint64_t step) {
    uint32_t epoch = trainer_epoch_of_step(trainer, step);
    if (epoch != trainer->ordered_epoch)
        vw_random_order(vw_config_seed_of(&trainer->config, VW_VARY_ORDER), epoch, trainer->train_count,
                        trainer->order);
    trainer->ordered_epoch = epoch;
    return trainer->order[(step - 1) % trainer->train_count];
}

static uint32_t view_of_step(struct vw_trainer *trainer, uint64_t step) {
    return trainer->train_views[trainer_photo_of_step(trainer, step)];
}

void trainer_record_validation(const struct vw_trainer *trainer, struct vw_batch *batch, uint32_t scalar_row) {
    if (!trainer->validate) return;
    struct vw_push_reduce push = {.count = trainer->val_count, .scalar_row = scalar_row};
    evaluator_record(&trainer->validation, batch);
    view_fit_record(&trainer->view_fit, batch, trainer->val_count);
    vw_batch_dispatch(batch, trainer->reduce_views, &push, sizeof push, 64ull * trainer->val_count);
}

static void record_training(struct vw_trainer *trainer, const struct batch_slot *slot, uint64_t step,
                            uint32_t step_in_batch, uint32_t scalar_row) {
    uint32_t slot_index = (uint32_t)(slot - trainer->slots), rays = trainer->config.rays;
    uint32_t first_pixel = (slot_index * trainer->steps_capacity + step_in_batch) * pixels_per_step(trainer);
    struct vw_pixel *pixels = (struct vw_pixel *)vw_buffer_map(trainer->pixels) + first_pixel;
    uint64_t seed = vw_config_seed_of(&trainer->config, VW_VARY_PIXELS);
    bool probed = noise_probe_due(trainer, step), first_order = first_order_due(trainer, step);
    uint32_t probe_row = scalar_row + trainer_rows_per_measurement(trainer);
    for (uint32_t draw = 0; draw <= (probed ? PROBE_RESAMPLES : 0); draw++)
        pixels_draw(trainer->scene, view_of_step(trainer, step), seed, step, draw, rays, pixels + draw * rays);
    if (!trainer->masks) pixels_unmask(trainer->scene, pixels, rays * (probed ? 1 + PROBE_RESAMPLES : 1));
    if (probed) noise_probe_record(trainer, slot->batch, step, first_pixel, probe_row);
    if (first_order) first_order_record_begin(trainer->first_order, slot->batch);
    step_record(&trainer->step, slot->batch, step, first_pixel, scalar_row);
    trainer_record_validation(trainer, slot->batch, scalar_row);
    if (first_order) first_order_record_end(trainer, slot->batch, probe_row + noise_rows(trainer));
}

// Whether the state on the device, or what will be there when all is done that is in flight, is still to be probed.
static bool state_is_due(const struct vw_trainer *trainer) {
    uint64_t last = trainer->next_step - 1;
    return trainer->next_step > 0 && last > trainer->same_state.probed_step && same_state_due(trainer, last);
}

// Records and submits the next steps into a free slot, up to one behind which the state is probed; leaves the slot idle
// when no step is left, or none can be taken before the state has been probed.
static enum vw_status submit_batch(struct vw_trainer *trainer, struct batch_slot *slot) {
    uint64_t total = vw_trainer_total_steps(trainer), last = trainer->stop_step < total ? trainer->stop_step : total;
    if (trainer->next_step > last || state_is_due(trainer)) return VW_OK;
    uint32_t row = (uint32_t)(slot - trainer->slots) * rows_per_slot(trainer);
    slot->first_step = trainer->next_step;
    slot->row_count = 0;
    vw_batch_begin(slot->batch);
    if (trainer->next_step == 0) { // the untrained field
        trainer_record_validation(trainer, slot->batch, row);
        row += rows_per_step(trainer);
        slot->row_count++;
        trainer->next_step++;
    }
    for (uint32_t i = 0; i < trainer->steps_per_batch && trainer->next_step <= last && !state_is_due(trainer);
         i++, row += rows_per_step(trainer)) {
        record_training(trainer, slot, trainer->next_step++, i, row);
        slot->row_count++;
    }
    slot->submitted_s = vw_now_s();
    enum vw_status status = vw_batch_submit(slot->batch);
    slot->in_flight = status == VW_OK;
    return status;
}

// ---- Reading back
// -----------------------------------------------------------------------------------------------------

// `sums` has one row per validation view: squared error high and low, absolute error high and low.
static void read_validation(const struct vw_trainer *trainer, const vw_float4 *sums, struct vw_view_error *views,
                            struct vw_step_record *record) {
    double squared = 0.0, absolute = 0.0, psnr = 0.0, values = 0.0;
    for (uint32_t i = 0; i < trainer->val_count; i++) {
        double view_squared = (double)sums[i].x + sums[i].y, view_absolute = (double)sums[i].z + sums[i].w;
        double view_values = 3.0 * trainer->val_pixel_counts[i];
        views[i] = (struct vw_view_error){.mse = view_squared / view_values, .l1 = view_absolute / view_values};
        psnr += vw_psnr_db(views[i].mse);
        record->floored_views += views[i].mse < VW_MSE_FLOOR;
        squared += view_squared;
        absolute += view_absolute;
        values += view_values;
    }
    record->validated = true;
    record->views = views;
    record->view_count = trainer->val_count;
    record->val_psnr = psnr / trainer->val_count;
    record->val_psnr_pooled = vw_psnr_db(squared / values);
    record->val_l1 = absolute / values;
    record->nonfinite |= !isfinite(squared) || !isfinite(absolute);
}

// Decision 8: a step that was skipped, or whose validation is not finite, has no values.
static void blank_nonfinite(struct vw_step_record *record) {
    if (!record->nonfinite) return;
    record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
    if (!isfinite(record->train_loss)) record->train_loss = NAN;
}

void trainer_read_probe(const struct vw_trainer *trainer, const vw_float4 *rows, bool stepped, struct vw_probe *probe) {
    struct vw_step_record measured = {.nonfinite = stepped && rows->z != 0.0f};
    read_validation(trainer, rows + 1, trainer->probe_errors, &measured);
    blank_nonfinite(&measured);
    probe->val_psnr = measured.val_psnr;
    probe->val_psnr_pooled = measured.val_psnr_pooled;
    probe->val_l1 = measured.val_l1;
}

// `rows` are those of the step's own measurement, behind which the probes' lie.
static void read_probes(struct vw_trainer *trainer, const vw_float4 *rows, struct vw_probe *probes,
                        struct vw_step_record *record) {
    uint32_t stride = trainer_rows_per_measurement(trainer),
             noise = noise_probe_due(trainer, record->step) ? PROBES_PER_STEP : 0;
    record->probes = probes;
    for (uint32_t i = 0; i < noise; i++) {
        enum vw_probe_kind kind = noise_probe_kind(i); // a repeat takes no step that could fail
        probes[i] = (struct vw_probe){.step = record->step, .index = i, .kind = kind, .view = VW_RECORD_UNTRAINED};
        trainer_read_probe(trainer, rows + (1 + i) * stride, kind != VW_PROBE_REPEATED, &probes[i]);
    }
    record->probe_count = noise;
    if (!first_order_due(trainer, record->step)) return;
    probes[noise] = (struct vw_probe){
        .step = record->step, .index = noise, .kind = VW_PROBE_FIRST_ORDER, .view = VW_RECORD_UNTRAINED};
    first_order_read(trainer, rows + stride + noise_rows(trainer), record->nonfinite, &probes[noise]);
    record->probe_count++;
}

static void read_record(struct vw_trainer *trainer, uint64_t step, uint32_t index, const vw_float4 *row) {
    struct vw_step_record *record = &trainer->records[index];
    struct vw_view_error *views = trainer->view_errors + (size_t)index * trainer->val_count;
    *record = (struct vw_step_record){.step = step,
                                      .view = VW_RECORD_UNTRAINED,
                                      .train_loss = NAN,
                                      .val_psnr = NAN,
                                      .val_psnr_pooled = NAN,
                                      .val_l1 = NAN};
    if (step > 0) {
        record->epoch = trainer_epoch_of_step(trainer, step);
        record->view = view_of_step(trainer, step);
        record->train_loss = ((double)row->x + row->y) / trainer->config.rays;
        record->nonfinite = row->z != 0.0f;
        record->clamped_count = (uint64_t)row->w;
    }
    read_probes(trainer, row, trainer->probes + (size_t)index * probes_per_step(trainer), record);
    if (trainer->validate) read_validation(trainer, row + 1, views, record);
    blank_nonfinite(record);
    trainer->stats.nonfinite_steps += record->nonfinite;
    trainer->stats.clamped_count += record->clamped_count;
    trainer->stats.floored_steps += record->floored_views > 0;
}

// Grows batches until one takes long enough. How steps are grouped changes no bit of them.
static void adapt_batch_size(struct vw_trainer *trainer, const struct batch_slot *slot) {
    if (!trainer->adapt_batches || slot->row_count < trainer->steps_per_batch) return;
    if (vw_now_s() - slot->submitted_s < BATCH_SECONDS && trainer->steps_per_batch * 2 <= trainer->steps_capacity)
        trainer->steps_per_batch *= 2;
}

bool trainer_in_flight(const struct vw_trainer *trainer) {
    for (int i = 0; i < BATCHES_IN_FLIGHT; i++)
        if (trainer->slots[i].in_flight) return true;
    return false;
}

// Waits for the oldest batch in flight, if any, and lends its records.
static enum vw_status hand_out(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count) {
    struct batch_slot *slot = &trainer->slots[trainer->next_slot];
    *records = trainer->records;
    *count = 0;
    if (!slot->in_flight) return VW_OK;
    trainer->next_slot = (trainer->next_slot + 1) % BATCHES_IN_FLIGHT;
    enum vw_status status = vw_batch_wait(slot->batch);
    slot->in_flight = false;
    if (status != VW_OK) return status;
    adapt_batch_size(trainer, slot);
    const vw_float4 *rows =
        (const vw_float4 *)vw_buffer_map(trainer->scalars) + (size_t)(slot - trainer->slots) * rows_per_slot(trainer);
    for (uint32_t i = 0; i < slot->row_count; i++)
        read_record(trainer, slot->first_step + i, i, rows + (size_t)i * rows_per_step(trainer));
    *count = slot->row_count;
    bool last_submitted = slot->first_step + slot->row_count == trainer->next_step;
    if (!last_submitted || !state_is_due(trainer)) return VW_OK;
    return same_state_take(trainer, slot->batch, &trainer->records[slot->row_count - 1]);
}

// Fills the slots from the oldest on, so that one batch runs while another's records are read.
enum vw_status vw_trainer_advance(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < BATCHES_IN_FLIGHT && status == VW_OK; i++) {
        struct batch_slot *slot = &trainer->slots[(trainer->next_slot + i) % BATCHES_IN_FLIGHT];
        if (!slot->in_flight) status = submit_batch(trainer, slot);
    }
    return status == VW_OK ? hand_out(trainer, records, count) : status;
}

enum vw_status vw_trainer_collect(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count) {
    return hand_out(trainer, records, count);
}

void vw_trainer_get_stats(const struct vw_trainer *trainer, struct vw_trainer_stats *stats) {
    *stats = trainer->stats;
    stats->param_count = trainer->model.param_count;
    stats->val_rays = trainer->val_rays;
    stats->device_bytes = vw_gpu_buffer_bytes(trainer->gpu);
}
