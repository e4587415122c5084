// Baselines: scores that need no valuation, from the photos themselves and their training loss.
#ifndef VIEWWORTH_BASELINES_H
#define VIEWWORTH_BASELINES_H

#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/types.h"

// What baselines are computed from.
struct vw_baseline_input {
    const struct vw_scene *scene;
    const uint32_t *photos; // scene indices
    uint32_t photo_count;
    const struct vw_step_record *records; // of the valued run
    uint64_t record_count;
    uint64_t seed; // of that run
};

// `score` fills in a score per photo, more = better.
struct vw_baseline {
    const char *name, *meaning;
    enum vw_status (*score)(const struct vw_baseline_input *input, double *scores);
    uint32_t trainings; // that its scores take
};

extern const struct vw_baseline vw_baselines[];
extern const uint32_t vw_baseline_count;

#endif
