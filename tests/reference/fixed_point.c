#include "reference.h"
#include "train/fields/registry.h"

#include <math.h>

void reference_grid_scatter_fixed(const struct vw_specialization *s, const double position[3], const double *d_encoding,
                                  int64_t *quanta) {
    uint32_t features = 2 * s->feature_pairs;
    for (uint32_t level = 0; level < s->levels; level++) {
        struct reference_corner corners[8];
        reference_grid_corners(s, position, level, corners);
        for (uint32_t f = 0; f < features; f++) {
            double clamp = s->gradient_clamp, gradient = fmin(fmax(d_encoding[level * features + f], -clamp), clamp);
            for (int i = 0; i < 8; i++)
                quanta[corners[i].first_feature + f] += llrint(corners[i].weight * gradient / s->gradient_quantum);
        }
    }
}

// Reads one word per feature when wide. A narrow word is first + second * 2^32, both signed.
void reference_unpack_grid(const struct vw_model *model, const uint64_t *words, int64_t *quanta) {
    for (uint64_t i = 0; i < 2 * (uint64_t)vw_volume_of(model)->pair_count; i++) {
        if (model->specialization.wide_gradient) {
            quanta[i] = (int64_t)words[i];
        } else {
            int64_t first = (int32_t)(uint32_t)words[i / 2];
            quanta[i] = i % 2 == 0 ? first : (int64_t)(words[i / 2] - (uint64_t)first) >> 32;
        }
    }
}
