#include "train/probes/noise_probe.h"

#include <stdlib.h>

#include "base/memory.h"

enum { PROBE_EPOCHS = 8 }; // an eighth of the steps, each costing about seven: a run takes not quite twice the time

// ---- Creation -------------------------------------------------------------------------------------------------------

enum vw_status noise_probe_create(const struct probe_context *context, struct noise_probe **out) {
    struct noise_probe *probe = vw_allocate(1, sizeof *probe);
    if (!probe) return VW_ERROR_MEMORY;
    probe->zero_rate_model = *context->field->model;
    probe->zero_rate_model.specialization.learning_rate = 0.0f;
    probe->zero_rate_field = *context->field;
    probe->zero_rate_field.model = &probe->zero_rate_model;
    enum vw_status status = step_create(&probe->zero_rate_field, context->config, context->schedule, context->pixels,
                                        context->scalars, &probe->zero_rate_step);
    if (status != VW_OK) noise_probe_destroy(&probe);
    else *out = probe;
    return status;
}

void noise_probe_destroy(struct noise_probe **pointer) {
    struct noise_probe *probe = *pointer;
    if (!probe) return;
    step_destroy(&probe->zero_rate_step);
    free(probe);
    *pointer = NULL;
}

// ---- Probing --------------------------------------------------------------------------------------------------------

bool noise_probe_due(const struct probe_context *context, uint64_t step) {
    uint32_t epoch = schedule_epoch_of_step(context->schedule, step);
    return context->config->noise_floor && step > 0 && epoch >= context->config->burn_in_epochs &&
           (epoch + schedule_photo_of_step(context->schedule, step)) % PROBE_EPOCHS == 0;
}

static enum vw_probe_kind kind_of(uint32_t index) {
    if (index == 0) return VW_PROBE_REPEATED;
    return index == 1 ? VW_PROBE_ZERO_LEARNING_RATE : VW_PROBE_RESAMPLED;
}

void noise_probe_record(const struct noise_probe *probe, const struct probe_context *context, struct vw_batch *batch,
                        uint64_t step, uint32_t first_pixel, uint32_t scalar_row) {
    uint32_t stride = validation_rows_per_measurement(context->validation);
    snapshot_record_save(context->snapshot, batch);
    for (uint32_t i = 0; i < PROBES_PER_STEP; i++, scalar_row += stride) {
        enum vw_probe_kind kind = kind_of(i);
        if (kind == VW_PROBE_ZERO_LEARNING_RATE)
            step_record(&probe->zero_rate_step, batch, step, first_pixel, scalar_row);
        if (kind == VW_PROBE_RESAMPLED) {
            first_pixel += context->config->rays;
            step_record(context->step, batch, step, first_pixel, scalar_row);
        }
        validation_record(context->validation, batch, scalar_row);
        snapshot_record_restore(context->snapshot, batch);
    }
}

void noise_probe_read(const struct probe_context *context, const vw_float4 *rows, uint64_t step,
                      struct vw_probe *probes) {
    uint32_t stride = validation_rows_per_measurement(context->validation);
    for (uint32_t i = 0; i < PROBES_PER_STEP; i++) {
        enum vw_probe_kind kind = kind_of(i); // a repeat takes no step that could fail
        probes[i] = (struct vw_probe){.step = step, .index = i, .kind = kind, .view = VW_RECORD_UNTRAINED};
        probe_read(context, rows + i * stride, kind != VW_PROBE_REPEATED, &probes[i]);
    }
}
