#include "reference.h"

#include <math.h>

#include "viewworth/random.h"

double reference_stratum_offset(const struct vw_specialization *s, uint32_t ray, uint32_t sample, uint64_t step) {
    if (!s->training) return 0.5;
    uint32_t words[4];
    vw_random_words((uint64_t)s->seed_high << 32 | s->seed_low, VW_RANDOM_JITTER, step, ray, sample / 4, words);
    return (words[sample % 4] >> 8) / 16777216.0;
}

void reference_sample_position(const struct reference_ray *ray, uint32_t sample, double offset, double position[3]) {
    double parameter = ray->near + (sample + offset) * ray->stride;
    for (int axis = 0; axis < 3; axis++) position[axis] = fmin(fmax(ray->origin[axis] + parameter * ray->direction[axis], 0.0), 1.0);
}
