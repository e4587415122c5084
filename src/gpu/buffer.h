// The inside of a buffer.
#ifndef VIEWWORTH_GPU_BUFFER_H
#define VIEWWORTH_GPU_BUFFER_H

#include "gpu/hazard.h"
#include "gpu/state.h"

struct vw_buffer {
    struct vw_gpu *gpu;
    char *name;
    uint64_t size_bytes;
    VkBuffer handle;
    VkDeviceMemory memory;
    void *mapped;            // NULL for VW_BUFFER_DEVICE
    struct vw_ranges ranges; // that passes and copies have used
};

enum vw_status vw_buffer_check_range(const struct vw_buffer *buffer, uint64_t offset_bytes, uint64_t size_bytes);

#endif
