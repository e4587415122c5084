#include "reference.h"

#include <math.h>

static uint64_t entry_index(const struct vw_specialization *s, uint32_t level, const uint32_t lattice[3]) {
    uint64_t side = s->resolution[level] + 1;
    if (level < s->dense_levels) return lattice[0] + side * (lattice[1] + side * lattice[2]);
    uint32_t hash = lattice[0] ^ lattice[1] * UINT32_C(2654435761) ^ lattice[2] * UINT32_C(805459861);
    return hash % ((uint64_t)s->table_mask + 1);
}

void reference_grid_corners(const struct vw_specialization *s, const double position[3], uint32_t level,
                            struct reference_corner corners[8]) {
    uint32_t cell[3];
    double fraction[3];
    for (int axis = 0; axis < 3; axis++) {
        // Rounded as the device rounds it, so that both look at the same cell.
        double scaled = (float)position[axis] * (float)s->resolution[level];
        cell[axis] = (uint32_t)fmin(floor(scaled), s->resolution[level] - 1.0);
        fraction[axis] = scaled - cell[axis];
    }
    for (uint32_t i = 0; i < 8; i++) {
        const uint32_t upper[3] = {i & 1, i >> 1 & 1, i >> 2 & 1};
        uint32_t lattice[3];
        corners[i].weight = 1.0;
        for (int axis = 0; axis < 3; axis++) {
            lattice[axis] = cell[axis] + upper[axis];
            corners[i].weight *= upper[axis] ? fraction[axis] : 1.0 - fraction[axis];
        }
        corners[i].first_feature =
            2 * ((uint64_t)s->first_pair[level] + entry_index(s, level, lattice) * s->feature_pairs);
    }
}

void reference_grid_encode(const struct vw_specialization *s, const double *grid, const double position[3],
                           double *encoding) {
    uint32_t features = 2 * s->feature_pairs;
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        reference_grid_corners(s, position, level, corners);
        for (uint32_t f = 0; f < features; f++) {
            double sum = 0.0;
            for (int i = 0; i < 8; i++) sum += corners[i].weight * grid[corners[i].first_feature + f];
            encoding[level * features + f] = sum;
        }
    }
}

void reference_grid_scatter(const struct vw_specialization *s, const double position[3], const double *d_encoding,
                            double *d_grid) {
    uint32_t features = 2 * s->feature_pairs;
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        reference_grid_corners(s, position, level, corners);
        for (uint32_t f = 0; f < features; f++)
            for (int i = 0; i < 8; i++)
                d_grid[corners[i].first_feature + f] += corners[i].weight * d_encoding[level * features + f];
    }
}
