#include "train/adjoint/lasting.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "train/files/training_files.h"

static const double ADVANCE_SECONDS = 0.5;

// ---- States of U ----------------------------------------------------------------------------------------------------

// Returns the length of the last epochs, in steps.
static uint64_t state_span(const struct vw_lasting *lasting) {
    uint64_t span = (uint64_t)VW_LASTING_EPOCHS * lasting->replay.context->photo_order->train_count;
    return span < lasting->replay.total_steps ? span : lasting->replay.total_steps;
}

uint32_t vw_lasting_state_count(const struct vw_lasting *lasting) {
    uint64_t span = state_span(lasting);
    return span < VW_LASTING_STATES ? (uint32_t)span : VW_LASTING_STATES;
}

// Returns whether a state is after this step. Steps are counted from the end: state i is span * i / count steps before
// it.
bool vw_lasting_is_state(const struct vw_lasting *lasting, uint64_t step) {
    uint64_t before_end = lasting->replay.total_steps - step, span = state_span(lasting),
             count = vw_lasting_state_count(lasting);
    uint64_t state = (before_end * count + span - 1) / span;
    return state < count && state * span / count == before_end;
}

uint64_t vw_lasting_first_state(const struct vw_lasting *lasting) {
    uint64_t span = state_span(lasting), count = vw_lasting_state_count(lasting);
    return lasting->replay.total_steps - (count - 1) * span / count;
}

// ---- Life -----------------------------------------------------------------------------------------------------------

static uint64_t state_bytes(const struct vw_lasting *lasting) {
    struct vw_buffer *buffers[TRAINING_STATE_BUFFERS_MAX];
    const struct vw_buffer_list list = {buffers, vw_step_training_state(lasting->replay.context->step, buffers)};
    return vw_buffer_list_bytes(&list);
}

static uint64_t stored_bytes(const struct vw_lasting *lasting, uint64_t segment_steps) {
    uint64_t segments = (lasting->replay.total_steps + segment_steps - 1) / segment_steps;
    return segment_steps * vw_stored_step_bytes(lasting->replay.context->step) + segments * state_bytes(lasting);
}

static uint64_t default_memory_bytes(const struct vw_gpu *gpu) { return vw_gpu_get_info(gpu)->memory_bytes / 4; }

static uint64_t segment_steps_most(const struct vw_lasting *lasting) {
    const struct vw_radiance_field *field = lasting->replay.context->field;
    uint64_t blocks = vw_gpu_get_limits(field->gpu)->buffer_bytes / field->model->param_bytes;
    return blocks > 2 ? blocks - 1 : 1;
}

// Returns the length of a segment with which its steps, and the states at the beginnings of all segments, take the
// least memory.
static uint64_t thriftiest_steps(const struct vw_lasting *lasting) {
    double steps = (double)lasting->replay.total_steps, state = (double)state_bytes(lasting);
    uint64_t thriftiest =
                 (uint64_t)ceil(sqrt(steps * state / (double)vw_stored_step_bytes(lasting->replay.context->step))),
             most = segment_steps_most(lasting);
    return thriftiest < 1 ? 1 : thriftiest < most ? thriftiest : most;
}

// Puts all steps into one segment where memory allows, or else chooses the length that takes the least memory.
static enum vw_status choose_segments(struct vw_lasting *lasting, uint64_t memory_bytes) {
    uint64_t steps = lasting->replay.total_steps;
    if (steps > segment_steps_most(lasting) || stored_bytes(lasting, steps) > memory_bytes)
        steps = thriftiest_steps(lasting);
    if (stored_bytes(lasting, steps) > memory_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "lasting credit keeps at least %" PRIu64
                       " MiB of states of this training, more than the %" PRIu64
                       " MiB that it may take; value the scene with fewer epochs or a lower --log2-table",
                       stored_bytes(lasting, steps) >> 20, memory_bytes >> 20);
    lasting->segment_steps = steps;
    lasting->segment_count = (uint32_t)((lasting->replay.total_steps + steps - 1) / steps);
    return VW_OK;
}

// Returns the memory for the adjoints of single views: what remains when the states of steps take the least they need.
static uint64_t views_memory_bytes(const struct vw_lasting *lasting, uint64_t memory_bytes) {
    uint64_t least_bytes = stored_bytes(lasting, thriftiest_steps(lasting));
    return memory_bytes > least_bytes ? memory_bytes - least_bytes : 0;
}

