// Opening what the command line names.
#ifndef VIEWWORTH_OPEN_H
#define VIEWWORTH_OPEN_H

#include <stdbool.h>

#include "cli/options.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// The device by number or part of its name, or (NULL) the most preferred fit one; says which. `timers`: time every
// pass.
enum vw_status vw_open_gpu(const char *device, bool timers, struct vw_gpu **gpu);
// The scene at `path` as the scene options say. `gpu` is needed for recipes, unless only headers are read.
enum vw_status vw_open_scene(const struct vw_options *options, const char *path, struct vw_gpu *gpu, bool headers_only,
                             struct vw_scene **scene);

// The scene options for the ledger: canonical JSON of those that were given, "{}" without any; owned by the caller.
char *vw_scene_options_to_json(const struct vw_options *options);
// The scene of a run again, from what its ledger holds. Relative paths are relative to the folder the run was started
// in.
enum vw_status vw_reopen_scene(const char *path, const char *scene_options_json, struct vw_gpu *gpu,
                               struct vw_scene **scene);

#endif
