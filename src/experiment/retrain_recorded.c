// Retraining the photos of a recorded run: what retrain.h has of it.
#include "experiment/retrain.h"

#include <string.h>

enum vw_status vw_session_open_recorded(struct vw_recorded_run *recorded, const struct vw_device_choice *devices,
                                        struct vw_session *session) {
    enum vw_status status = vw_recorded_open_scene(recorded, devices->first ? devices->first : recorded->row.device);
    if (!status) status = vw_recorded_check_images(recorded);
    if (status) return status;
    session->devices[0].gpu = recorded->gpu;
    session->device_count = 1;
    session->scene = recorded->scene;
    session->effect_count = recorded->effect_count;
    memcpy(session->effects, recorded->effects, sizeof session->effects);
    status = vw_submissions_create(recorded->gpu, &session->devices[0].submissions);
    return status ? status : vw_session_open_others(devices, false, session);
}

void vw_session_close_recorded(struct vw_session *session) {
    session->scene = NULL;
    session->devices[0].gpu = NULL;
    vw_session_close(session);
}

struct vw_config vw_config_of_retrainings(const struct vw_recorded_run *recorded, const struct vw_value_input *steps) {
    struct vw_config config = recorded->config;
    // A budget or --until-stable may have ended the run before all of its epochs.
    uint32_t last = steps->record_count ? steps->records[steps->record_count - 1].epoch : 0;
    if (last < config.epochs) config.epochs = last + 1;
    config.vary = VW_VARY_ALL; // seeds of a run of `reproduce --vary` change less
    config.base_seed = 0;
    return config;
}

uint64_t vw_first_seed_after(uint64_t own) { return own < (uint64_t)INT64_MAX - UINT32_MAX ? own + 1 : 0; }
