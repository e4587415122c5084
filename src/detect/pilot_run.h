// A short training, the same for every scene, whose findings are evidence that photos and points alone cannot give.
// Seed, sizes and steps are fixed, only the basic effects may be on (distortion, background, masks: without them it
// would learn something else), and no decision reads a clock.
#ifndef VIEWWORTH_DETECT_PILOT_RUN_H
#define VIEWWORTH_DETECT_PILOT_RUN_H

#include "detect/evidence.h"
#include "viewworth/train.h"

// The run simulates the effects whose verdicts are `on`.
enum vw_status pilot_run(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_effect_verdict *verdicts,
                         uint32_t count, struct pilot_findings *findings);

#endif
