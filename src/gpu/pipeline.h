// Compiled pipelines. Passes of equal shader and constants share one, so that several trainings of equal config compile
// their shaders once.
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
    uint32_t *constants, constant_count; // owned
    uint32_t pass_count;                 // that use it
    struct vw_pipeline *next;            // of the device's
};

// The pipeline of a shader with these constants: one that another pass uses, or a new one. `spirv` is what the shader
// declares. Release it after use, before the device is closed.
enum vw_status vw_pipeline_take(struct vw_gpu *gpu, const struct vw_pass_params *params, const struct vw_spirv *spirv,
                                struct vw_pipeline **pipeline);
void vw_pipeline_release(struct vw_gpu *gpu, struct vw_pipeline **pipeline);
// Pipelines in use.
uint32_t vw_gpu_pipeline_count(const struct vw_gpu *gpu);

VkDescriptorType vw_descriptor_type(const struct vw_spirv_slot *slot);

#endif
