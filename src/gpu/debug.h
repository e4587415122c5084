// The validation layer's complaints, and names for debug tools.
#ifndef VIEWWORTH_GPU_DEBUG_H
#define VIEWWORTH_GPU_DEBUG_H

#include "gpu/state.h"

// Returns VW_OK, or VW_ERROR_DEVICE once validation has complained.
enum vw_status vw_gpu_check_validation(struct vw_gpu *gpu);
void vw_gpu_set_name(struct vw_gpu *gpu, VkObjectType type, uint64_t handle, const char *name);

#endif
