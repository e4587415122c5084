// Whether the driver may unroll the loops of the shaders, and how to tell it not to: for compilers that take too long.
#ifndef VIEWWORTH_GPU_LOOP_CONTROLS_H
#define VIEWWORTH_GPU_LOOP_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"

// What the environment variable VIEWWORTH_LOOPS says: "unrolled", which it is by default, or "kept". Never measured,
// since the two forms may differ in bits.
bool vw_loops_unroll(void);

// An error where VIEWWORTH_LOOPS says something else.
enum vw_status vw_loops_check_choice(void);

// Turns the wish to unroll of every loop of the shader into the wish not to.
void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes);

#endif
