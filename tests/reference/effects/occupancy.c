#include <math.h>
#include <string.h>

#include "base/random.h"
#include "reference/reference.h"

static const double EMPTY_OPACITY = 0.01; // opacity over the longest stratum, a diagonal's

double reference_empty_density(const struct vw_specialization *s) { return EMPTY_OPACITY / (sqrt(3.0) / s->samples); }

uint32_t reference_cell(const double position[3]) {
    uint32_t index = 0;
    for (int axis = 2; axis >= 0; axis--) index = 32 * index + (uint32_t)fmin(floor(32.0 * position[axis]), 31.0);
    return index;
}

double reference_cell_density(const struct vw_specialization *s, const struct reference_params *params, uint32_t cell,
                              vw_uint4 key, double position[3]) {
    struct reference_sample sample = {.direction = {0.0, 0.0, 1.0}};
    uint32_t words[4];
    vw_random_words((uint64_t)key.y << 32 | key.x, VW_RANDOM_OCCUPANCY, (uint64_t)key.w << 32 | key.z, cell, 0, words);
    for (int axis = 0; axis < 3; axis++, cell /= 32)
        sample.position[axis] = (cell % 32 + (words[axis] >> 8) / 16777216.0) / 32.0;
    reference_grid_encode(s, params->grid, sample.position, sample.encoding);
    reference_networks_forward(s, &params->weights, &sample);
    memcpy(position, sample.position, sizeof sample.position);
    return sample.density;
}
