// The choices of a run that depend on the kind of device. They change times and, where said, bits; results are equally
// good.
#ifndef VIEWWORTH_TRAIN_DEVICE_CHOICES_H
#define VIEWWORTH_TRAIN_DEVICE_CHOICES_H

#include <stdbool.h>

#include "viewworth/gpu.h"

// The way in which scatter_grid adds up the grid's gradient; all ways give the same bits.
enum vw_scatter_form {
    SCATTER_ATOMICS,       // 64-bit
    SCATTER_SPLIT_ATOMICS, // two of 32 bits each
    SCATTER_WALK,          // none: one invocation walks all samples of a level
};

// A choice that the device's limits do not allow falls back to one that they do.
struct vw_device_choices {
    uint32_t chunk_samples;       // samples whose activations are held at a time, at most
    enum vw_scatter_form scatter; // the walk: of chunks that a loop can walk; 64-bit atomics: where there are some
    bool skip_zeros;              // scatter_grid asks before it adds, and leaves 0 out; not in the walk
    bool grid_texel, rows_texel;  // gathered through texel buffers rather than storage buffers
    bool draws_pixels;            // draws pixels of steps on the device, from photos kept there if they fit
    uint32_t slice_parts;         // lanes that share a slice, a power of two up to 64; changes the last bits
    uint32_t ray_lanes;           // lanes that share a ray, a power of two up to 32; changes the last bits
    uint32_t slice_samples; // per partial sum of the weights' gradient: VW_FIELD_GROUP or a part; changes the last bits
};

void vw_device_choose(const struct vw_gpu_info *info, struct vw_device_choices *choices);

#endif
