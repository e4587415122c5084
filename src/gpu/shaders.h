// The shaders embedded at build time (defined in a file that CMake makes from shaders/list.cmake).
#ifndef VIEWWORTH_GPU_SHADERS_H
#define VIEWWORTH_GPU_SHADERS_H

#include "viewworth/gpu.h"

extern const struct vw_shader *const vw_shaders[];
extern const uint32_t vw_shader_count;

#endif
