// Demands on float arithmetic that GLSL has no words for (Vulkan 1.2, SPV_KHR_float_controls).
#ifndef VIEWWORTH_GPU_FLOAT_CONTROLS_H
#define VIEWWORTH_GPU_FLOAT_CONTROLS_H

#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "viewworth/gpu.h"

// Copies the shader's code, owned by the caller, with the demand that NaN, infinity and the sign of zero are kept:
// without it a driver may take x > limit ? limit : x for a min(), which hides NaN (decision 8). NULL when memory is
// short.
uint32_t *vw_spirv_keep_nan(const struct vw_shader *shader, size_t *code_bytes);

#endif
