#include "train/files/snapshot.h"

enum vw_status vw_snapshot_create(const struct vw_step_passes *step, struct vw_snapshot *snapshot) {
    enum vw_status status = VW_OK;
    snapshot->objects.gpu = step->field->gpu;
    snapshot->count = vw_step_training_state(step, snapshot->state);
    for (uint32_t i = 0; i < snapshot->count && !status; i++) {
        const struct vw_buffer_row copy = {&snapshot->copies[i], "snapshot", vw_buffer_size_bytes(snapshot->state[i])};
        status = vw_buffers_create(&snapshot->objects, VW_BUFFER_DEVICE, &copy, 1);
    }
    return status;
}

void vw_snapshot_destroy(struct vw_snapshot *snapshot) { vw_gpu_objects_destroy(&snapshot->objects); }

void vw_snapshot_record_save(const struct vw_snapshot *snapshot, struct vw_submission *submission) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_submission_copy(submission, snapshot->state[i], 0, snapshot->copies[i], 0,
                           vw_buffer_size_bytes(snapshot->copies[i]));
}

void vw_snapshot_record_restore(const struct vw_snapshot *snapshot, struct vw_submission *submission) {
    for (uint32_t i = 0; i < snapshot->count; i++)
        vw_submission_copy(submission, snapshot->copies[i], 0, snapshot->state[i], 0,
                           vw_buffer_size_bytes(snapshot->copies[i]));
}
