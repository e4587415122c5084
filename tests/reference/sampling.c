#include "reference.h"

#include <math.h>

#include "base/random.h"

static double offset_of(const struct vw_specialization *s, enum vw_random_purpose purpose, uint32_t ray, uint32_t index,
                        vw_uint4 key) {
    if (!s->training) return 0.5;
    uint32_t words[4];
    vw_random_words((uint64_t)key.y << 32 | key.x, purpose, (uint64_t)key.w << 32 | key.z, ray, index / 4, words);
    return (words[index % 4] >> 8) / 16777216.0;
}

double reference_stratum_offset(const struct vw_specialization *s, uint32_t ray, uint32_t sample, vw_uint4 key) {
    return offset_of(s, VW_RANDOM_JITTER, ray, sample, key);
}

// Returns the distance from the camera at a place in strata, which are equal parts of disparity.
static double distance_at(const struct vw_specialization *s, const struct reference_ray *ray, double place) {
    double share = place / s->strata;
    return 1.0 / ((1.0 - share) / ray->near + share / ray->far);
}

// Returns the length between two places on a ray, in box edges.
static double length_between(const struct vw_specialization *s, const struct reference_ray *ray, double from,
                             double to) {
    if (!s->effect_unbounded) return (to - from) * ray->stride;
    return distance_at(s, ray, to) - distance_at(s, ray, from);
}

double reference_stratum_length(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample) {
    return length_between(s, ray, sample, sample + 1.0);
}

double reference_listed_length(const struct vw_specialization *s, const struct reference_ray *ray, const double *places,
                               uint32_t sample) {
    double from = sample ? (places[sample - 1] + places[sample]) / 2.0 : 0.0,
           to = sample + 1 < s->samples ? (places[sample] + places[sample + 1]) / 2.0 : s->strata;
    return length_between(s, ray, from, to);
}

void reference_position_at(const struct vw_specialization *s, const struct reference_ray *ray, double place,
                           double position[3]) {
    if (s->effect_unbounded) {
        double behind = distance_at(s, ray, place) - ray->near, box[3];
        for (int axis = 0; axis < 3; axis++) box[axis] = ray->origin[axis] + behind * ray->direction[axis];
        reference_contract(box, position);
        return;
    }
    double parameter = ray->near + place * ray->stride;
    for (int axis = 0; axis < 3; axis++)
        position[axis] = fmin(fmax(ray->origin[axis] + parameter * ray->direction[axis], 0.0), 1.0);
}

void reference_sample_position(const struct vw_specialization *s, const struct reference_ray *ray, uint32_t sample,
                               double offset, double position[3]) {
    reference_position_at(s, ray, sample + offset, position);
}

// Computes the weights of the strata from the optical thickness of each, with the floor that NeRF's code adds. Returns
// their sum.
static double weigh(const struct vw_specialization *s, const double *taus, double *weights) {
    double before = 0.0, total = 0.0;
    for (uint32_t i = 0; i < s->strata; i++) {
        weights[i] = exp(-before) * -expm1(-taus[i]) + 1e-5;
        before += taus[i];
        total += weights[i];
    }
    for (uint32_t i = 0; i < s->strata && !isfinite(total); i++) weights[i] = 1.0; // nothing is known
    return isfinite(total) ? total : s->strata;
}

// Returns the place up to which the weights add up to `target`.
static double inverse_distribution(const double *weights, uint32_t strata, double target) {
    uint32_t i = 0;
    double before = 0.0;
    while (i + 1 < strata && before + weights[i] <= target) before += weights[i++];
    return i + fmin(fmax((target - before) / weights[i], 0.0), 1.0);
}

void reference_place_samples(const struct vw_specialization *s, uint32_t ray, const double *taus, vw_uint4 key,
                             double *weights, double *places) {
    double total = weigh(s, taus, weights);
    for (uint32_t i = 0; i < s->samples; i++) {
        double offset = offset_of(s, VW_RANDOM_IMPORTANCE, ray, i, key);
        places[i] = inverse_distribution(weights, s->strata, (i + offset) / s->samples * total);
    }
}
