// Which effects a scene calls for, by what is measured of it.
#ifndef VIEWWORTH_DETECT_DECIDE_H
#define VIEWWORTH_DETECT_DECIDE_H

#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

// Measures the scene and chooses. Some evidence takes a pilot run on `gpu`, of about a second; without a device (NULL),
// without photos to train on, or where `effects` leaves nothing to the evidence, there is none, and what it would tell
// is NaN. The same scene on the same device gets the same verdicts.
enum vw_status vw_effects_decide(struct vw_gpu *gpu, const struct vw_scene *scene, const char *effects,
                                 struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX], uint32_t *count);

#endif
