#include "run/session.h"

#include "run/open.h"
#include "train/submissions.h"
#include "detect/verdict_cache.h"
#include "viewworth/log.h"

static void log_scene(const struct vw_scene *scene) {
    vw_log_info("scene    %s (%s): %u photos to train on, %u to validate, %u for tests, %u excluded", scene->path,
                scene->format, scene->split_count[VW_SPLIT_TRAIN], scene->split_count[VW_SPLIT_VAL],
                scene->split_count[VW_SPLIT_TEST], scene->split_count[VW_SPLIT_EXCLUDED]);
    for (uint32_t i = 0; i < scene->note_count; i++)
        if (scene->notes[i] != scene->missing) vw_log_info("         %s", scene->notes[i]);
    if (scene->missing) vw_log_warning("%s: %s", scene->path, scene->missing);
}

enum vw_status vw_session_open(const struct vw_session_params *params, struct vw_session *session) {
    if (session->scene) return VW_OK;
    enum vw_status status = session->gpu ? VW_OK : vw_open_gpu(params->device, params->timers, &session->gpu);
    if (!status && params->timers && !vw_gpu_get_limits(session->gpu)->timestamps)
        status = vw_fail(VW_ERROR_USAGE,
                         "--profile: this device has no timestamps; leave it out, or choose another --device");
    if (!status && !session->submissions) status = vw_submissions_create(session->gpu, &session->submissions);
    struct vw_scene_params scene = params->scene;
    scene.gpu = session->gpu;
    if (!status) status = vw_scene_open(&scene, &session->scene);
    if (!status) log_scene(session->scene);
    return status;
}

enum vw_status vw_session_decide_effects(const struct vw_config *planned, struct vw_session *session) {
    if (session->effect_count) return VW_OK;
    return vw_effects_decide_cached(session->gpu, session->scene, planned, session->effects, &session->effect_count);
}

void vw_session_close(struct vw_session *session) {
    vw_scene_close(&session->scene);
    vw_submissions_destroy(&session->submissions);
    (void)vw_gpu_close(&session->gpu); // reports only what validation layers said, which are off here
}
