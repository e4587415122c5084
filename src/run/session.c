#include "run/session.h"

#include <string.h>

#include "base/clock.h"
#include "detect/decide.h"
#include "run/devices.h"
#include "viewworth/log.h"

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

static enum vw_status open_devices(const struct vw_session_params *params, struct vw_session *session) {
    enum vw_status status = add_device(params->devices.first, params->timers, session);
    if (!status) status = vw_session_open_others(&params->devices, params->timers, session);
    if (!status && params->timers && !vw_gpu_get_limits(session->devices[0].gpu)->timestamps)
        status = vw_fail(VW_ERROR_USAGE,
                         "--profile: this device has no timestamps; leave it out, or choose another --device");
    return status;
}

enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session) {
    if (session->scene) return VW_OK;
    bool opened = session->device_count > 0;
    enum vw_status status = opened ? VW_OK : open_devices(params, session);
    if (status && !opened) close_devices(session); // so that a second call opens them anew
    struct vw_scene_params scene = params->scene;
    scene.gpu = session->devices[0].gpu;
    if (!status) status = vw_scene_open(&scene, &session->scene);
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
