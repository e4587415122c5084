#include "train/probes/noise_probe.h"

#include <stdlib.h>

#include "base/memory.h"

enum { PROBE_EPOCHS = 8 }; // an eighth of the steps, each costing about seven: a run takes not quite twice the time

// ---- Creation -------------------------------------------------------------------------------------------------------

enum vw_status vw_noise_probe_create(const struct vw_probe_context *context, struct vw_noise_probe **out) {
    struct vw_noise_probe *probe = vw_allocate(1, sizeof *probe);
    if (!probe) return VW_ERROR_MEMORY;
    probe->zero_rate_model = *context->field->model;
    probe->zero_rate_model.specialization.learning_rate = 0.0f;
    probe->zero_rate_field = *context->field;
    probe->zero_rate_field.model = &probe->zero_rate_model;
    enum vw_status status = vw_step_create(&probe->zero_rate_field, context->config, context->schedule, context->pixels,
                                           context->scalars, &probe->zero_rate_step);
    if (status) vw_noise_probe_destroy(&probe);
    else *out = probe;
    return status;
}

void vw_noise_probe_destroy(struct vw_noise_probe **pointer) {
    struct vw_noise_probe *probe = *pointer;
    if (!probe) return;
    vw_step_destroy(&probe->zero_rate_step);
    free(probe);
    *pointer = NULL;
}

// ---- Probing --------------------------------------------------------------------------------------------------------

bool vw_noise_probe_due(const struct vw_probe_context *context, uint64_t step) {
    uint32_t epoch = vw_photo_order_epoch_of_step(context->schedule, step);
    return context->config->noise_floor && step > 0 && epoch >= context->config->burn_in_epochs &&
           (epoch + vw_photo_order_photo_of_step(context->schedule, step)) % PROBE_EPOCHS == 0;
}

static enum vw_probe_kind kind_of(uint32_t index) {
    if (index == 0) return VW_PROBE_REPEATED;
    return index == 1 ? VW_PROBE_ZERO_LEARNING_RATE : VW_PROBE_RESAMPLED;
}

void vw_noise_probe_record(const struct vw_noise_probe *probe, const struct vw_probe_context *context,
                           struct vw_submission *batch, uint64_t step, uint32_t first_pixel, uint32_t scalar_row) {
    uint32_t stride = vw_validation_rows_per_measurement(context->validation);
    vw_snapshot_record_save(context->snapshot, batch);
    for (uint32_t i = 0; i < PROBES_PER_STEP; i++, scalar_row += stride) {
        enum vw_probe_kind kind = kind_of(i);
        if (kind == VW_PROBE_ZERO_LEARNING_RATE)
            vw_step_record_passes(&probe->zero_rate_step, batch, step, first_pixel, scalar_row);
        if (kind == VW_PROBE_RESAMPLED) {
            first_pixel += context->config->rays;
            vw_step_record_passes(context->step, batch, step, first_pixel, scalar_row);
        }
        vw_validation_record(context->validation, batch, scalar_row);
        vw_snapshot_record_restore(context->snapshot, batch);
    }
}

void vw_noise_probe_read(const struct vw_probe_context *context, const vw_float4 *rows, uint64_t step,
                         struct vw_probe *probes) {
    uint32_t stride = vw_validation_rows_per_measurement(context->validation);
    for (uint32_t i = 0; i < PROBES_PER_STEP; i++) {
        enum vw_probe_kind kind = kind_of(i); // a repeat takes no step that could fail
        probes[i] = (struct vw_probe){.step = step, .index = i, .kind = kind, .view = VW_RECORD_UNTRAINED};
        vw_probe_read(context, rows + i * stride, kind != VW_PROBE_REPEATED, &probes[i]);
    }
}
