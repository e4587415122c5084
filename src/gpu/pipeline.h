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

// Returns the statistics of the driver on a pipeline it made (registers, spills, instructions:
// VK_KHR_pipeline_executable_properties) as "name value; name value", owned by the caller; NULL when memory is short.
char *vw_statistics_format(const VkPipelineExecutableStatisticKHR *statistics, uint32_t count);

#endif
