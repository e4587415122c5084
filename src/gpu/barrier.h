// The one kind of barrier: everything before it is done and visible to everything after it.
#ifndef VIEWWORTH_GPU_BARRIER_H
#define VIEWWORTH_GPU_BARRIER_H

#include <stdbool.h>
#include <volk.h>

struct vw_barrier_params {
    bool indirect;   // workgroup counts are read from buffers before or after it
    bool host_reads; // the host reads mapped buffers after it
};
void vw_barrier_record(VkCommandBuffer commands, struct vw_barrier_params params);

#endif
