#include "run/devices.h"

#include <glob.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "scene/splits_file.h"
#include "viewworth/log.h"

bool vw_find_gpu_file(const char *folder, char *path, size_t path_bytes) {
    static const char *const patterns[] = {"nvidia[0-9]*", "dri/renderD*", "kfd", "dxg"};
    bool found = false;
    for (size_t i = 0; i < VW_ARRAY_COUNT(patterns) && !found; i++) {
        char pattern[PATH_MAX];
        glob_t files = {0};
        snprintf(pattern, sizeof pattern, "%s/%s", folder, patterns[i]);
        found = !glob(pattern, 0, NULL, &files);
        if (found) snprintf(path, path_bytes, "%s", files.gl_pathv[0]);
        globfree(&files);
    }
    return found;
}

// Warns where a CPU took over: containers often lack a driver's Vulkan part, and training goes on a hundred times
// slower.
static void warn_of_unused_gpu(void) {
    char file[PATH_MAX];
    if (vw_find_gpu_file("/dev", file, sizeof file))
        vw_log_warning(
            "%s is a GPU's, but Vulkan offers no GPU that can be used: training on the CPU. See viewworth "
            "devices, install the GPU's Vulkan driver (in containers NVIDIA_DRIVER_CAPABILITIES=all), or give "
            "--device cpu",
            file);
}

enum vw_status vw_open_gpu(const char *device, bool timers, struct vw_gpu **gpu) {
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){.device = device, .timers = timers}, gpu);
    if (status) return status;
    const struct vw_gpu_info *info = vw_gpu_get_info(*gpu);
    vw_log_info("device   %u: %s (%s)", info->index, info->name, info->driver);
    if (!device && info->kind == VW_GPU_CPU) warn_of_unused_gpu();
    return VW_OK;
}

char *vw_scene_options_to_json(const struct vw_scene_params *options) {
    json_t *downscale = options->downscale > 1 ? json_integer(options->downscale) : NULL;
    json_t *corrupt = options->corrupt ? json_integer(options->corrupt) : NULL;
    json_t *object =
        json_pack("{s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:o*, s:o*}", "format", options->format, "pool",
                  options->pool, "train", options->train_list, "val", options->val_list, "test", options->test_list,
                  "splits", options->splits, "val-weights", options->val_weights, "providers", options->providers,
                  "downscale", downscale, "corrupt", corrupt);
    char *json = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    if (!json) vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the scene options");
    return json;
}

enum vw_status vw_scene_options_note(const struct vw_scene *scene, char **json) {
    json_t *object = vw_json_load(*json, strlen(*json), 0, NULL);
    if (scene->missing) vw_json_set(&object, "missing", vw_json_string(scene->missing));
    vw_scene_add_weights(scene, &object);
    char *longer = vw_json_to_text(object, JSON_SORT_KEYS | JSON_COMPACT);
    json_decref(object);
    if (!longer) return vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON of the scene options");
    free(*json);
    *json = longer;
    return VW_OK;
}

enum vw_status vw_scene_options_from_json(const char *json, json_t **texts, struct vw_scene_params *options) {
    struct vw_scene_params read = {0};
    json_error_t error;
    json_int_t downscale = 1, corrupt = 0;
    const char *missing = NULL; // for readers of the report
    json_t *weights = NULL;     // for readers of the ledger
    json_t *object = vw_json_load(json, strlen(json), 0, &error);
    enum vw_status status = VW_OK;
    if (!object ||
        json_unpack_ex(object, &error, JSON_STRICT, "{s?s, s?s, s?s, s?s, s?s, s?s, s?s, s?s, s?I, s?I, s?s, s?o}",
                       "format", &read.format, "pool", &read.pool, "train", &read.train_list, "val", &read.val_list,
                       "test", &read.test_list, "splits", &read.splits, "val-weights", &read.val_weights, "providers",
                       &read.providers, "downscale", &downscale, "corrupt", &corrupt, "missing", &missing, "weights",
                       &weights))
        status = vw_fail(VW_ERROR_INPUT, "run.scene_options_json of the ledger: %s: %s", json, error.text);
    if (!status && (downscale < 1 || downscale > UINT32_MAX || corrupt < 0 || corrupt > UINT32_MAX))
        status = vw_fail(VW_ERROR_INPUT, "scene options %s: a count is out of range; make the folder again", json);
    if (status) {
        json_decref(object);
        return status;
    }
    read.downscale = (uint32_t)downscale;
    read.corrupt = (uint32_t)corrupt;
    *texts = object;
    *options = read;
    return VW_OK;
}

enum vw_status vw_reopen_scene(const char *path, const char *scene_options_json, struct vw_gpu *gpu,
                               struct vw_scene **scene) {
    struct vw_scene_params options;
    json_t *texts = NULL;
    enum vw_status status = vw_scene_options_from_json(scene_options_json, &texts, &options);
    if (status) return status;
    options.path = path;
    options.gpu = gpu;
    status = vw_scene_open(&options, scene);
    json_decref(texts);
    return status;
}
