// A session: devices, a scene, and the effects that the scene calls for. Several trainings may share one. Its devices
// are equal in what bits depend on, so that any of them may take a training.
#ifndef VIEWWORTH_RUN_SESSION_H
#define VIEWWORTH_RUN_SESSION_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "train/training_pool.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// Opens a device (as vw_gpu_params.device) and logs which it is. Warns where the preferred one is a CPU although the
// machine has a GPU's files. `timers`: time every pass.
enum vw_status vw_open_gpu(const char *device, bool timers, struct vw_gpu **gpu);
// Finds the first device file of a GPU below /dev, which tests replace: `path` is its path.
bool vw_find_gpu_file(const char *folder, char *path, size_t path_bytes);

// Returns the scene options for run.scene_options_json: canonical JSON of those that differ from their defaults,
// without path, headers_only and gpu; "{}" without any. Owned by the caller.
char *vw_scene_options_to_json(const struct vw_scene_params *options);
// Adds what readers need without the scene: what was left out because its image file is missing (vw_scene.missing), and
// the weights of validation photos other than 1 (vw_ledger_image.weight). `*json` is replaced.
enum vw_status vw_scene_options_note(const struct vw_scene *scene, char **json);
// Reads the options back. `*texts` owns their texts (json_decref).
enum vw_status vw_scene_options_from_json(const char *json, json_t **texts, struct vw_scene_params *options);
// Opens the scene of a recorded run. Relative paths are relative to the folder that the run was started in. `gpu` is
// needed for recipes.
enum vw_status vw_reopen_scene(const char *path, const char *scene_options_json, struct vw_gpu *gpu,
                               struct vw_scene **scene);

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
    struct vw_effect_decision effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count; // 0 until they are decided
};

// Opens the devices alone, unless they are open.
enum vw_status vw_session_open_devices(const struct vw_session_params *params, struct vw_session *session);
// Opens devices and scene, and logs what was found. Does nothing when they are open. VW_ERROR_USAGE names two devices
// that differ. Close the session also after a failure.
enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session);
// Opens the others beside a first device that is open, as vw_session_open() does.
enum vw_status vw_session_open_others(const struct vw_device_choice *devices, bool timers, struct vw_session *session);
// Decides the effects for runs with the config `planned` (detect/decide.h). Does nothing when they are decided.
enum vw_status vw_session_decide_effects(const struct vw_config *planned, struct vw_session *session);
void vw_session_close(struct vw_session *session);

#endif
