#include "train/device_choices.h"

#include <unistd.h>

enum { WALK_PROCESSORS_MAX = 4 }; // with more, so many levels' walks keep too few of them busy

// Measured on lavapipe. Dispatches are long, since cores that slept between short ones wake too late to share them;
// asking for zeros costs twice as much as adding them; a load of a storage buffer is checked component by component.
static const struct vw_device_choices of_cpus = {
    .chunk_samples = 1 << 14,
    .scatter = SCATTER_ATOMICS,
    .grid_texel = true,
    .rows_texel = true,
    .slice_samples = 128,
    .slice_parts = 1,
    .ray_lanes = 1,
};

// Measured on an H200 (src/lab/results/gpu.md): a chunk fills a large one; equal addresses contend, those of padding
// and of empty space above all; loads of storage buffers are as fast as texels, which take the way of textures; fewer
// slices make the serial sum over them shorter, and their parts keep more lanes busy. Large ones waited for the host,
// most of whose time went into drawing pixels. Unmeasured: lanes that share a ray, of which a step has few.
static const struct vw_device_choices of_gpus = {
    .chunk_samples = 1 << 18,
    .scatter = SCATTER_ATOMICS,
    .skip_zeros = true,
    .draws_pixels = true,
    .slice_samples = 256,
    .slice_parts = 8,
    .ray_lanes = 32,
};

void vw_device_choose(const struct vw_gpu_info *info, struct vw_device_choices *choices) {
    *choices = info->kind == VW_GPU_CPU ? of_cpus : of_gpus;
    if (info->kind == VW_GPU_CPU && sysconf(_SC_NPROCESSORS_ONLN) <= WALK_PROCESSORS_MAX)
        choices->scatter = SCATTER_WALK;
}
