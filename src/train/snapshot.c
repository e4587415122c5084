#include "train/snapshot.h"

enum vw_status snapshot_create(const struct step_passes *step, struct snapshot *snapshot) {
    enum vw_status status = VW_OK;
    snapshot->count = step_training_state(step, snapshot->state);
    for (uint32_t i = 0; i < snapshot->count && status == VW_OK; i++)
        status = vw_buffer_create(
            step->field->gpu,
            &(struct vw_buffer_params){.name = "snapshot", .size_bytes = vw_buffer_size_bytes(snapshot->state[i])},
            &snapshot->copies[i]);
    return status;
}

void snapshot_destroy(struct snapshot *snapshot) {
    for (uint32_t i = 0; i < snapshot->count; i++) vw_buffer_destroy(&snapshot->copies[i]);
}

void snapshot_record_save(const struct snapshot *snapshot, struct vw_batch *batch) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_batch_copy(batch, snapshot->state[i], 0, snapshot->copies[i], 0, vw_buffer_size_bytes(snapshot->copies[i]));
}

void snapshot_record_restore(const struct snapshot *snapshot, struct vw_batch *batch) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_batch_copy(batch, snapshot->copies[i], 0, snapshot->state[i], 0, vw_buffer_size_bytes(snapshot->copies[i]));
}
