// The memory and time that a run of a scene needs, estimated from its first steps.
#ifndef VIEWWORTH_RUN_PLAN_ESTIMATE_H
#define VIEWWORTH_RUN_PLAN_ESTIMATE_H

#include <stdint.h>

#include "train/trainer.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

struct vw_estimate {
    char missing[200]; // why there is no estimate; "" when there is one, and only host_bytes is valid otherwise
    char device[256];  // that the steps were measured on
    uint64_t param_count, device_bytes;
    uint64_t host_bytes; // for photos, masks, points and tracks
    uint64_t steps;      // steps of a run with the config
    uint64_t measured_steps;
    double seconds_per_step; // mean over measured_steps, validation included
};

// Estimates memory, which is what a trainer allocates, and time, extrapolated from a fraction of a second of steps.
// `estimate` is zero before, except for `missing`, which says why there is no device when `gpu` is NULL. Without a
// device, or when the scene cannot be validated, the estimate stays empty; that is not a failure.
void vw_estimate_run(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                     const struct vw_effect_verdict *effects, uint32_t effect_count, struct vw_estimate *estimate);
// Creates a trainer, takes steps for a fraction of a second after the first submission, and fills in params,
// device_bytes, steps, measured_steps and seconds_per_step (NaN when the first submission took all steps).
enum vw_status vw_estimate_take_steps(const struct vw_trainer_params *params, struct vw_estimate *estimate);

#endif
