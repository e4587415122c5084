#include "train/probes/first_order.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/shaders.h"

enum { COLUMN_BYTES = 16, ALIGNMENT_BYTES = 256 }; // the floor's: no device asks for more

const float first_order_reach = 0.0625f;

static uint64_t window_bytes_of(const struct first_order *first_order, uint32_t window) {
    uint64_t left = first_order->field->model->param_bytes - window * first_order->window_bytes;
    return left < first_order->window_bytes ? left : first_order->window_bytes;
}

static enum vw_status create_mix(struct first_order *first_order, uint32_t window) {
    uint64_t offset = window * first_order->window_bytes, size = window_bytes_of(first_order, window);
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_PARAMS_BEFORE, .buffer = first_order->before, .offset_bytes = offset, .size_bytes = size},
        {.slot = VW_SLOT_PARAMS_AFTER, .buffer = first_order->after, .offset_bytes = offset, .size_bytes = size},
        {.slot = VW_SLOT_PARAMS, .buffer = first_order->field->params, .offset_bytes = offset, .size_bytes = size},
    };
    const struct vw_pass_params params = {
        .shader = &vw_shader_mix_params, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    return vw_pass_create(first_order->field->gpu, &params, &first_order->mix[window]);
}

static enum vw_status create_windows(struct first_order *first_order, uint64_t binding_bytes) {
    uint64_t bytes = first_order->field->model->param_bytes, most = binding_bytes / ALIGNMENT_BYTES * ALIGNMENT_BYTES;
    assert(bytes % COLUMN_BYTES == 0 && most > 0);
    first_order->window_bytes = bytes < most ? bytes : most;
    first_order->window_count = (uint32_t)((bytes + most - 1) / most);
    first_order->mix = vw_allocate(first_order->window_count, sizeof *first_order->mix);
    enum vw_status status = first_order->mix ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < first_order->window_count && status == VW_OK; i++) status = create_mix(first_order, i);
    return status;
}

enum vw_status first_order_create(const struct field *field, uint64_t binding_bytes, struct first_order **out) {
    struct first_order *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->field = field;
    uint64_t bytes = field->model->param_bytes;
    enum vw_status status = vw_buffer_create(
        field->gpu, &(struct vw_buffer_params){.name = "params_before", .size_bytes = bytes}, &made->before);
    if (status == VW_OK)
        status = vw_buffer_create(field->gpu, &(struct vw_buffer_params){.name = "params_after", .size_bytes = bytes},
                                  &made->after);
    if (status == VW_OK) status = create_windows(made, binding_bytes);
    if (status != VW_OK) first_order_destroy(&made);
    else *out = made;
    return status;
}

void first_order_destroy(struct first_order **pointer) {
    struct first_order *dying = *pointer;
    if (!dying) return;
    for (uint32_t i = 0; dying->mix && i < dying->window_count; i++) vw_pass_destroy(&dying->mix[i]);
    free(dying->mix);
    vw_buffer_destroy(&dying->before);
    vw_buffer_destroy(&dying->after);
    free(dying);
    *pointer = NULL;
}

bool first_order_due(const struct probe_context *context, uint64_t step) {
    return context->config->first_order && step > 0 &&
           schedule_epoch_of_step(context->schedule, step) >= context->config->burn_in_epochs;
}

void first_order_record_mix(const struct first_order *first_order, struct vw_batch *batch, float reach) {
    for (uint32_t i = 0; i < first_order->window_count; i++) {
        const struct vw_push_mix push = {.count = (uint32_t)(window_bytes_of(first_order, i) / COLUMN_BYTES),
                                         .reach = reach};
        vw_batch_dispatch(batch, first_order->mix[i], &push, sizeof push, push.count);
    }
}

static void record_copy(const struct first_order *first_order, struct vw_batch *batch, struct vw_buffer *from,
                        struct vw_buffer *to) {
    vw_batch_copy(batch, from, 0, to, 0, first_order->field->model->param_bytes);
}

void first_order_record_begin(const struct first_order *first_order, struct vw_batch *batch) {
    record_copy(first_order, batch, first_order->field->params, first_order->before);
}

void first_order_record_end(const struct first_order *first_order, const struct probe_context *context,
                            struct vw_batch *batch, uint32_t scalar_row) {
    uint32_t stride = validation_rows_per_measurement(context->validation);
    record_copy(first_order, batch, first_order->field->params, first_order->after);
    for (int i = 0; i < FIRST_ORDER_MEASUREMENTS; i++, scalar_row += stride) {
        first_order_record_mix(first_order, batch, i == 0 ? first_order_reach : -first_order_reach);
        validation_record(context->validation, batch, scalar_row);
    }
    record_copy(first_order, batch, first_order->after, first_order->field->params);
}

static double slope(double ahead, double behind) { return (ahead - behind) / (2.0 * first_order_reach); }

void first_order_read(const struct probe_context *context, const vw_float4 *rows, bool skipped,
                      struct vw_probe *probe) {
    struct vw_probe ahead, behind;
    probe_read(context, rows, false, &ahead);
    probe_read(context, rows + validation_rows_per_measurement(context->validation), false, &behind);
    probe->val_psnr = skipped ? NAN : slope(ahead.val_psnr, behind.val_psnr);
    probe->val_psnr_pooled = skipped ? NAN : slope(ahead.val_psnr_pooled, behind.val_psnr_pooled);
    probe->val_l1 = skipped ? NAN : slope(ahead.val_l1, behind.val_l1);
}
