#include "gpu/pipeline.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/memory.h"
#include "base/text_stream.h"
#include "gpu/debug.h"
#include "gpu/shader_controls.h"

// ---- Statistics -----------------------------------------------------------------------------------------------------

static void print_value(FILE *stream, const VkPipelineExecutableStatisticKHR *statistic) {
    const VkPipelineExecutableStatisticValueKHR *value = &statistic->value;
    switch (statistic->format) {
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: fputs(value->b32 ? "yes" : "no", stream); break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: fprintf(stream, "%" PRId64, value->i64); break;
    case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR: fprintf(stream, "%" PRIu64, value->u64); break;
    default: fprintf(stream, "%g", value->f64);
    }
}

char *vw_statistics_format(const VkPipelineExecutableStatisticKHR *statistics, uint32_t count) {
    struct vw_text_stream text = {0};
    FILE *stream = vw_text_stream_open(&text);
    char *line = NULL;
    size_t size_bytes;
    for (uint32_t i = 0; stream && i < count; i++) {
        fprintf(stream, "%s%s ", i ? "; " : "", statistics[i].name);
        print_value(stream, &statistics[i]);
    }
    (void)vw_text_stream_close(&text, "pipeline statistics", &line, &size_bytes);
    return line;
}

static enum vw_status add_line(struct vw_gpu *gpu, const char *name, const char *role, char *line) {
    if (line) vw_text_make_line(line); // names are the driver's
    const char *before = gpu->statistics_text ? gpu->statistics_text : "";
    char *text = line ? vw_format_text("%s%s%s%s: %s\n", before, name, role ? ", " : "", role ? role : "", line) : NULL;
    if (!text) return VW_ERROR_MEMORY;
    free(gpu->statistics_text);
    gpu->statistics_text = text;
    return VW_OK;
}

// Adds a line for the pass of that name and role (or NULL), where statistics were asked for and the driver has some.
// A compute pipeline has one executable.
static enum vw_status collect_statistics(struct vw_gpu *gpu, VkPipeline pipeline, const char *name, const char *role) {
    if (!gpu->has_statistics) return VW_OK;
    const VkPipelineExecutableInfoKHR executable = {.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR,
                                                    .pipeline = pipeline};
    uint32_t count = 0;
    VkResult result = vkGetPipelineExecutableStatisticsKHR(gpu->device, &executable, &count, NULL);
    VkPipelineExecutableStatisticKHR *statistics = vw_allocate(count, sizeof *statistics);
    if (!statistics) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) statistics[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
    if (!result) result = vkGetPipelineExecutableStatisticsKHR(gpu->device, &executable, &count, statistics);
    enum vw_status status = VW_OK;
    if (!result && count) {
        char *line = vw_statistics_format(statistics, count);
        status = add_line(gpu, name, role, line);
        free(line);
    }
    free(statistics);
    return result ? vw_gpu_fail(result, "vkGetPipelineExecutableStatisticsKHR", name) : status;
}

const char *vw_gpu_pipeline_statistics(const struct vw_gpu *gpu) {
    return gpu->statistics_text ? gpu->statistics_text : "";
}

// ---- Creation -------------------------------------------------------------------------------------------------------

VkDescriptorType vw_descriptor_type(const struct vw_spirv_slot *slot) {
    return slot->texel ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

static enum vw_status create_set_layout(const struct vw_gpu *gpu, const struct vw_spirv *spirv,
                                        struct vw_pipeline *pipeline) {
    VkDescriptorSetLayoutBinding bindings[VW_SPIRV_MAX_SLOTS];
    for (uint32_t i = 0; i < spirv->slot_count; i++)
        bindings[i] = (VkDescriptorSetLayoutBinding){.binding = spirv->slots[i].slot,
                                                     .descriptorType = vw_descriptor_type(&spirv->slots[i]),
                                                     .descriptorCount = 1,
                                                     .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                  .bindingCount = spirv->slot_count,
                                                  .pBindings = bindings};
    VkResult result = vkCreateDescriptorSetLayout(gpu->device, &info, NULL, &pipeline->set_layout);
    return result ? vw_gpu_fail(result, "vkCreateDescriptorSetLayout", pipeline->shader->name) : VW_OK;
}

static enum vw_status create_layout(const struct vw_gpu *gpu, const struct vw_spirv *spirv,
                                    struct vw_pipeline *pipeline) {
    const VkDescriptorSetLayout sets[] = {pipeline->set_layout, [VW_PUSH_SET] = gpu->push_layout};
    const VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .setLayoutCount = spirv->push_bytes ? VW_PUSH_SET + 1 : VW_PUSH_SET,
                                             .pSetLayouts = sets};
    VkResult result = vkCreatePipelineLayout(gpu->device, &info, NULL, &pipeline->layout);
    return result ? vw_gpu_fail(result, "vkCreatePipelineLayout", pipeline->shader->name) : VW_OK;
}

static uint32_t *copy_code(const struct vw_shader *shader, size_t *code_bytes) {
    uint32_t *code = vw_allocate(1, shader->code_bytes);
    if (code) memcpy(code, shader->code, *code_bytes = shader->code_bytes);
    return code;
}

// Copies the shader's code, owned by the caller, with the changes that this device's driver needs.
static uint32_t *code_for_device(const struct vw_shader *shader, const struct vw_gpu_limits *limits,
                                 size_t *code_bytes) {
    uint32_t *code = limits->keeps_nan ? vw_spirv_keep_nan(shader, code_bytes) : copy_code(shader, code_bytes);
    if (code && !limits->unrolls_loops) vw_spirv_keep_loops(code, *code_bytes);
    return code;
}