static void begin(struct vw_lasting *lasting, uint64_t next_step) {
    lasting->next_step = next_step;
    lasting->segment = (uint32_t)((next_step - 1) / lasting->segment_steps);
    lasting->until_step = next_step;
    lasting->replaying = true;
}

static enum vw_status create_parts(struct vw_lasting *lasting, const struct vw_lasting_params *params) {
    enum vw_status status =
        vw_step_replay_create(params->training, params->replayed, params->context, &lasting->replay);
    if (status) return status;
    uint32_t views = params->by_view ? lasting->replay.context->validation->view_count : 0;
    uint32_t measures = ADJOINT_OF_VIEWS + views;
    uint64_t memory_bytes =
        params->memory_bytes ? params->memory_bytes : default_memory_bytes(lasting->replay.context->field->gpu);
    lasting->backward_steps = (lasting->replay.submission_steps * ADJOINT_OF_VIEWS + measures - 1) / measures;
    const struct vw_adjoint_params backward = {.rays = params->rays,
                                               .submission_steps = lasting->backward_steps,
                                               .by_view = params->by_view,
                                               .views_memory_bytes = views_memory_bytes(lasting, memory_bytes)};
    status = vw_adjoint_create(lasting->replay.context, &backward, &lasting->backward);
    if (!status) status = choose_segments(lasting, memory_bytes - vw_adjoint_views_bytes(&lasting->backward));
    if (!status)
        status =
            vw_stored_steps_create(lasting->replay.context->step, (uint32_t)lasting->segment_steps, &lasting->stored);
    if (status) return status;
    lasting->starts = vw_allocate(lasting->segment_count, sizeof *lasting->starts);
    lasting->credits = vw_allocate(lasting->backward_steps, sizeof *lasting->credits);
    lasting->view_psnr = vw_allocate(lasting->backward_steps, measures * sizeof *lasting->view_psnr);
    return lasting->starts && lasting->credits && lasting->view_psnr ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_lasting_check_trainer(struct vw_trainer *trainer) {
    return vw_adjoint_check(vw_trainer_get_parts(trainer));
}

enum vw_status vw_lasting_create(const struct vw_lasting_params *params, struct vw_lasting **out) {
    struct vw_lasting *lasting = vw_allocate(1, sizeof *lasting);
    if (!lasting) return VW_ERROR_MEMORY;
    enum vw_status status = create_parts(lasting, params);
    if (!status) begin(lasting, lasting->replay.total_steps);
    if (status) vw_lasting_destroy(&lasting);
    else *out = lasting;
    return status;
}

void vw_lasting_destroy(struct vw_lasting **pointer) {
    struct vw_lasting *lasting = *pointer;
    if (!lasting) return;
    for (uint32_t i = 0; lasting->starts && i < lasting->segment_count; i++) vw_snapshot_destroy(&lasting->starts[i]);
    vw_stored_steps_destroy(&lasting->stored);
    vw_adjoint_destroy(&lasting->backward);
    vw_step_replay_destroy(&lasting->replay);
    free(lasting->starts);
    free(lasting->credits);
    free(lasting->view_psnr);
    free(lasting);
    *pointer = NULL;
}

// ---- Replay ---------------------------------------------------------------------------------------------------------

// Returns the place of a step within the stored segment, or UINT32_MAX.
static uint32_t place_of(const struct vw_lasting *lasting, uint64_t step) {
    uint64_t before = lasting->segment * lasting->segment_steps;
    return step > before ? (uint32_t)(step - before - 1) : UINT32_MAX;
}

static enum vw_status save_start(struct vw_lasting *lasting, uint64_t step) {
    struct vw_snapshot *start = &lasting->starts[(step - 1) / lasting->segment_steps];
    if ((step - 1) % lasting->segment_steps != 0 || start->count) return VW_OK;
    enum vw_status status = vw_snapshot_create(lasting->replay.context->step, start);
    if (!status) vw_snapshot_record_save(start, lasting->replay.submission);
    return status;
}

// Replays a submission. A step is reported at its first replay only.
static enum vw_status replay_submission(struct vw_lasting *lasting) {
    uint64_t first = lasting->state_step + 1, left = lasting->until_step - lasting->state_step;
    uint32_t count = left < lasting->replay.submission_steps ? (uint32_t)left : lasting->replay.submission_steps;
    bool known = lasting->segment + 1 < lasting->segment_count && lasting->starts[lasting->segment + 1].count;
    enum vw_status status = VW_OK;
    vw_submission_begin(lasting->replay.submission);
    for (uint32_t i = 0; i < count && !status; i++) {
        uint32_t pixel = vw_step_replay_draw(&lasting->replay, first + i, i), place = place_of(lasting, first + i);
        status = save_start(lasting, first + i);
        if (place == UINT32_MAX)
            vw_step_record_passes(lasting->replay.context->step, lasting->replay.submission, first + i, pixel,
                                  vw_step_replay_row(&lasting->replay, i));
        else
            vw_adjoint_record_stored_step(&lasting->backward, &lasting->stored, lasting->replay.submission, first + i,
                                          pixel, vw_step_replay_row(&lasting->replay, i), place);
    }
    enum vw_status ran = vw_step_replay_run(&lasting->replay);
    if (!status) status = ran;
    if (!status && !known) status = vw_step_replay_tell(&lasting->replay, first, count);
    lasting->state_step += count;
    lasting->work_done += count;
    lasting->replaying = lasting->state_step < lasting->until_step;
    return status;
}

static enum vw_status begin_segment(struct vw_lasting *lasting, uint32_t segment) {
    lasting->segment = segment;
    lasting->state_step = segment * lasting->segment_steps;
    lasting->until_step = lasting->state_step + lasting->segment_steps;
    lasting->replaying = true;
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_restore(&lasting->starts[segment], lasting->replay.submission);
    return vw_step_replay_run(&lasting->replay);
}

// ---- Backward pass --------------------------------------------------------------------------------------------------

static double read_views(const struct vw_lasting *lasting, const vw_float4 *rows, double *view_psnr) {
    double sum = 0.0;
    for (uint32_t i = ADJOINT_OF_VIEWS; i < lasting->backward.measure_count; i++)
        sum += *view_psnr++ = (double)rows[i].x + rows[i].y;
    return sum;
}

static enum vw_status read_credits(struct vw_lasting *lasting, uint32_t count) {
    uint32_t measures = lasting->backward.measure_count, views = measures - ADJOINT_OF_VIEWS;
    const vw_float4 *rows = vw_buffer_map(lasting->backward.rows);
    for (uint32_t i = 0; i < count; i++, rows += measures) {
        double *view_psnr = &lasting->view_psnr[(size_t)i * views];
        const vw_float4 *psnr = &rows[ADJOINT_PSNR], *loss = &rows[ADJOINT_LOSS];
        struct vw_lasting_credit *credit = &lasting->credits[i];
        *credit = (struct vw_lasting_credit){.step = lasting->next_step - i,
                                             .psnr = (double)psnr->x + psnr->y,
                                             .loss = (double)loss->x + loss->y,
                                             .view_psnr = views ? view_psnr : NULL,
                                             .size_psnr = psnr->z,
                                             .size_loss = loss->z};
        credit->view = vw_photo_order_view_of_step(lasting->replay.context->photo_order, credit->step);
        double of_views = read_views(lasting, rows, view_psnr);
        if (!isfinite(credit->psnr + credit->loss + credit->size_psnr + credit->size_loss + of_views))
            return vw_fail(VW_ERROR_DEVICE,
                           "lasting credit: the backward pass diverged at step %" PRIu64
                           "; value the scene with a lower --lr",
                           credit->step);
    }
    return VW_OK;
}

// Returns the work of a step, in replayed steps: the more is carried back, the longer it takes.
static uint64_t backward_work(const struct vw_lasting *lasting) {
    return (lasting->backward.measure_count + 1) / ADJOINT_OF_VIEWS;
}

static enum vw_status go_back_submission(struct vw_lasting *lasting, uint32_t *handed_out) {
    uint64_t before = lasting->segment * lasting->segment_steps, left = lasting->next_step - before;
    uint32_t count = left < lasting->backward_steps ? (uint32_t)left : lasting->backward_steps,
             states = vw_lasting_state_count(lasting);
    const struct vw_step_blocks *blocks = &lasting->backward.blocks;
    vw_submission_begin(lasting->replay.submission);
    for (uint32_t i = 0; i < count; i++) {
        uint64_t step = lasting->next_step - i;
        uint32_t pixel = vw_step_replay_draw(&lasting->replay, step, i);
        vw_stored_steps_record_load(&lasting->stored, lasting->replay.submission, place_of(lasting, step), blocks);
        if (vw_lasting_is_state(lasting, step))
            vw_adjoint_record_state(&lasting->backward, lasting->replay.submission,
                                    vw_step_replay_row(&lasting->replay, i), states);
        vw_adjoint_record_step(&lasting->backward, lasting->replay.submission, step, pixel,
                               i * lasting->backward.measure_count);
    }
    enum vw_status status = vw_step_replay_run(&lasting->replay);
    if (!status) status = read_credits(lasting, count);
    if (status) return status;
    *handed_out = count;
    lasting->next_step -= count;
    lasting->work_done += count * backward_work(lasting);
    return lasting->next_step == before && before > 0 ? begin_segment(lasting, lasting->segment - 1) : VW_OK;
}

enum vw_status vw_lasting_advance(struct vw_lasting *lasting, const struct vw_lasting_credit **credits, uint32_t *count,
                                  bool *done) {
    double started_s = vw_now_s();
    enum vw_status status = VW_OK;
    *credits = lasting->credits;
    *count = 0;
    while (!status && lasting->replaying && vw_now_s() - started_s < ADVANCE_SECONDS)
        status = replay_submission(lasting);
    if (!status && !lasting->replaying && lasting->next_step > 0) status = go_back_submission(lasting, count);
    *done = lasting->next_step == 0;
    return status;
}

void vw_lasting_get_state(const struct vw_lasting *lasting, struct vw_lasting_state *state) {
    uint64_t first_stored = lasting->segment * lasting->segment_steps, replay_left = 0;
    if (lasting->replaying) replay_left = lasting->until_step - lasting->state_step;
    *state = (struct vw_lasting_state){
        .work_done = lasting->work_done,
        .work_total = lasting->work_done + replay_left + first_stored + lasting->next_step * backward_work(lasting),
        .next_step = lasting->next_step,
        .memory_bytes = stored_bytes(lasting, lasting->segment_steps) + vw_adjoint_views_bytes(&lasting->backward)};
}

// ---- Files ----------------------------------------------------------------------------------------------------------

static const char magic[] = "viewworth adjoint 1\n";
static const char remedy[] = "remove the file: the backward pass starts again";

static enum vw_status list_adjoints(const struct vw_lasting *lasting, struct vw_buffer_list *list) {
    uint32_t measures = lasting->backward.measure_count;
    struct vw_buffer **buffers = vw_allocate(measures, 2 * sizeof *buffers);
    if (!buffers) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < measures; i++) {
        buffers[2 * i] = lasting->backward.by_measure[i].lambda;
        buffers[2 * i + 1] = lasting->backward.by_measure[i].moment; // NULL entries are skipped
    }
    *list = (struct vw_buffer_list){.buffers = buffers, .count = 2 * measures};
    return VW_OK;
}

