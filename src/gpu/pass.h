// The inside of a pass.
#ifndef VIEWWORTH_GPU_PASS_H
#define VIEWWORTH_GPU_PASS_H

#include "gpu/pipeline.h"
#include "gpu/state.h"

struct vw_pass_slot {
    struct vw_buffer *buffer;
    uint32_t range;    // range in the buffer
    bool writes;       // else it only reads
    VkBufferView view; // view of a texel buffer
};

struct vw_pass {
    struct vw_gpu *gpu;
    const char *name, *role;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    const struct vw_pipeline *pipeline; // borrowed; maybe of other passes, too
    uint32_t push_bytes;
    uint32_t workgroup_invocations;
    struct vw_buffer *unused; // replaces bindings without a buffer; owned
    struct vw_pass_slot *slots;
    uint32_t slot_count;
};

#endif
