// Whether a device's driver may unroll the loops of the shaders, and how to tell it not to.
#ifndef VIEWWORTH_GPU_LOOP_CONTROLS_H
#define VIEWWORTH_GPU_LOOP_CONTROLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <volk.h>

#include "viewworth/status.h"

// What VIEWWORTH_LOOPS says, "unrolled" or "kept", else what suits the driver: the compilers of a few take minutes for
// what is unrolled.
bool vw_loops_unroll(VkDriverId driver);

// An error where VIEWWORTH_LOOPS says something else.
enum vw_status vw_loops_check_choice(void);

// Turns the wish to unroll of every loop of the shader into the wish not to.
void vw_spirv_keep_loops(uint32_t *code, size_t code_bytes);

#endif
