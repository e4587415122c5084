// Demands on compilers that GLSL cannot express: float arithmetic (Vulkan 1.2, SPV_KHR_float_controls), and loops that
// stay loops, for compilers that take too long to unroll them.
#ifndef VIEWWORTH_GPU_SHADER_CONTROLS_H
#define VIEWWORTH_GPU_SHADER_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"

// Copies the shader's code, owned by the caller, with the demand that NaN, infinity and the sign of zero are kept:
// without it a driver may take x > limit ? limit : x for a min(), which hides NaN (decision 8). NULL when memory is
// short.
uint32_t *vw_spirv_keep_nan(const struct vw_shader *shader, size_t *code_bytes);

// Reads the environment variable VIEWWORTH_LOOPS: "unrolled", the default, or "kept". It is never decided by a
// measurement, since the two forms may differ in bits.
bool vw_loops_unroll(void);

// Fails if VIEWWORTH_LOOPS has any other value.
enum vw_status vw_loops_check_choice(void);

// Turns the wish to unroll of every loop of the shader into the wish not to.
void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes);

#endif