static enum vw_status create_module(const struct vw_gpu *gpu, const struct vw_shader *shader, VkShaderModule *module) {
    size_t code_bytes = 0;
    uint32_t *code = code_for_device(shader, &gpu->chosen.limits, &code_bytes);
    if (!code) return VW_ERROR_MEMORY;
    const VkShaderModuleCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code_bytes, .pCode = code};
    VkResult result = vkCreateShaderModule(gpu->device, &info, NULL, module);
    free(code);
    return result ? vw_gpu_fail(result, "vkCreateShaderModule", shader->name) : VW_OK;
}

static enum vw_status compile(struct vw_gpu *gpu, struct vw_pipeline *pipeline) {
    VkShaderModule module;
    const char *name = pipeline->shader->name;
    uint32_t count = pipeline->constant_count;
    VkSpecializationMapEntry *entries = vw_allocate(count, sizeof *entries);
    enum vw_status status = entries ? create_module(gpu, pipeline->shader, &module) : VW_ERROR_MEMORY;
    if (status) {
        free(entries);
        return status;
    }
    for (uint32_t i = 0; i < count; i++)
        entries[i] = (VkSpecializationMapEntry){.constantID = i, .offset = i * 4, .size = 4};
    const VkSpecializationInfo specialization = {.mapEntryCount = count,
                                                 .pMapEntries = entries,
                                                 .dataSize = count * sizeof(uint32_t),
                                                 .pData = pipeline->constants};
    const VkPipelineCreateFlags statistics = gpu->has_statistics ? VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR : 0;
    const VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                              .flags = statistics,
                                              .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                        .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                        .module = module,
                                                        .pName = "main",
                                                        .pSpecializationInfo = &specialization},
                                              .layout = pipeline->layout};
    double begin_s = vw_now_s();
    VkResult result = vkCreateComputePipelines(gpu->device, gpu->pipeline_cache, 1, &info, NULL, &pipeline->handle);
    gpu->pipeline_s += vw_now_s() - begin_s;
    vkDestroyShaderModule(gpu->device, module, NULL);
    free(entries);
    if (result) return vw_gpu_fail(result, "building the pipeline", name);
    vw_gpu_set_name(gpu, VK_OBJECT_TYPE_PIPELINE, (uint64_t)pipeline->handle, name);
    return VW_OK;
}

static void destroy(struct vw_gpu *gpu, struct vw_pipeline *pipeline) {
    vkDestroyPipeline(gpu->device, pipeline->handle, NULL);
    vkDestroyPipelineLayout(gpu->device, pipeline->layout, NULL);
    vkDestroyDescriptorSetLayout(gpu->device, pipeline->set_layout, NULL);
    free(pipeline->constants);
    free(pipeline);
}

static bool is_used(const struct vw_spirv *spirv, uint32_t constant) {
    return constant < VW_SPIRV_MAX_CONSTANTS && spirv->uses_constant[constant];
}

static enum vw_status create(struct vw_gpu *gpu, const struct vw_pass_params *params, const struct vw_spirv *spirv,
                             struct vw_pipeline **pipeline) {
    struct vw_pipeline *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->shader = params->shader;
    made->constant_count = params->specialization_count;
    made->constants = vw_allocate(made->constant_count, sizeof *made->constants);
    enum vw_status status = made->constants ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < made->constant_count && !status; i++)
        if (is_used(spirv, i)) made->constants[i] = params->specialization[i]; // else 0, for the driver's cache
    if (!status) status = create_set_layout(gpu, spirv, made);
    if (!status) status = create_layout(gpu, spirv, made);
    if (!status) status = compile(gpu, made);
    if (!status) status = collect_statistics(gpu, made->handle, made->shader->name, params->role);
    if (status) destroy(gpu, made);
    else *pipeline = made;
    return status;
}

// ---- Sharing --------------------------------------------------------------------------------------------------------

static bool fits(const struct vw_pipeline *pipeline, const struct vw_pass_params *params,
                 const struct vw_spirv *spirv) {
    if (pipeline->shader != params->shader || pipeline->constant_count != params->specialization_count) return false;
    for (uint32_t i = 0; i < pipeline->constant_count; i++)
        if (is_used(spirv, i) && pipeline->constants[i] != params->specialization[i]) return false;
    return true;
}

enum vw_status vw_pipeline_find(struct vw_gpu *gpu, const struct vw_pass_params *params, const struct vw_spirv *spirv,
                                const struct vw_pipeline **pipeline) {
    struct vw_pipeline *found = gpu->pipelines;
    while (found && !fits(found, params, spirv)) found = found->next;
    if (!found) {
        enum vw_status status = create(gpu, params, spirv, &found);
        if (status) return status;
        found->next = gpu->pipelines;
        gpu->pipelines = found;
    }
    *pipeline = found;
    return VW_OK;
}

void vw_pipelines_destroy(struct vw_gpu *gpu) {
    while (gpu->pipelines) {
        struct vw_pipeline *dying = gpu->pipelines;
        gpu->pipelines = dying->next;
        destroy(gpu, dying);
    }
}

uint32_t vw_gpu_pipeline_count(const struct vw_gpu *gpu) {
    uint32_t count = 0;
    for (const struct vw_pipeline *pipeline = gpu->pipelines; pipeline; pipeline = pipeline->next) count++;
    return count;
}

double vw_gpu_pipeline_s(const struct vw_gpu *gpu) { return gpu->pipeline_s; }
