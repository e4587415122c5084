// Commands that the host waits for: one command buffer of the device, outside all submissions. All waits have an end.
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

// ---- Waiting, with an end: a device that hangs is reported ----

// Sets gpu->wait_limit_s, by the kind of device or by VIEWWORTH_DEVICE_TIMEOUT_S.
enum vw_status vw_wait_choose_limit(struct vw_gpu *gpu);

// Waits until the fence is signalled. After gpu->wait_limit_s the device counts as hung: this and all later waits fail,
// and from then on nothing that the device may still use is destroyed. `work` is what messages name.
enum vw_status vw_wait_for_fence(struct vw_gpu *gpu, VkFence fence, const char *work);
// Fails where the device hangs: what it is given then must not be touched.
enum vw_status vw_wait_check(const struct vw_gpu *gpu, const char *work);

#endif
