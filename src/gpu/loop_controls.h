// The choice whether the driver may unroll the loops of the shaders, for compilers that take too long, and how to
// forbid it.
#ifndef VIEWWORTH_GPU_LOOP_CONTROLS_H
#define VIEWWORTH_GPU_LOOP_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

// Reads the environment variable VIEWWORTH_LOOPS: "unrolled", the default, or "kept". It is never decided by a
// measurement, since the two forms may differ in bits.
bool vw_loops_unroll(void);

// Fails if VIEWWORTH_LOOPS has any other value.
enum vw_status vw_loops_check_choice(void);

// Turns the wish to unroll of every loop of the shader into the wish not to.
void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes);

#endif
