// A session: devices, a scene, and the effects that the scene calls for. Several trainings may share one. Its devices
// are equal in what bits depend on, so that any of them may take a training.
#ifndef VIEWWORTH_RUN_SESSION_H
#define VIEWWORTH_RUN_SESSION_H

#include <stdbool.h>
#include <stdint.h>

#include "train/training_pool.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

enum { VW_SESSION_DEVICES_MAX = VW_POOL_DEVICES_MAX };

// The devices to run on, each by its index or a part of its name.
struct vw_device_choice {
    const char *first;         // NULL: the preferred device
    const char *const *others; // further devices, of equal name and driver
    uint32_t other_count;      // below VW_SESSION_DEVICES_MAX
};

struct vw_session_params {
    struct vw_scene_params scene; // its gpu is ignored
    struct vw_device_choice devices;
    bool timers; // time every pass
};

// All zero before it is opened.
struct vw_session {
    struct vw_training_device devices[VW_SESSION_DEVICES_MAX]; // the first one makes the scene and decides its effects
    uint32_t device_count;
    struct vw_scene *scene;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count; // 0 until they are decided
};

// Opens devices and scene, and logs what was found. Does nothing when they are open. VW_ERROR_USAGE names two devices
// that differ. Close the session also after a failure.
enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session);
// Opens the others beside a first device that is open, as vw_session_open() does.
enum vw_status vw_session_open_others(const struct vw_device_choice *devices, bool timers, struct vw_session *session);
// Decides the effects for runs with the config `planned` (detect/decide.h). Does nothing when they are decided.
enum vw_status vw_session_decide_effects(const struct vw_config *planned, struct vw_session *session);
void vw_session_close(struct vw_session *session);

#endif
