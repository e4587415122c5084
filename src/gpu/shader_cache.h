// Compiled shaders, kept from run to run.
#ifndef VIEWWORTH_GPU_SHADER_CACHE_H
#define VIEWWORTH_GPU_SHADER_CACHE_H

#include "gpu/state.h"

// Before the loader is asked for anything. Mesa keeps what it compiles for CPUs by shader and processor, but not by
// LP_NATIVE_VECTOR_WIDTH, which changes the code: where that is set, and MESA_SHADER_CACHE_DIR is not, each width gets
// a folder of its own.
void vw_shader_cache_separate_widths(void);

// gpu->pipeline_cache from $XDG_CACHE_HOME/viewworth (or ~/.cache/viewworth), by device, driver and vector width. A
// file that is missing or damaged gives an empty cache; so does a system without such a folder.
enum vw_status vw_shader_cache_open(struct vw_gpu *gpu);
// Keeps what was compiled, where that is new. No cache is worth an error: what cannot be written is compiled again.
void vw_shader_cache_close(struct vw_gpu *gpu);

#endif
