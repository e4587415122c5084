#include "gpu/limits.h"

#include <stdio.h>
#include <string.h>

#include "gpu/spirv.h"

// The floor. Roadmap 2022 raises some of these above Vulkan 1.2; where it asks for more sampled images than lavapipe
// has or leaves a limit alone, the Vulkan 1.2 minimum applies. It asks for 30 storage buffers; passes whose effects
// need more than these are refused when they are created.
const struct vw_gpu_limits vw_gpu_floor_limits = {
    .storage_binding_bytes = 1u << 27,
    .buffer_bytes = 1u << 30,
    .texel_elements = 65536,
    .shared_memory_bytes = 16384,
    .workgroup_invocations = 256,
    .workgroup_size_x = 256,
    .workgroup_count_x = 65535,
    .workgroup_count_y = 65535,
    .storage_buffers = 8,
    .texel_buffers = 16,
    .storage_offset_alignment_bytes = 256,
    .texel_offset_alignment_bytes = 256,
    .push_offset_alignment_bytes = 256,
    .unrolls_loops = true, // a choice, which no device lacks; the next, too
    .resubmits = true,
};

// Limits where more is better, alignments where less is better, and optional features.
#define FOR_EACH_MAXIMUM(DO)                                                                                           \
    DO(storage_binding_bytes)                                                                                          \
    DO(buffer_bytes)                                                                                                   \
    DO(texel_elements)                                                                                                 \
    DO(shared_memory_bytes)                                                                                            \
    DO(workgroup_invocations)                                                                                          \
    DO(workgroup_size_x) DO(workgroup_count_x) DO(workgroup_count_y) DO(storage_buffers) DO(texel_buffers)
#define FOR_EACH_ALIGNMENT(DO)                                                                                         \
    DO(storage_offset_alignment_bytes) DO(texel_offset_alignment_bytes) DO(push_offset_alignment_bytes)
#define FOR_EACH_FEATURE(DO) DO(int64) DO(int64_atomics) DO(timestamps) DO(keeps_nan) DO(unrolls_loops) DO(resubmits)

void vw_limits_clamp(struct vw_gpu_limits *limits, const struct vw_gpu_limits *clamp) {
#define LOWER(field)                                                                                                   \
    if (limits->field > clamp->field) limits->field = clamp->field;
#define RAISE(field)                                                                                                   \
    if (limits->field < clamp->field) limits->field = clamp->field;
#define DISABLE(field) limits->field = limits->field && clamp->field;
    FOR_EACH_MAXIMUM(LOWER)
    FOR_EACH_ALIGNMENT(RAISE)
    FOR_EACH_FEATURE(DISABLE)
#undef LOWER
#undef RAISE
#undef DISABLE
}

// Returns the name of the first limit that is below the floor, NULL when none is.
static const char *missed_limit(const struct vw_gpu_limits *limits) {
#define AT_LEAST(field)                                                                                                \
    if (limits->field < vw_gpu_floor_limits.field) return #field;
#define AT_MOST(field)                                                                                                 \
    if (limits->field > vw_gpu_floor_limits.field) return #field;
    FOR_EACH_MAXIMUM(AT_LEAST)
    FOR_EACH_ALIGNMENT(AT_MOST)
#undef AT_LEAST
#undef AT_MOST
    return NULL;
}

// Appends " on <model name>" to a CPU device's name: the code it generates depends on the processor.
static void append_processor(struct vw_gpu_info *info) {
    char line[256];
    char model[128] = "an unnamed processor";
    FILE *file = fopen("/proc/cpuinfo", "re");
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "model name : %127[^\n]", model) == 1) break;
    if (file) fclose(file);
    size_t used = strlen(info->name);
    snprintf(info->name + used, sizeof info->name - used, " on %s", model);
}

static enum vw_gpu_kind kind_of(VkPhysicalDeviceType type) {
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return VW_GPU_DISCRETE;
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return VW_GPU_INTEGRATED;
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return VW_GPU_VIRTUAL;
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return VW_GPU_CPU;
    default: return VW_GPU_OTHER;
    }
}

static uint64_t largest_device_heap_bytes(VkPhysicalDevice physical) {
    VkPhysicalDeviceMemoryProperties memory;
    vkGetPhysicalDeviceMemoryProperties(physical, &memory);
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < memory.memoryHeapCount; i++)
        if ((memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) && memory.memoryHeaps[i].size > bytes)
            bytes = memory.memoryHeaps[i].size;
    return bytes;
}

int vw_queue_family_choose(const VkQueueFamilyProperties *families, uint32_t count) {
    int chosen = -1;
    for (uint32_t i = 0; i < count; i++) {
        VkQueueFlags flags = families[i].queueFlags;
        if (!(flags & VK_QUEUE_COMPUTE_BIT)) continue;
        // Without graphics a family leaves the screen alone, and watchdogs of drivers are more patient there.
        if (!(flags & VK_QUEUE_GRAPHICS_BIT) && families[i].timestampValidBits) return (int)i;
        if (chosen < 0) chosen = (int)i;
    }
    return chosen;
}

