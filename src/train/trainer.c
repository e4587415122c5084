// Submissions of steps: create what they need, draw their pixels, record and submit them, and hand out their records.
#include "train/trainer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/effects.h"
#include "train/effects/registry.h"
#include "train/trainer_private.h"

// ---- Parts ----------------------------------------------------------------------------------------------------------

static uint32_t rows_per_step(const struct vw_trainer *trainer) {
    return vw_validation_rows_per_measurement(&trainer->validation);
}

// Returns one step more than a submission takes: the first submission also contains step 0.
static uint32_t records_per_slot(const struct vw_trainer *trainer) {
    return trainer->photo_order.submission_steps_max + 1;
}

static uint32_t rows_per_slot(const struct vw_trainer *trainer) {
    return records_per_slot(trainer) * rows_per_step(trainer);
}

static enum vw_status allocate_records(struct vw_trainer *trainer) {
    size_t count = records_per_slot(trainer);
    trainer->records = vw_allocate(count, sizeof *trainer->records);
    trainer->view_errors = vw_allocate(count * trainer->validation.view_count, sizeof *trainer->view_errors);
    return trainer->records && trainer->view_errors ? VW_OK : VW_ERROR_MEMORY;
}

// Returns the room of a submission. On a CPU a step takes milliseconds: room for 128 default steps is enough for a
// submission.
static struct vw_submission_room submission_room(const struct vw_trainer *trainer) {
    bool is_cpu = vw_gpu_get_info(trainer->gpu)->kind == VW_GPU_CPU;
    return (struct vw_submission_room){.pixels_per_step = trainer->config.rays,
                                       .bytes_per_step =
                                           (sizeof(struct vw_pixel) + vw_effects_pixel_bytes(&trainer->model)) *
                                               (uint64_t)trainer->config.rays +
                                           sizeof(vw_float4) * (uint64_t)rows_per_step(trainer),
                                       .submission_bytes = is_cpu ? 1000000 : 1 << 25};
}

static enum vw_status create_transfers(struct vw_trainer *trainer, const struct vw_device_photos *photos,
                                       uint32_t steps_per_submission) {
    const struct vw_submission_room room = submission_room(trainer);
    vw_photo_order_set_submissions(&trainer->photo_order, &room, steps_per_submission);
    uint64_t slot_pixels = (uint64_t)trainer->config.rays * trainer->photo_order.submission_steps_max;
    const struct vw_buffer_params pixels = {.name = "pixels",
                                            .size_bytes = SUBMISSIONS_IN_FLIGHT * sizeof(struct vw_pixel) * slot_pixels,
                                            .memory = photos ? VW_BUFFER_DEVICE : VW_BUFFER_UPLOAD};
    const struct vw_buffer_params scalars = {.name = "scalars",
                                             .size_bytes = 16ull * SUBMISSIONS_IN_FLIGHT * rows_per_slot(trainer),
                                             .memory = VW_BUFFER_READBACK};
    enum vw_status status = allocate_records(trainer);
    if (!status) status = vw_buffer_create(trainer->gpu, &pixels, &trainer->pixels);
    if (!status) status = vw_buffer_create(trainer->gpu, &scalars, &trainer->scalars);
    return status;
}

static enum vw_status take_effects(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    if (!params->effects || params->effect_count > VW_EFFECT_COUNT_MAX)
        return vw_fail(VW_ERROR_USAGE, "the trainer has no decisions on effects; decide or list them first");
    trainer->effect_count = params->effect_count;
    memcpy(trainer->effects, params->effects, params->effect_count * sizeof *params->effects);
    enum vw_status status = vw_effects_follow_field(&trainer->config, trainer->effects, trainer->effect_count);
    trainer->masks = vw_effects_obey_masks(trainer->scene, trainer->effects, trainer->effect_count);
    return status;
}

static enum vw_status choose_views(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    enum vw_status status = vw_photo_order_create(trainer->scene, params->train_views, params->train_view_count,
                                                  &trainer->config, &trainer->photo_order);
    if (!status)
        status = vw_photo_order_leave_out(params->left_out_views, params->left_out_count, &trainer->photo_order);
    if (!status && trainer->validate) status = vw_validation_list_views(trainer->scene, &trainer->validation);
    return status;
}

