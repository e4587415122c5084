// The status of a VkResult, with a one-line message.
#ifndef VIEWWORTH_GPU_RESULT_H
#define VIEWWORTH_GPU_RESULT_H

#include "viewworth/status.h"

// Records that Vulkan `call` on `object` ("buffer rays", "pass forward_field", ...) ended with the VkResult `result`,
// and what to do.
enum vw_status vw_gpu_fail(int result, const char *call, const char *object);

#endif
