// A short training that is the same for every scene: what it finds is evidence where nothing else tells. Fixed seed,
// sizes and steps, no effects but those without which it would learn something else (distortion, background, masks),
// and no clock in any decision.
#ifndef VIEWWORTH_DETECT_PILOT_RUN_H
#define VIEWWORTH_DETECT_PILOT_RUN_H

#include "detect/evidence.h"
#include "viewworth/train.h"

// The verdicts' `on` are what the run simulates.
enum vw_status pilot_run(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_effect_verdict *verdicts,
                         uint32_t count, struct pilot_findings *findings);

#endif
