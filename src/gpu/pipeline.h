// Compiled pipelines. Passes of equal shader share one if the constants that its code refers to are equal, so that
// trainings, at the same time or one after another, compile only where they differ. They live as long as the device.
#ifndef VIEWWORTH_GPU_PIPELINE_H
#define VIEWWORTH_GPU_PIPELINE_H

#include "gpu/spirv.h"
#include "gpu/state.h"

struct vw_pipeline {
    VkDescriptorSetLayout set_layout;
    VkPipelineLayout layout;
    VkPipeline handle;
    // private
    const struct vw_shader *shader;
    uint32_t *constants, constant_count; // owned; 0 where the code does not refer to one
    struct vw_pipeline *next;            // list of the device's pipelines
};

// Returns the pipeline of a shader with these constants, borrowed: an existing one, or a new one. `spirv` is what the
// shader declares.
enum vw_status vw_pipeline_find(struct vw_gpu *gpu, const struct vw_pass_params *params, const struct vw_spirv *spirv,
                                const struct vw_pipeline **pipeline);
void vw_pipelines_destroy(struct vw_gpu *gpu); // when no pass is left

VkDescriptorType vw_descriptor_type(const struct vw_spirv_slot *slot);

// ---- The cache of compiled shaders ---------------------------------------------------------------------------------

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
