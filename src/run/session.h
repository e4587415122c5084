// A session: a device, a scene, and the effects that the scene calls for. Several trainings may share one.
#ifndef VIEWWORTH_RUN_SESSION_H
#define VIEWWORTH_RUN_SESSION_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_session_params {
    struct vw_scene_params scene; // its gpu is ignored
    const char *device;           // index or part of the name; NULL: the preferred device
    bool timers;                  // time every pass
};

// All zero before it is opened.
struct vw_session {
    struct vw_gpu *gpu;
    struct vw_submissions *submissions; // of all trainings of the session: those open at a time take steps together
    struct vw_scene *scene;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count; // 0 until they are decided
};

// Opens device and scene, and logs what was found. Does nothing when they are open. Close the session also after a
// failure.
enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session);
// Decides the effects for runs with the config `planned` (detect/decide.h). Does nothing when they are decided.
enum vw_status vw_session_decide_effects(const struct vw_config *planned, struct vw_session *session);
void vw_session_close(struct vw_session *session);

#endif
