// Waits for the device, with an end: a device that hangs is reported.
#ifndef VIEWWORTH_GPU_WAIT_H
#define VIEWWORTH_GPU_WAIT_H

#include "gpu/state.h"

// Sets gpu->wait_limit_s, by the kind of device or by VIEWWORTH_DEVICE_TIMEOUT_S.
enum vw_status vw_wait_choose_limit(struct vw_gpu *gpu);

// Waits until the fence is signalled. After gpu->wait_limit_s the device counts as hung: this and all later waits fail,
// and from then on nothing that the device may still use is destroyed. `work` is what messages name.
enum vw_status vw_wait_for_fence(struct vw_gpu *gpu, VkFence fence, const char *work);
// Fails where the device hangs: what it is given then must not be touched.
enum vw_status vw_wait_check(const struct vw_gpu *gpu, const char *work);

#endif
