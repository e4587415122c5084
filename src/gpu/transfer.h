// Commands that the host waits for: one command buffer of the device, outside all batches.
#ifndef VIEWWORTH_GPU_TRANSFER_H
#define VIEWWORTH_GPU_TRANSFER_H

#include "gpu/state.h"

enum vw_status vw_transfer_open(struct vw_gpu *gpu);
void vw_transfer_close(struct vw_gpu *gpu);
// Begins a transfer, which the caller records into gpu->transfer. `object` is what messages name.
enum vw_status vw_transfer_begin(struct vw_gpu *gpu, const char *object);
// Submits and waits; ordered after everything submitted before.
enum vw_status vw_transfer_finish(struct vw_gpu *gpu, const char *object);
// Waits for everything submitted before.
enum vw_status vw_transfer_drain(struct vw_gpu *gpu, const char *object);

#endif
