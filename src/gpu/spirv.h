// Reads from a shader's SPIR-V what a pass has to know about it.
#ifndef VIEWWORTH_GPU_SPIRV_H
#define VIEWWORTH_GPU_SPIRV_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"

enum { VW_SPIRV_MAX_SLOTS = 64, VW_SPIRV_MAX_CONSTANTS = 128 };
enum {
    VW_PUSH_SET = 1,        // the descriptor set whose binding 0 is a dispatch's push block, a uniform buffer
    VW_PUSH_BYTES_MAX = 128 // the most of it; so many are bound for every dispatch
};

// One binding of descriptor set 0. Variables that share a binding are one slot.
struct vw_spirv_slot {
    uint32_t slot;
    bool texel;       // a uniform texel buffer, else a storage buffer
    bool texel_float; // samplerBuffer rather than usamplerBuffer
    bool writes;      // not declared readonly
};

struct vw_spirv {
    struct vw_spirv_slot slots[VW_SPIRV_MAX_SLOTS];
    uint32_t slot_count;
    uint32_t push_bytes; // size of its push block, as sizeof the same struct in C: rounded up to its widest scalar
    uint32_t workgroup_size[3]; // after specialization
    uint64_t shared_bytes; // after specialization; a length that is not a plain expression of constants counts as 0
    bool needs_int64;
    bool needs_int64_atomics;
    bool uses_constant[VW_SPIRV_MAX_CONSTANTS]; // by constant_id: whether the code refers to it
};

// Reads a shader's declarations. `specialization[i]` replaces the value of constant_id i, for i below
// `specialization_count`.
enum vw_status vw_spirv_read(const struct vw_shader *shader, const uint32_t *specialization,
                             uint32_t specialization_count, struct vw_spirv *spirv);

// ---- Demands on compilers ------------------------------------------------------------------------------------------

// Demands that GLSL cannot express: float arithmetic (Vulkan 1.2, SPV_KHR_float_controls), and loops that
// stay loops, for compilers that take too long to unroll them.

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
