// What one would rank photos by without valuing them: cheap measures of the photos themselves, and of their training
// loss.
#ifndef VIEWWORTH_CONTROLS_H
#define VIEWWORTH_CONTROLS_H

#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// What a baseline looks at.
struct vw_baseline_input {
    const struct vw_scene *scene;
    const uint32_t *photos; // scene indices
    uint32_t photo_count;
    const struct vw_step_record *records; // of the valued run
    uint64_t record_count;
    uint64_t seed; // of that run
};

// Fills a score per photo, positive = said to help.
struct vw_baseline {
    const char *name, *meaning;
    enum vw_status (*score)(const struct vw_baseline_input *input, double *scores);
    uint32_t trainings; // that it takes
};

extern const struct vw_baseline vw_baselines[];
extern const uint32_t vw_baseline_count;

#endif
