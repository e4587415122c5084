// What trainings take place on: a device and a scene, and what the scene calls for. Several trainings may share one.
#ifndef VIEWWORTH_STAGE_H
#define VIEWWORTH_STAGE_H

#include <stdint.h>

#include "cli/options.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// All zero before it is opened.
struct vw_session {
    struct vw_gpu *gpu;
    struct vw_scene *scene;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count; // 0 until they are decided
};

// Opens device and scene as the options say, and says what was found; does nothing when they are open. Close it also
// after a failure.
enum vw_status vw_session_open(const struct vw_options *options, struct vw_session *session);
// Decides on effects by what is found now, and only once, however many trainings ask.
enum vw_status vw_session_decide_effects(const struct vw_options *options, struct vw_session *session);
void vw_session_close(struct vw_session *session);

#endif