static bool find_queue_family(struct vw_device_candidate *candidate) {
    VkQueueFamilyProperties families[32];
    uint32_t count = 32;
    vkGetPhysicalDeviceQueueFamilyProperties(candidate->physical, &count, families);
    int chosen = vw_queue_family_choose(families, count);
    if (chosen < 0) return false;
    candidate->queue_family = (uint32_t)chosen;
    candidate->timestamp_bits = families[chosen].timestampValidBits;
    return true;
}

static struct vw_gpu_limits limits_of(const VkPhysicalDeviceLimits *device, uint64_t allocation_bytes) {
    return (struct vw_gpu_limits){
        .storage_binding_bytes = device->maxStorageBufferRange,
        .buffer_bytes = allocation_bytes,
        .texel_elements = device->maxTexelBufferElements,
        .shared_memory_bytes = device->maxComputeSharedMemorySize,
        .workgroup_invocations = device->maxComputeWorkGroupInvocations,
        .workgroup_size_x = device->maxComputeWorkGroupSize[0],
        .workgroup_count_x = device->maxComputeWorkGroupCount[0],
        .workgroup_count_y = device->maxComputeWorkGroupCount[1],
        .storage_buffers = device->maxPerStageDescriptorStorageBuffers,
        .texel_buffers = device->maxPerStageDescriptorSampledImages, // texel buffers count as sampled images
        .storage_offset_alignment_bytes = (uint32_t)device->minStorageBufferOffsetAlignment,
        .texel_offset_alignment_bytes = (uint32_t)device->minTexelBufferOffsetAlignment,
        .push_offset_alignment_bytes = (uint32_t)device->minUniformBufferOffsetAlignment,
    };
}

static struct vw_gpu_arithmetic arithmetic_of(const VkPhysicalDeviceVulkan11Properties *core11,
                                              const VkPhysicalDeviceVulkan12Properties *core12) {
    return (struct vw_gpu_arithmetic){
        .keeps_nan = core12->shaderSignedZeroInfNanPreserveFloat32,
        .keeps_denormals = core12->shaderDenormPreserveFloat32,
        .flushes_denormals = core12->shaderDenormFlushToZeroFloat32,
        .rounds_to_even = core12->shaderRoundingModeRTEFloat32,
        .subgroup_size = core11->subgroupSize,
    };
}

// Queries the properties that only a Vulkan 1.2 device has.
static void query_core(struct vw_device_candidate *candidate) {
    struct vw_gpu_info *info = &candidate->info;
    VkPhysicalDeviceVulkan12Properties core12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
    VkPhysicalDeviceVulkan11Properties core11 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES,
                                                 .pNext = &core12};
    VkPhysicalDeviceProperties2 properties = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                              .pNext = &core11};
    vkGetPhysicalDeviceProperties2(candidate->physical, &properties);
    VkPhysicalDeviceVulkan12Features features12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &features12};
    vkGetPhysicalDeviceFeatures2(candidate->physical, &features);

    const VkPhysicalDeviceLimits *device = &properties.properties.limits;
    uint32_t version = properties.properties.driverVersion;
    snprintf(info->driver, sizeof info->driver, "%s %s %u.%u.%u%s", core12.driverName, core12.driverInfo,
             VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version), VK_API_VERSION_PATCH(version),
             vw_loops_unroll() ? "" : ", loops kept"); // another form of the shaders, another run
    vw_text_make_line(info->driver);                   // ledgers have only names that can be shown
    candidate->timestamp_ns = (double)device->timestampPeriod;
    struct vw_gpu_limits *limits = &candidate->limits;
    *limits = limits_of(device, core11.maxMemoryAllocationSize);
    limits->int64 = features.features.shaderInt64;
    limits->int64_atomics = limits->int64 && features12.shaderBufferInt64Atomics;
    limits->timestamps = candidate->timestamp_bits > 0;
    limits->keeps_nan = core12.shaderSignedZeroInfNanPreserveFloat32;
    limits->unrolls_loops = vw_loops_unroll();
    limits->resubmits = true;
    info->arithmetic = arithmetic_of(&core11, &core12);
    info->arithmetic.int64_atomics = limits->int64_atomics;
    info->arithmetic.driver_version = version;

    const char *missed = features12.scalarBlockLayout ? missed_limit(limits) : "scalarBlockLayout";
    if (missed) snprintf(info->unsupported_reason, sizeof info->unsupported_reason, "%s", missed);
}

void vw_candidate_query(VkPhysicalDevice physical, struct vw_device_candidate *candidate) {
    *candidate = (struct vw_device_candidate){.physical = physical};
    struct vw_gpu_info *info = &candidate->info;
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    info->kind = kind_of(properties.deviceType);
    snprintf(info->name, sizeof info->name, "%s", properties.deviceName);
    if (info->kind == VW_GPU_CPU) append_processor(info);
    vw_text_make_line(info->name);
    info->memory_bytes = largest_device_heap_bytes(physical);
    if (properties.apiVersion < VK_API_VERSION_1_2)
        snprintf(info->unsupported_reason, sizeof info->unsupported_reason, "Vulkan 1.2");
    else if (!find_queue_family(candidate))
        snprintf(info->unsupported_reason, sizeof info->unsupported_reason, "a compute queue");
    else query_core(candidate);
}
