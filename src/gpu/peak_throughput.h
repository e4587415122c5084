// The amount that vw_gpu_measure_peaks() copies; compute.h has the rest.
#ifndef VIEWWORTH_GPU_PEAK_THROUGHPUT_H
#define VIEWWORTH_GPU_PEAK_THROUGHPUT_H

#include <stdint.h>

#include "viewworth/gpu.h"

// Returns the bytes of each of the two buffers: more than caches contain, within the device's memory and limits.
// `cache_bytes`: the processor's largest cache, for devices that are one.
uint64_t vw_peak_copy_bytes(const struct vw_gpu_info *info, const struct vw_gpu_limits *limits, uint64_t cache_bytes);

#endif
