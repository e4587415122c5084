// The shaders embedded at build time (defined in a file that CMake makes from shaders/list.cmake).
#ifndef VIEWWORTH_GPU_SHADERS_H
#define VIEWWORTH_GPU_SHADERS_H

#include "viewworth/gpu.h"

// All of them, for hashing; each is also there by name, as vw_shader_<stem>[_<variant>] (embedded_shaders.h, made by
// CMake).
extern const struct vw_shader *const vw_shaders[];
extern const uint32_t vw_shader_count;

#include "embedded_shaders.h"
#include "gpu/compute.h"

#endif