static struct vw_device_choices choose(const struct vw_gpu *gpu, const struct vw_trainer_params *params) {
    struct vw_device_choices choices;
    vw_device_choose(vw_gpu_get_info(gpu), &choices);
    return params->choices ? *params->choices : choices;
}

static enum vw_status create_field(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    const struct vw_device_choices choices = choose(trainer->gpu, params);
    enum vw_status status = vw_model_create(&trainer->config, trainer->scene, trainer->photo_order.train_views,
                                            trainer->photo_order.train_count, trainer->effects, &choices,
                                            vw_gpu_get_limits(trainer->gpu), &trainer->model);
    trainer->model.awaits_params = params->awaits_field;
    uint64_t seed = vw_config_seed_of(&trainer->config, VW_VARY_INIT);
    return !status ? vw_field_create(trainer->gpu, &trainer->model, trainer->scene, seed, &trainer->field) : status;
}

static enum vw_status create_validation(struct vw_trainer *trainer) {
    const struct vw_validation_params params = {.field = &trainer->field,
                                                .scene = trainer->scene,
                                                .ray_count = trainer->config.val_rays,
                                                .seed = vw_config_seed_of(&trainer->config, VW_VARY_VALIDATION),
                                                .masks = trainer->masks,
                                                .scalars = trainer->scalars};
    return trainer->validate ? vw_validation_create(&params, &trainer->validation) : VW_OK;
}

static struct vw_trainer_parts list_parts(struct vw_trainer *trainer) {
    return (struct vw_trainer_parts){.scene = trainer->scene,
                                     .config = &trainer->config,
                                     .effects = trainer->effects,
                                     .effect_count = trainer->effect_count,
                                     .masks = trainer->masks,
                                     .field = &trainer->field,
                                     .step = &trainer->step,
                                     .validation = &trainer->validation,
                                     .photo_order = &trainer->photo_order,
                                     .pixels = trainer->pixels,
                                     .scalars = trainer->scalars};
}

// ---- Submission -----------------------------------------------------------------------------------------------------

static void record_training(struct vw_trainer *trainer, struct vw_submission *submission, uint64_t step,
                            uint32_t first_pixel, uint32_t scalar_row) {
    uint32_t view = vw_photo_order_view_of_step(&trainer->photo_order, step);
    const struct vw_pixel_draw drawn = {vw_config_seed_of(&trainer->config, VW_VARY_PIXELS), step,
                                        .picture_side = trainer->model.picture_side, .masks = trainer->masks};
    vw_step_draw_pixels(&trainer->step, submission, view, &drawn, first_pixel);
    vw_step_record_passes(&trainer->step, submission, step, first_pixel, scalar_row);
    vw_validation_record(&trainer->validation, submission, scalar_row);
}

static uint64_t last_step(const struct vw_trainer *trainer) {
    uint64_t total = vw_photo_order_total_steps(&trainer->photo_order);
    return trainer->stop_step < total ? trainer->stop_step : total;
}

static bool has_steps(const struct vw_trainer *trainer, uint32_t index) {
    return !trainer->failure && !trainer->slots[index].in_flight && trainer->next_step <= last_step(trainer);
}

// Takes the photos of the next submission and, because that is done in parallel, of some steps after it.
static enum vw_status take_photos(struct vw_trainer *trainer) {
    enum { STEPS_LEAST = 16 };
    uint64_t first = trainer->next_step ? trainer->next_step : 1,
             total = vw_photo_order_total_steps(&trainer->photo_order);
    uint32_t steps =
        trainer->photo_order.submission_steps > STEPS_LEAST ? trainer->photo_order.submission_steps : STEPS_LEAST;
    uint32_t *views = vw_allocate(steps, sizeof *views), count = 0;
    if (!views) return VW_ERROR_MEMORY;
    for (; count < steps && first + count <= total; count++)
        views[count] = vw_photo_order_view_of_step(&trainer->photo_order, first + count);
    enum vw_status status = vw_step_take_photos(&trainer->step, views, count);
    free(views);
    return status;
}

static void take_photos_or_fail(struct vw_trainer *trainer) {
    trainer->failure = take_photos(trainer);
    if (trainer->failure) trainer->why = vw_error_save();
}

