// The beginning of every training pass: extensions and the shared interface.
#ifndef COMMON_GLSL
#define COMMON_GLSL
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "interface.h"
#include "invocation.glsl"

#define BUFFER(slot) layout(set = 0, binding = slot, scalar)
#define PUSH layout(set = 1, binding = 0, scalar) // VW_PUSH_SET of src/gpu/spirv.h

// Tests the bits: a driver may assume that floats are never NaN and fold isnan away.
bool finite(float x) { return (floatBitsToUint(x) & 0x7F800000u) != 0x7F800000u; }
bool finite(vec4 v) { return finite(v.x) && finite(v.y) && finite(v.z) && finite(v.w); }

#endif
