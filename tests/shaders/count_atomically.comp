// Adds 1 to a 64-bit counter: asks for two optional features.
#version 460
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

layout(local_size_x = 32) in;
layout(set = 0, binding = 0) buffer Counter { uint64_t counter; };

void main() { atomicAdd(counter, uint64_t(1) << 32); }
