// What each effect that a scene calls for costs and gains, by short trainings with and without it: `info --measure`.
#ifndef VIEWWORTH_MEASURE_EFFECTS_H
#define VIEWWORTH_MEASURE_EFFECTS_H

#include <stdint.h>

#include "base/interrupt.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_measured_training {
    const char *without; // the effect that is off, of those called for; NULL: none; "(all)": all of them
    double ms_per_step;  // with validation, by paired timing
    double psnr_db;      // validation PSNR, mean over the last steps
    uint64_t param_count, device_bytes;
};

struct vw_measured_effects {
    // With all effects called for, then without each, then without any when more than one is called for.
    struct vw_measured_training trainings[VW_EFFECT_COUNT_MAX + 2];
    uint32_t count; // 0: not measured
    uint32_t steps; // of each training
};

struct vw_measure_effects_params {
    struct vw_gpu *gpu;
    const struct vw_scene *scene;
    const struct vw_config *config; // all trainings have its seed
    const struct vw_effect_verdict *effects;
    uint32_t effect_count;
    struct vw_interrupt interrupt;
};

// VW_ERROR_INPUT when the scene lacks photos to train on or to validate with.
enum vw_status vw_measure_effects(const struct vw_measure_effects_params *params, struct vw_measured_effects *measured);

#endif
