#include "run/session.h"

#include <glob.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "detect/decide.h"
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
        json_pack("{s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:s*, s:o*, s:o*}", "format", options->format,
                  "pool", options->pool, "train", options->train_list, "val", options->val_list, "test",
                  options->test_list, "splits", options->splits, "val-weights", options->val_weights, "providers",
                  options->providers, "masks", options->masks, "downscale", downscale, "corrupt", corrupt);
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
        json_unpack_ex(object, &error, JSON_STRICT, "{s?s, s?s, s?s, s?s, s?s, s?s, s?s, s?s, s?s, s?I, s?I, s?s, s?o}",
                       "format", &read.format, "pool", &read.pool, "train", &read.train_list, "val", &read.val_list,
                       "test", &read.test_list, "splits", &read.splits, "val-weights", &read.val_weights, "providers",
                       &read.providers, "masks", &read.masks, "downscale", &downscale, "corrupt", &corrupt, "missing",
                       &missing, "weights", &weights))
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

static void log_scene(const struct vw_scene *scene) {
    vw_log_info("scene    %s (%s): %u photos to train on, %u to validate, %u for tests, %u excluded", scene->path,
                scene->format, scene->split_count[VW_SPLIT_TRAIN], scene->split_count[VW_SPLIT_VAL],
                scene->split_count[VW_SPLIT_TEST], scene->split_count[VW_SPLIT_EXCLUDED]);
    for (uint32_t i = 0; i < scene->note_count; i++)
        if (scene->notes[i] != scene->missing) vw_log_info("         %s", scene->notes[i]);
    if (scene->missing) vw_log_warning("%s: %s", scene->path, scene->missing);
}

// Compares model and driver, which a run's identity covers: the same training differs on devices that differ in them.
static enum vw_status check_equal(const struct vw_gpu *first, const struct vw_gpu *other) {
    const struct vw_gpu_info *a = vw_gpu_get_info(first), *b = vw_gpu_get_info(other);
    if (!strcmp(a->name, b->name) && !strcmp(a->driver, b->driver)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--devices: %u %.100s (%.100s) and %u %.100s (%.100s) differ, and so may their bits; name equal "
                   "devices, or spread valuations over unequal ones by viewworth batch",
                   a->index, a->name, a->driver, b->index, b->name, b->driver);
}

static enum vw_status add_device(const char *device, bool timers, struct vw_session *session) {
    struct vw_training_device *added = &session->devices[session->device_count];
    enum vw_status status = vw_open_gpu(device, timers, &added->gpu);
    session->device_count += !status; // from here on it is closed with the session
    if (!status) status = check_equal(session->devices[0].gpu, added->gpu);
    return status ? status : vw_submissions_create(added->gpu, &added->submissions);
}

enum vw_status vw_session_open_others(const struct vw_device_choice *devices, bool timers, struct vw_session *session) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < devices->other_count; i++)
        status = add_device(devices->others[i], timers, session);
    return status;
}

static void close_devices(struct vw_session *session) {
    for (uint32_t i = 0; i < session->device_count; i++) {
        vw_submissions_destroy(&session->devices[i].submissions);
        (void)vw_gpu_close(&session->devices[i].gpu); // reports only what validation layers said, which are off here
    }
    session->device_count = 0;
}

enum vw_status vw_session_open_devices(const struct vw_session_params *params, struct vw_session *session) {
    if (session->device_count > 0) return VW_OK;
    enum vw_status status = add_device(params->devices.first, params->timers, session);
    if (!status) status = vw_session_open_others(&params->devices, params->timers, session);
    if (!status && params->timers && !vw_gpu_get_limits(session->devices[0].gpu)->timestamps)
        status = vw_fail(VW_ERROR_USAGE,
                         "--profile: this device has no timestamps; leave it out, or choose another --device");
    if (status) close_devices(session); // so that a second call opens them anew
    return status;
}

enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session) {
    if (session->scene) return VW_OK;
    enum vw_status status = vw_session_open_devices(params, session);
    struct vw_scene_params scene = params->scene;
    if (status) return status;
    scene.gpu = session->devices[0].gpu;
    status = vw_scene_open(&scene, &session->scene);
    if (!status) log_scene(session->scene);
    return status;
}

enum vw_status vw_session_decide_effects(const struct vw_config *planned, struct vw_session *session) {
    return session->effect_count ? VW_OK
                                 : vw_effects_decide_cached(session->devices[0].gpu, session->scene, planned,
                                                            session->effects, &session->effect_count);
}

void vw_session_close(struct vw_session *session) {
    vw_scene_close(&session->scene);
    close_devices(session);
}
