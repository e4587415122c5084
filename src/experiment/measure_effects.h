// `info --measure`: what each effect that a scene calls for costs and buys, by short trainings with and without it.
#ifndef VIEWWORTH_MEASURE_EFFECTS_H
#define VIEWWORTH_MEASURE_EFFECTS_H

#include <jansson.h>

#include "cli/options.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"
#include "viewworth/train.h"

struct vw_measured_training {
    const char *without; // the effect left out of those called for; NULL for all of them
    double ms_per_step;  // with validation: median over rounds in which the trainings take turns
    double psnr_db;      // validation PSNR, mean over the last steps
    uint64_t param_count, device_bytes;
};

struct vw_measurement {
    struct vw_measured_training
        trainings[VW_EFFECT_COUNT_MAX + 2]; // all, then without each, then none where more than one is called for
    uint32_t count;                         // 0: not measured
    uint32_t steps;                         // of each
};

// All trainings have the options' seed and the same steps. VW_ERROR_INPUT where the scene cannot be trained and
// validated on.
enum vw_status vw_measure_effects(const struct vw_options *options, const struct vw_scene *scene, struct vw_gpu *gpu,
                                  const struct vw_effect_verdict *effects, uint32_t effect_count,
                                  struct vw_measurement *measurement);
void vw_measurement_print(const struct vw_measurement *measurement); // nothing when not measured
// [{effect, ms_per_step_on, ms_per_step_off, params, bytes, psnr_gained_db}]; NULL when memory is short.
json_t *vw_measurement_to_json(const struct vw_measurement *measurement);

#endif