static void record_steps(struct vw_trainer *trainer, uint32_t index, struct vw_submission *submission) {
    uint32_t row = index * rows_per_slot(trainer), steps = trainer->photo_order.submission_steps;
    uint32_t pixel = index * trainer->photo_order.submission_steps_max * trainer->config.rays;
    struct vw_submission_slot *slot = &trainer->slots[index];
    if (!vw_trainer_in_flight(trainer)) trainer->next_slot = index;
    *slot = (struct vw_submission_slot){.first_step = trainer->next_step, .in_flight = true};
    if (trainer->next_step == 0) { // the untrained field
        vw_validation_record(&trainer->validation, submission, row);
        row += rows_per_step(trainer);
        slot->row_count++;
        trainer->next_step++;
    }
    for (uint64_t last = last_step(trainer); steps > 0 && trainer->next_step <= last; steps--) {
        record_training(trainer, submission, trainer->next_step++, pixel, row);
        pixel += trainer->config.rays;
        row += rows_per_step(trainer);
        slot->row_count++;
    }
}

// ---- Life -----------------------------------------------------------------------------------------------------------

// Joins the submissions as the last part: from then on a trainer that shares them is recorded when others advance.
static enum vw_status join_submissions(struct vw_trainer *trainer, struct vw_submissions *submissions) {
    const struct vw_submissions_member member = {trainer, has_steps, take_photos_or_fail, record_steps};
    enum vw_status status = vw_submissions_join(submissions, &member);
    if (!status) trainer->submissions = submissions;
    return status;
}

// Asks the choice, unless a field is loaded and no step follows, an effect fills in something beside the pixels, or the
// host leaves some out.
static bool draws_on_device(const struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    bool sorted = trainer->config.field != VW_FIELD_SPLATS && vw_pixels_are_sorted(trainer->scene, trainer->masks);
    return choose(trainer->gpu, params).draws_pixels && !params->awaits_field && !sorted &&
           !vw_effects_pixel_bytes(&trainer->model);
}

static enum vw_status create_parts(struct vw_trainer *trainer, const struct vw_trainer_params *params) {
    enum vw_status status = vw_config_check(&trainer->config);
    if (!status && trainer->config.field == VW_FIELD_AUTO)
        status = vw_fail(VW_ERROR_USAGE, "--field: none is chosen; give hash, mlp or splats");
    if (!status) status = take_effects(trainer, params);
    if (!status) status = choose_views(trainer, params);
    if (!status) status = create_field(trainer, params);
    if (!status && !params->submissions) status = vw_submissions_create(trainer->gpu, &trainer->own_submissions);
    struct vw_submissions *submissions = params->submissions ? params->submissions : trainer->own_submissions;
    struct vw_device_photos *photos = NULL;
    if (!status && draws_on_device(trainer, params))
        photos = vw_submissions_take_photos(submissions, trainer->gpu, trainer->scene);
    if (!status) status = create_transfers(trainer, photos, params->steps_per_submission);
    if (!status)
        status = vw_step_create(&trainer->field, &trainer->photo_order, trainer->pixels, trainer->scalars, photos,
                                &trainer->step);
    if (!status) status = create_validation(trainer);
    trainer->parts = list_parts(trainer);
    return !status ? join_submissions(trainer, submissions) : status;
}

enum vw_status vw_trainer_create(const struct vw_trainer_params *params, struct vw_trainer **out) {
    struct vw_trainer *trainer = vw_allocate(1, sizeof *trainer);
    if (!trainer) return VW_ERROR_MEMORY;
    trainer->gpu = params->gpu;
    trainer->scene = params->scene;
    trainer->config = *params->config;
    trainer->validate = params->validate;
    trainer->stop_step = UINT64_MAX;
    enum vw_status status = create_parts(trainer, params);
    if (status) vw_trainer_destroy(&trainer);
    else *out = trainer;
    return status;
}

void vw_trainer_destroy(struct vw_trainer **pointer) {
    struct vw_trainer *trainer = *pointer;
    if (!trainer) return;
    if (trainer->submissions) vw_submissions_leave(trainer->submissions, trainer);
    vw_submissions_destroy(&trainer->own_submissions);
    vw_validation_destroy(&trainer->validation);
    vw_step_destroy(&trainer->step);
    vw_field_destroy(&trainer->field);
    vw_model_destroy(&trainer->model);
    vw_photo_order_destroy(&trainer->photo_order);
    vw_buffer_destroy(&trainer->pixels);
    vw_buffer_destroy(&trainer->scalars);
    free(trainer->records);
    free(trainer->view_errors);
    free(trainer);
    *pointer = NULL;
}

