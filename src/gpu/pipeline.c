#include "gpu/pipeline.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/cache.h"
#include "base/clock.h"
#include "base/hash.h"
#include "base/memory.h"
#include "gpu/instance.h"
#include "gpu/spirv.h"

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
    const VkComputePipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
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
    vw_instance_name_object(&gpu->instance, gpu->device, VK_OBJECT_TYPE_PIPELINE, (uint64_t)pipeline->handle, name);
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

// ---- The cache of compiled shaders ---------------------------------------------------------------------------------

enum { HASH_BYTES = 32, CACHE_BYTES_MAX = 256 << 20 };

static const char *vector_width(void) {
    const char *width = getenv("LP_NATIVE_VECTOR_WIDTH");
    return width ? width : "";
}

void vw_shader_cache_separate_widths(void) {
    const char *width = vector_width();
    char name[32];
    if (!*width || width[strspn(width, "0123456789")] || strlen(width) > 4 || getenv("MESA_SHADER_CACHE_DIR")) return;
    snprintf(name, sizeof name, "mesa-%s", width);
    char *path = vw_cache_folder(name);
    if (path) setenv("MESA_SHADER_CACHE_DIR", path, 1);
    free(path);
}

// Names the file for this device, driver and vector width.
static void name_file(struct vw_gpu *gpu) {
    VkPhysicalDeviceProperties device;
    struct vw_hasher hasher;
    uint8_t hash[HASH_BYTES];
    char hex[VW_HASH_HEX_BYTES];
    vkGetPhysicalDeviceProperties(gpu->chosen.physical, &device);
    vw_hasher_begin(&hasher);
    vw_hasher_add_integer(&hasher, device.vendorID);
    vw_hasher_add_integer(&hasher, device.deviceID);
    vw_hasher_add_integer(&hasher, device.driverVersion);
    vw_hasher_add_bytes(&hasher, device.pipelineCacheUUID, sizeof device.pipelineCacheUUID);
    vw_hasher_add_text(&hasher, vector_width());
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, hex);
    snprintf(gpu->pipeline_cache_name, sizeof gpu->pipeline_cache_name, "pipelines-%.16s.bin", hex);
}

// Reads a SHA-256 and the data that it covers: drivers do not check the data that they load.
static void read_file(struct vw_gpu *gpu, void **file, size_t *data_bytes) {
    size_t size_bytes = 0;
    *data_bytes = 0;
    if (!vw_cache_read(gpu->pipeline_cache_name, CACHE_BYTES_MAX, file, &size_bytes) || size_bytes < HASH_BYTES) return;
    uint8_t hash[HASH_BYTES];
    vw_sha256((uint8_t *)*file + HASH_BYTES, size_bytes - HASH_BYTES, hash);
    if (memcmp(*file, hash, HASH_BYTES)) return;
    memcpy(gpu->pipeline_cache_hash, hash, HASH_BYTES);
    *data_bytes = size_bytes - HASH_BYTES;
}

enum vw_status vw_shader_cache_open(struct vw_gpu *gpu) {
    void *file = NULL;
    size_t data_bytes;
    name_file(gpu);
    read_file(gpu, &file, &data_bytes);
    VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                      .initialDataSize = data_bytes,
                                      .pInitialData = data_bytes ? (uint8_t *)file + HASH_BYTES : NULL};
    VkResult result = vkCreatePipelineCache(gpu->device, &info, NULL, &gpu->pipeline_cache);
    if (result && data_bytes) { // a driver may refuse what it once gave
        info.initialDataSize = 0;
        result = vkCreatePipelineCache(gpu->device, &info, NULL, &gpu->pipeline_cache);
    }
    free(file);
    return result ? vw_gpu_fail(result, "vkCreatePipelineCache", gpu->chosen.info.name) : VW_OK;
}

// Returns the file's bytes; NULL when there is nothing new.
static uint8_t *make_file(struct vw_gpu *gpu, size_t *size_bytes) {
    size_t data_bytes = 0;
    if (vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &data_bytes, NULL) || !data_bytes ||
        data_bytes > CACHE_BYTES_MAX)
        return NULL;
    uint8_t *file = vw_allocate(HASH_BYTES + data_bytes, 1);
    if (file && !vkGetPipelineCacheData(gpu->device, gpu->pipeline_cache, &data_bytes, file + HASH_BYTES)) {
        vw_sha256(file + HASH_BYTES, data_bytes, file);
        *size_bytes = HASH_BYTES + data_bytes;
        if (memcmp(file, gpu->pipeline_cache_hash, HASH_BYTES)) return file;
    }
    free(file);
    return NULL;
}

void vw_shader_cache_close(struct vw_gpu *gpu) {
    struct vw_saved_error why = vw_error_save(); // the device may be closing because something failed
    size_t size_bytes = 0;
    uint8_t *file = gpu->pipeline_cache ? make_file(gpu, &size_bytes) : NULL;
    if (file) vw_cache_write(gpu->pipeline_cache_name, file, size_bytes);
    vkDestroyPipelineCache(gpu->device, gpu->pipeline_cache, NULL);
    free(file);
    vw_error_restore(&why);
}
