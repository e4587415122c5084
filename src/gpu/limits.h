// The limits of a physical device, compared with the floor.
#ifndef VIEWWORTH_GPU_LIMITS_H
#define VIEWWORTH_GPU_LIMITS_H

#include <volk.h>

#include "viewworth/gpu.h"

// A physical device as listed.
struct vw_device_candidate {
    VkPhysicalDevice physical;
    uint32_t queue_family;
    struct vw_gpu_info info;
    struct vw_gpu_limits limits; // as queried
    uint32_t timestamp_bits;
    double timestamp_ns; // per tick
};

// Fills in everything but info.index.
void vw_candidate_query(VkPhysicalDevice physical, struct vw_device_candidate *candidate);

// Returns the index of the queue family to compute on: the first without graphics that has timestamps, otherwise the
// first that computes; -1 without any.
int vw_queue_family_choose(const VkQueueFamilyProperties *families, uint32_t count);
void vw_limits_clamp(struct vw_gpu_limits *limits, const struct vw_gpu_limits *clamp);

#endif
