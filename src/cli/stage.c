#include "cli/stage.h"

#include "cli/open.h"
#include "viewworth/log.h"

static void say_scene(const struct vw_scene *scene) {
    vw_log_info("scene    %s (%s): %u photos to train on, %u to validate, %u for tests, %u excluded", scene->path, scene->format,
                scene->split_count[VW_SPLIT_TRAIN], scene->split_count[VW_SPLIT_VAL], scene->split_count[VW_SPLIT_TEST],
                scene->split_count[VW_SPLIT_EXCLUDED]);
    for (uint32_t i = 0; i < scene->note_count; i++) vw_log_info("         %s", scene->notes[i]);
}

enum vw_status vw_stage_open(const struct vw_options *options, struct vw_stage *stage) {
    if (stage->scene) return VW_OK;
    enum vw_status status = vw_open_gpu(options->device, options->profile, &stage->gpu);
    if (!status && options->profile && !vw_gpu_get_limits(stage->gpu)->timestamps)
        status = vw_fail(VW_ERROR_USAGE, "--profile: this device has no timestamps; leave it out, or choose another --device");
    if (!status) status = vw_open_scene(options, options->operand, stage->gpu, false, &stage->scene);
    if (!status) say_scene(stage->scene);
    return status;
}

enum vw_status vw_stage_decide_effects(const struct vw_options *options, struct vw_stage *stage) {
    if (stage->effect_count) return VW_OK;
    return vw_effects_decide(stage->gpu, stage->scene, options->config.effects, stage->effects, &stage->effect_count);
}

void vw_stage_close(struct vw_stage *stage) {
    vw_scene_close(&stage->scene);
    (void)vw_gpu_close(&stage->gpu); // reports only what validation layers said, which are off here
}
