// Commands that the host waits for: one command buffer of the device, outside all batches.
#ifndef VIEWWORTH_GPU_TRANSFER_H
#define VIEWWORTH_GPU_TRANSFER_H

#include <stdbool.h>
#include <volk.h>

#include "gpu/state.h"

enum vw_status vw_transfer_open(struct vw_gpu *gpu);
void vw_transfer_close(struct vw_gpu *gpu);
// Begins a transfer, which the caller records into gpu->transfer. `object` is what messages name.
enum vw_status vw_transfer_begin(struct vw_gpu *gpu, const char *object);
// Submits and waits; ordered after everything submitted before.
enum vw_status vw_transfer_finish(struct vw_gpu *gpu, const char *object);
// Waits for everything submitted before.
enum vw_status vw_transfer_drain(struct vw_gpu *gpu, const char *object);

// The one kind of barrier: everything before it is done and visible to everything after it.
struct vw_barrier_params {
    bool indirect;   // workgroup counts are read from buffers before or after it
    bool host_reads; // the host reads mapped buffers after it
};
void vw_barrier_record(VkCommandBuffer commands, struct vw_barrier_params params);

#endif