// ---- Handing out ----------------------------------------------------------------------------------------------------

static void read_measurement(const struct vw_trainer *trainer, const vw_float4 *rows, struct vw_view_error *views,
                             struct vw_step_record *record) {
    const struct vw_field_measurement measured = vw_validation_read(&trainer->validation, rows, views);
    record->validated = true;
    record->views = views;
    record->view_count = trainer->validation.view_count;
    record->val_psnr = measured.val_psnr;
    record->val_psnr_pooled = measured.val_psnr_pooled;
    record->val_l1 = measured.val_l1;
    record->floored_views = measured.floored_views;
    record->nonfinite |= !measured.finite;
}

// Blanks the values of a step that was skipped, or whose validation is not finite (decision 8).
static void blank_nonfinite(struct vw_step_record *record) {
    if (!record->nonfinite) return;
    record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
    if (!isfinite(record->train_loss)) record->train_loss = NAN;
}

static void read_record(struct vw_trainer *trainer, uint64_t step, uint32_t index, const vw_float4 *rows) {
    struct vw_step_record *record = &trainer->records[index];
    *record = (struct vw_step_record){.step = step,
                                      .view = VW_RECORD_UNTRAINED,
                                      .train_loss = NAN,
                                      .val_psnr = NAN,
                                      .val_psnr_pooled = NAN,
                                      .val_l1 = NAN};
    if (step > 0) {
        record->epoch = vw_photo_order_epoch_of_step(&trainer->photo_order, step);
        record->view = vw_photo_order_view_of_step(&trainer->photo_order, step);
        record->train_loss = ((double)rows->x + rows->y) / trainer->config.rays;
        record->nonfinite = rows->z != 0.0f;
        record->clamped_count = (uint64_t)rows->w;
    }
    if (trainer->validate)
        read_measurement(trainer, rows, trainer->view_errors + (size_t)index * trainer->validation.view_count, record);
    blank_nonfinite(record);
    trainer->nonfinite_steps += record->nonfinite;
    trainer->clamped_count += record->clamped_count;
    trainer->floored_steps += record->floored_views > 0;
}

enum vw_status vw_trainer_collect(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count) {
    uint32_t index = trainer->next_slot;
    struct vw_submission_slot *slot = &trainer->slots[index];
    *records = trainer->records;
    *count = 0;
    if (!slot->in_flight && trainer->failure) vw_error_restore(&trainer->why);
    if (!slot->in_flight) return trainer->failure ? trainer->failure : vw_submissions_check(trainer->submissions);
    trainer->next_slot = (index + 1) % SUBMISSIONS_IN_FLIGHT;
    enum vw_status status = vw_submissions_wait(trainer->submissions, index);
    slot->in_flight = false;
    if (status) return status;
    vw_photo_order_adapt_submissions(&trainer->photo_order, slot->row_count, trainer->submissions->took_s[index]);
    const vw_float4 *rows = (const vw_float4 *)vw_buffer_map(trainer->scalars) + (size_t)index * rows_per_slot(trainer);
    for (uint32_t i = 0; i < slot->row_count; i++)
        read_record(trainer, slot->first_step + i, i, rows + (size_t)i * rows_per_step(trainer));
    *count = slot->row_count;
    return VW_OK;
}

// Fills the slots from the oldest on, so that one submission runs while another's records are read.
enum vw_status vw_trainer_advance(struct vw_trainer *trainer, const struct vw_step_record **records, uint32_t *count) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < SUBMISSIONS_IN_FLIGHT && !status; i++) {
        uint32_t index = (trainer->next_slot + i) % SUBMISSIONS_IN_FLIGHT;
        if (has_steps(trainer, index)) status = vw_submissions_submit(trainer->submissions, index);
    }
    return !status ? vw_trainer_collect(trainer, records, count) : status;
}

bool vw_trainer_in_flight(const struct vw_trainer *trainer) {
    for (int i = 0; i < SUBMISSIONS_IN_FLIGHT; i++)
        if (trainer->slots[i].in_flight) return true;
    return false;
}

void vw_trainer_stop_after(struct vw_trainer *trainer, uint64_t step) { trainer->stop_step = step; }
