#include "train/probes/noise_probe.h"

#include <stdlib.h>

#include "train/trainer_private.h"
#include "gpu/compute.h"
#include "train/trainer.h"
#include "base/memory.h"

enum { PROBE_EPOCHS = 8 }; // an eighth of the steps, each costing about seven: a run takes not quite twice the time

// ---- Creation
// ---------------------------------------------------------------------------------------------------------

enum vw_status noise_probe_create(struct vw_trainer *trainer, struct noise_probe **out) {
    struct noise_probe *probe = vw_allocate(1, sizeof *probe);
    if (!probe) return VW_ERROR_MEMORY;
    probe->zero_rate_model = trainer->model;
    probe->zero_rate_model.specialization.learning_rate = 0.0f;
    probe->zero_rate_field = trainer->field;
    probe->zero_rate_field.model = &probe->zero_rate_model;
    enum vw_status status = step_create(&probe->zero_rate_field, &trainer->config, trainer->pixels, trainer->scalars,
                                        &probe->zero_rate_step);
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

// ---- Probing
// ----------------------------------------------------------------------------------------------------------

bool noise_probe_due(struct vw_trainer *trainer, uint64_t step) {
    uint32_t epoch = trainer_epoch_of_step(trainer, step);
    return trainer->noise_probe && step > 0 && epoch >= trainer->config.burn_in_epochs &&
           (epoch + trainer_photo_of_step(trainer, step)) % PROBE_EPOCHS == 0;
}

enum vw_probe_kind noise_probe_kind(uint32_t index) {
    if (index == 0) return VW_PROBE_REPEATED;
    return index == 1 ? VW_PROBE_ZERO_LEARNING_RATE : VW_PROBE_RESAMPLED;
}

void noise_probe_record(const struct vw_trainer *trainer, struct vw_batch *batch, uint64_t step, uint32_t first_pixel,
                        uint32_t scalar_row) {
    uint32_t measurement_rows = trainer_rows_per_measurement(trainer);
    snapshot_record_save(&trainer->snapshot, batch);
    for (uint32_t i = 0; i < PROBES_PER_STEP; i++, scalar_row += measurement_rows) {
        enum vw_probe_kind kind = noise_probe_kind(i);
        if (kind == VW_PROBE_ZERO_LEARNING_RATE)
            step_record(&trainer->noise_probe->zero_rate_step, batch, step, first_pixel, scalar_row);
        if (kind == VW_PROBE_RESAMPLED) {
            first_pixel += trainer->config.rays;
            step_record(&trainer->step, batch, step, first_pixel, scalar_row);
        }
        trainer_record_validation(trainer, batch, scalar_row);
        snapshot_record_restore(&trainer->snapshot, batch);
    }
}