// Writes what the file says of itself except the step: the run and the settings.
static enum vw_status describe(const struct vw_lasting *lasting, uint64_t next_step, char **text) {
    uint8_t run_id[VW_HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    enum vw_status status = vw_trainer_run_id(lasting->replay.trainer, run_id);
    if (status) return status;
    vw_hash_to_hex(run_id, hex);
    *text = vw_format_text("{\"run_id\":\"%s\",\"steps\":%" PRIu64
                           ",\"rays\":%u,\"states\":%u,\"views\":%u,\"next_step\":%" PRIu64 "}",
                           hex, lasting->replay.total_steps, lasting->backward.rays, vw_lasting_state_count(lasting),
                           lasting->backward.measure_count - ADJOINT_OF_VIEWS, next_step);
    return *text ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_lasting_save(struct vw_lasting *lasting, const char *path, const void *rows, size_t row_bytes) {
    struct vw_buffer_list list = {0};
    char *description = NULL;
    enum vw_status status = list_adjoints(lasting, &list);
    list.tail = rows;
    list.tail_bytes = (size_t)(lasting->replay.total_steps - lasting->next_step) * row_bytes;
    if (!status) status = describe(lasting, lasting->next_step, &description);
    if (!status) status = vw_hashed_file_save(path, magic, description, &list);
    free(description);
    free((void *)list.buffers);
    return status;
}

static enum vw_status check_description(const struct vw_lasting *lasting, const char *path, const char *text,
                                        uint64_t *next_step) {
    json_int_t saved = -1;
    char *expected = NULL;
    json_t *object = vw_json_load(text, strlen(text), 0, NULL);
    bool known = object && json_unpack(object, "{s:I}", "next_step", &saved) == 0 && saved > 0 &&
                 (uint64_t)saved <= lasting->replay.total_steps;
    json_decref(object);
    if (!known) return vw_fail(VW_ERROR_INPUT, "%s: does not say which step it holds; %s", path, remedy);
    enum vw_status status = describe(lasting, (uint64_t)saved, &expected);
    if (!status && strcmp(text, expected) != 0)
        status = vw_fail(VW_ERROR_INPUT, "%s: of another run or of other settings; %s", path, remedy);
    free(expected);
    if (!status) *next_step = (uint64_t)saved;
    return status;
}

// Copies the rows that follow the adjoints, which end the payload.
static enum vw_status take_rows(const struct vw_hashed_file *file, const char *path, uint64_t adjoint_bytes,
                                uint64_t rows_bytes, void **rows) {
    if (file->payload_bytes != adjoint_bytes + rows_bytes)
        return vw_fail(VW_ERROR_INPUT, "%s: holds %" PRIu64 " bytes, not the %" PRIu64 " of this run; %s", path,
                       file->payload_bytes, adjoint_bytes + rows_bytes, remedy);
    *rows = vw_allocate((size_t)rows_bytes, 1);
    if (!*rows) return VW_ERROR_MEMORY;
    memcpy(*rows, file->payload + adjoint_bytes, (size_t)rows_bytes);
    return VW_OK;
}

enum vw_status vw_lasting_load(struct vw_lasting *lasting, const char *path, size_t row_bytes, void **rows,
                               uint64_t *next_step) {
    struct vw_buffer_list list = {0};
    struct vw_hashed_file file = {0};
    void *taken = NULL;
    uint64_t total = lasting->replay.total_steps;
    enum vw_status status = list_adjoints(lasting, &list);
    uint64_t adjoint_bytes = vw_buffer_list_bytes(&list);
    if (!status) status = vw_hashed_file_open(path, magic, adjoint_bytes + total * row_bytes, remedy, &file);
    if (!status) status = check_description(lasting, path, file.description, next_step);
    if (!status) status = take_rows(&file, path, adjoint_bytes, (total - *next_step) * row_bytes, &taken);
    if (!status) status = vw_hashed_file_load(&file, &list);
    vw_hashed_file_close(&file);
    free((void *)list.buffers);
    if (status) {
        free(taken);
        return status;
    }
    *rows = taken;
    begin(lasting, *next_step);
    return VW_OK;
}

// ---- The gate -------------------------------------------------------------------------------------------------------

// Retrainings in which the steps on one photo are longer.

struct outcome {
    double psnr, loss; // U: validation PSNR, and minus validation L1, averaged over its states
};

// Takes the steps after `from_step` from the state on the device, those on `view` longer by `extra`.
static enum vw_status retrain(const struct vw_lasting *lasting, uint64_t from_step, uint32_t view, float extra,
                              struct outcome *outcome) {
    const struct vw_trainer_parts *context = lasting->replay.context;
    const vw_float4 *rows = vw_buffer_map(context->scalars);
    uint32_t states = vw_lasting_state_count(lasting), count = 0;
    enum vw_status status = VW_OK;
    *outcome = (struct outcome){0};
    for (uint64_t first = from_step + 1; first <= lasting->replay.total_steps && !status; first += count) {
        uint64_t left = lasting->replay.total_steps - first + 1;
        count = left < lasting->replay.submission_steps ? (uint32_t)left : lasting->replay.submission_steps;
        vw_submission_begin(lasting->replay.submission);
        for (uint32_t i = 0; i < count; i++) {
            uint64_t step = first + i;
            uint32_t pixel = vw_step_replay_draw(&lasting->replay, step, i);
            bool scaled = vw_photo_order_view_of_step(context->photo_order, step) == view;
            vw_step_record_gradients(context->step, lasting->replay.submission, step, pixel);
            vw_step_record_update(context->step, lasting->replay.submission, step, pixel, scaled ? extra : 0.0f);
            vw_step_record_loss(context->step, lasting->replay.submission, pixel,
                                vw_step_replay_row(&lasting->replay, i));
            if (vw_lasting_is_state(lasting, step))
                vw_validation_record(context->validation, lasting->replay.submission,
                                     vw_step_replay_row(&lasting->replay, i));
        }
        status = vw_step_replay_run(&lasting->replay);
        for (uint32_t i = 0; i < count && !status; i++) {
            if (!vw_lasting_is_state(lasting, first + i)) continue;
            const struct vw_field_measurement measured =
                vw_validation_read(context->validation, rows + vw_step_replay_row(&lasting->replay, i), NULL);
            outcome->psnr += (measured.finite ? measured.val_psnr : NAN) / states;
            outcome->loss -= (measured.finite ? measured.val_l1 : NAN) / states;
        }
    }
    return status;
}

static enum vw_status restore(const struct vw_lasting *lasting, const struct vw_snapshot *state) {
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_restore(state, lasting->replay.submission);
    return vw_step_replay_run(&lasting->replay);
}

// Brings the device into the state after `from_step`, and keeps it.
static enum vw_status prepare(const struct vw_lasting *lasting, uint64_t from_step, struct vw_snapshot *state) {
    const struct vw_trainer_parts *context = lasting->replay.context;
    uint64_t step = from_step / lasting->segment_steps * lasting->segment_steps;
    enum vw_status status = restore(lasting, &lasting->starts[step / lasting->segment_steps]);
    while (step < from_step && !status) {
        vw_submission_begin(lasting->replay.submission);
        for (uint32_t i = 0; i < lasting->replay.submission_steps && step < from_step; i++) {
            step++;
            vw_step_record_passes(context->step, lasting->replay.submission, step,
                                  vw_step_replay_draw(&lasting->replay, step, i),
                                  vw_step_replay_row(&lasting->replay, i));
        }
        status = vw_step_replay_run(&lasting->replay);
    }
    if (!status) status = vw_snapshot_create(context->step, state);
    if (status) return status;
    vw_submission_begin(lasting->replay.submission);
    vw_snapshot_record_save(state, lasting->replay.submission);
    return vw_step_replay_run(&lasting->replay);
}

// Averages what the training itself reached over the states of U: repeated, it would reach the same bits.
static struct outcome outcome_of(const struct vw_lasting *lasting, const struct vw_step_record *records) {
    struct outcome outcome = {0};
    uint32_t states = vw_lasting_state_count(lasting);
    for (uint64_t step = vw_lasting_first_state(lasting); step <= lasting->replay.total_steps; step++) {
        if (!vw_lasting_is_state(lasting, step)) continue;
        outcome.psnr += records[step].val_psnr / states;
        outcome.loss -= records[step].val_l1 / states;
    }
    return outcome;
}

enum vw_status vw_lasting_measure(struct vw_lasting *lasting, const struct vw_step_record *records, uint64_t from_step,
                                  struct vw_lasting_check *checks, uint32_t count) {
    struct vw_snapshot state = {0};
    struct outcome recorded = outcome_of(lasting, records), longer = {0};
    if (lasting->replay.context->config->beta1 > 0)
        return vw_fail(VW_ERROR_USAGE,
                       "the gate scales steps, which with momentum belong to several photos; use --no-gate");
    if (lasting->next_step != 0 || from_step >= vw_lasting_first_state(lasting))
        return vw_fail(VW_ERROR_USAGE,
                       "the gate follows the whole backward pass, from a step before the states that it measures");
    enum vw_status status = prepare(lasting, from_step, &state);
    // A step that was not finite has no values in its record, although the state after it may well have some.
    if (!status && isnan(recorded.psnr)) status = retrain(lasting, from_step, 0, 0.0f, &recorded);
    for (uint32_t i = 0; i < count && !status; i++) {
        status = restore(lasting, &state);
        if (!status) status = retrain(lasting, from_step, checks[i].view, (float)VW_LASTING_SCALED, &longer);
        checks[i].measured_psnr = (longer.psnr - recorded.psnr) / VW_LASTING_SCALED;
        checks[i].measured_loss = (longer.loss - recorded.loss) / VW_LASTING_SCALED;
    }
    vw_snapshot_destroy(&state);
    return status;
}
