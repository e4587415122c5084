#include "reference.h"

#include <math.h>

#include "base/random.h"

double reference_stratum_offset(const struct vw_specialization *s, uint32_t ray, uint32_t sample, vw_uint4 key) {
    if (!s->training) return 0.5;
    uint32_t words[4];
    vw_random_words((uint64_t)key.y << 32 | key.x, VW_RANDOM_JITTER, (uint64_t)key.w << 32 | key.z, ray, sample / 4,
                    words);
    return (words[sample % 4] >> 8) / 16777216.0;
}

// The distance from the camera at a place of all strata, by equal parts of disparity.
static double distance_at(const struct vw_specialization *s, const struct reference_ray *ray, double place) {
    double share = place / s->strata;
    return 1.0 / ((1.0 - share) / ray->near + share / ray->far);
}

double reference_stratum_length(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample) {
    if (!s->effect_unbounded) return ray->stride;
    return distance_at(s, ray, sample + 1.0) - distance_at(s, ray, sample);
}

void reference_sample_position(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample,
                               double offset, double position[3]) {
    if (s->effect_unbounded) {
        double behind = distance_at(s, ray, sample + offset) - ray->near, box[3];
        for (int axis = 0; axis < 3; axis++) box[axis] = ray->origin[axis] + behind * ray->direction[axis];
        reference_contract(box, position);
        return;
    }
    double parameter = ray->near + (sample + offset) * ray->stride;
    for (int axis = 0; axis < 3; axis++)
        position[axis] = fmin(fmax(ray->origin[axis] + parameter * ray->direction[axis], 0.0), 1.0);
}
