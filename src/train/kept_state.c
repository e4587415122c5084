#include "kept_state.h"

enum vw_status kept_state_create(const struct step_passes *step, struct kept_state *kept) {
    enum vw_status status = VW_OK;
    kept->count = step_training_state(step, kept->state);
    for (uint32_t i = 0; i < kept->count && status == VW_OK; i++)
        status = vw_buffer_create(step->field->gpu,
                                  &(struct vw_buffer_params){.name = "kept_state", .size_bytes = vw_buffer_size_bytes(kept->state[i])},
                                  &kept->kept[i]);
    return status;
}

void kept_state_destroy(struct kept_state *kept) {
    for (uint32_t i = 0; i < kept->count; i++) vw_buffer_destroy(&kept->kept[i]);
}

void kept_state_record_keep(const struct kept_state *kept, struct vw_batch *batch) {
    for (uint32_t i = 0; i < kept->count; i++)
        vw_batch_copy(batch, kept->state[i], 0, kept->kept[i], 0, vw_buffer_size_bytes(kept->kept[i]));
}

void kept_state_record_put_back(const struct kept_state *kept, struct vw_batch *batch) {
    for (uint32_t i = 0; i < kept->count; i++)
        vw_batch_copy(batch, kept->kept[i], 0, kept->state[i], 0, vw_buffer_size_bytes(kept->kept[i]));
}
