#include "gpu/compute.h"
#include "train/snapshot.h"

enum vw_status snapshot_create(const struct step_passes *step, struct snapshot *kept) {
    enum vw_status status = VW_OK;
    kept->count = step_training_state(step, kept->state);
    for (uint32_t i = 0; i < kept->count && status == VW_OK; i++)
        status = vw_buffer_create(
            step->field->gpu,
            &(struct vw_buffer_params){.name = "snapshot", .size_bytes = vw_buffer_size_bytes(kept->state[i])},
            &kept->kept[i]);
    return status;
}

void snapshot_destroy(struct snapshot *kept) {
    for (uint32_t i = 0; i < kept->count; i++) vw_buffer_destroy(&kept->kept[i]);
}

void snapshot_record_save(const struct snapshot *kept, struct vw_batch *batch) {
    for (uint32_t i = 0; i < kept->count; i++)
        vw_batch_copy(batch, kept->state[i], 0, kept->kept[i], 0, vw_buffer_size_bytes(kept->kept[i]));
}

void snapshot_record_restore(const struct snapshot *kept, struct vw_batch *batch) {
    for (uint32_t i = 0; i < kept->count; i++)
        vw_batch_copy(batch, kept->kept[i], 0, kept->state[i], 0, vw_buffer_size_bytes(kept->kept[i]));
}
