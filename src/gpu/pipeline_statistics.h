// Statistics of the driver on the pipelines it made: registers, spills, instructions
// (VK_KHR_pipeline_executable_properties).
#ifndef VIEWWORTH_GPU_PIPELINE_STATISTICS_H
#define VIEWWORTH_GPU_PIPELINE_STATISTICS_H

#include "gpu/state.h"

// Returns "name value; name value", owned by the caller; NULL when memory is short.
char *vw_statistics_format(const VkPipelineExecutableStatisticKHR *statistics, uint32_t count);

// Adds a line for the pass of that name and role (or NULL) to what vw_gpu_pipeline_statistics() gives, where statistics
// were asked for and the driver has some.
enum vw_status vw_statistics_collect(struct vw_gpu *gpu, VkPipeline pipeline, const char *name, const char *role);

#endif
