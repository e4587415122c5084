// Devices, and the scene options as the ledger records them.
#ifndef VIEWWORTH_RUN_DEVICES_H
#define VIEWWORTH_RUN_DEVICES_H

#include <jansson.h>
#include <stdbool.h>

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

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

#endif
