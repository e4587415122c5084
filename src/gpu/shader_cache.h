// Compiled shaders, kept from run to run.
#ifndef VIEWWORTH_GPU_SHADER_CACHE_H
#define VIEWWORTH_GPU_SHADER_CACHE_H

#include "gpu/state.h"

// Gives each vector width a cache folder; call it before the loader is used. Mesa keeps its compiled CPU code by shader
// and processor, but not by LP_NATIVE_VECTOR_WIDTH, which changes the code. Does nothing unless that is set and
// MESA_SHADER_CACHE_DIR is not.
void vw_shader_cache_separate_widths(void);

// Opens gpu->pipeline_cache from $XDG_CACHE_HOME/viewworth (or ~/.cache/viewworth), by device, driver and vector width.
// A file that is missing or damaged gives an empty cache; so does a system without such a folder.
enum vw_status vw_shader_cache_open(struct vw_gpu *gpu);
// Keeps what was compiled, where that is new. No cache is worth an error: what cannot be written is compiled again.
void vw_shader_cache_close(struct vw_gpu *gpu);

#endif
