// Contents of a scene and the effects that it calls for, as text and JSON on stdout.
#ifndef VIEWWORTH_CLI_OUTPUT_SCENE_INFO_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_SCENE_INFO_OUTPUT_H

#include <stdbool.h>

#include "run/plan/estimate.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

struct vw_scene_info {
    const struct vw_scene *scene;
    struct vw_effect_verdict effects[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    struct vw_estimate estimate;
};

enum vw_status vw_scene_info_print(const struct vw_scene_info *info, bool json);

#endif
