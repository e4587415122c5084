#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/instance.h"
#include "gpu/pipeline.h"
#include "gpu/spirv.h"
#include "gpu/transfer.h"

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

static void clamp_limits(struct vw_gpu_limits *limits, const struct vw_gpu_limits *clamp) {
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

// Fills in everything but info.index.
static void query_candidate(VkPhysicalDevice physical, struct vw_device_candidate *candidate) {
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

// ---- Listing and choosing -------------------------------------------------------------------------------------------

// Orders devices by preference; devices of one kind stay in the driver's order, which info.index contains until the
// list is ranked.
static int by_preference(const void *left, const void *right) {
    const struct vw_gpu_info *a = &((const struct vw_device_candidate *)left)->info;
    const struct vw_gpu_info *b = &((const struct vw_device_candidate *)right)->info;
    if (a->kind != b->kind) return a->kind < b->kind ? -1 : 1;
    return a->index < b->index ? -1 : 1;
}

// Lists the devices; the caller frees `*candidates`.
static enum vw_status list_candidates(const struct vw_instance *instance, struct vw_device_candidate **candidates,
                                      uint32_t *count) {
    enum vw_status status = VW_OK;
    struct vw_device_candidate *list = NULL;
    uint32_t found = 0;
    VkResult result = vkEnumeratePhysicalDevices(instance->handle, &found, NULL);
    VkPhysicalDevice *physical = vw_allocate(found, sizeof *physical);
    if (!physical) return VW_ERROR_MEMORY;
    if (!result) result = vkEnumeratePhysicalDevices(instance->handle, &found, physical);
    if (result) status = vw_gpu_fail(result, "vkEnumeratePhysicalDevices", "Vulkan");
    else if (!found)
        status = vw_fail(VW_ERROR_NO_DEVICE, "no Vulkan device; install a driver (Debian: mesa-vulkan-drivers)");
    else if (!(list = vw_allocate(found, sizeof *list))) status = VW_ERROR_MEMORY;
    if (!list) goto done;

    for (uint32_t i = 0; i < found; i++) {
        query_candidate(physical[i], &list[i]);
        list[i].info.index = i;
    }
    qsort(list, found, sizeof *list, by_preference);
    for (uint32_t i = 0; i < found; i++) list[i].info.index = i;
    *candidates = list;
    *count = found;
done:
    free(physical);
    return status;
}

enum vw_status vw_gpu_list(struct vw_gpu_info **infos, uint32_t *count) {
    struct vw_instance instance = {0};
    struct vw_device_candidate *candidates = NULL;
    struct vw_gpu_info *list = NULL;
    uint32_t found = 0;
    enum vw_status status = vw_instance_open(&instance, false);
    if (!status) status = list_candidates(&instance, &candidates, &found);
    if (!status && !(list = vw_allocate(found, sizeof *list))) status = VW_ERROR_MEMORY;
    if (!status) {
        for (uint32_t i = 0; i < found; i++) list[i] = candidates[i].info;
        *infos = list;
        *count = found;
    }
    free(candidates);
    vw_instance_close(&instance);
    return status;
}

static bool is_wanted(const struct vw_gpu_info *info, const char *device) {
    bool cpu = info->kind == VW_GPU_CPU, usable = !*info->unsupported_reason;
    if (!device) return usable;
    if (!strcasecmp(device, "cpu")) return usable && cpu;
    if (!strcasecmp(device, "gpu")) return usable && !cpu;
    if (device[strspn(device, "0123456789")] != '\0') return strcasestr(info->name, device) != NULL;
    char index[16];
    snprintf(index, sizeof index, "%u", info->index);
    return !strcmp(index, device);
}

static enum vw_status fail_without_choice(const struct vw_device_candidate *candidates, uint32_t count,
                                          const char *device) {
    char list[768] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < count && used < sizeof list; i++) {
        const struct vw_gpu_info *info = &candidates[i].info;
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%u %s%s%s", i ? ", " : "", info->index, info->name,
                                 *info->unsupported_reason ? " without " : "", info->unsupported_reason);
    }
    if (device) return vw_fail(VW_ERROR_NO_DEVICE, "no device matches --device \"%s\"; there is: %s", device, list);
    return vw_fail(VW_ERROR_NO_DEVICE, "no device meets the floor; there is: %s", list);
}

static enum vw_status choose(struct vw_gpu *gpu, const char *device) {
    struct vw_device_candidate *candidates = NULL;
    uint32_t count = 0;
    enum vw_status status = list_candidates(&gpu->instance, &candidates, &count);
    if (status) return status;
    uint32_t i = 0;
    while (i < count && !is_wanted(&candidates[i].info, device)) i++;
    if (i == count) status = fail_without_choice(candidates, count, device);
    else if (*candidates[i].info.unsupported_reason)
        status = vw_fail(VW_ERROR_NO_DEVICE, "device %u %s falls short in %s; choose another --device", i,
                         candidates[i].info.name, candidates[i].info.unsupported_reason);
    else gpu->chosen = candidates[i];
    free(candidates);
    return status;
}

// ---- Opening --------------------------------------------------------------------------------------------------------

static enum vw_status create_device(struct vw_gpu *gpu) {
    const struct vw_gpu_limits *limits = &gpu->chosen.limits;
    VkPhysicalDeviceVulkan12Features features12 = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
        .shaderBufferInt64Atomics = limits->int64_atomics,
        .scalarBlockLayout = VK_TRUE,
        .hostQueryReset = VK_TRUE, // every Vulkan 1.2 device has it
    };
    const VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                                .pNext = &features12,
                                                .features.shaderInt64 = limits->int64};
    const VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
        .queueFamilyIndex = gpu->chosen.queue_family,
        .queueCount = 1,
        .pQueuePriorities = &(float){1.0f},
    };
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = &features,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue};
    VkResult result = vkCreateDevice(gpu->chosen.physical, &info, NULL, &gpu->device);
    if (result) return vw_gpu_fail(result, "vkCreateDevice", gpu->chosen.info.name);
    vkGetDeviceQueue(gpu->device, gpu->chosen.queue_family, 0, &gpu->queue);
    vkGetPhysicalDeviceMemoryProperties(gpu->chosen.physical, &gpu->memory);
    return VW_OK;
}

// lavapipe crashes below 700 MB of address space on two processors, and its threads need more.
enum { DRIVER_ADDRESS_SPACE_MIB = 1024 };

enum vw_status vw_gpu_open(const struct vw_gpu_params *params, struct vw_gpu **gpu) {
    enum vw_status status = vw_check_address_space(DRIVER_ADDRESS_SPACE_MIB, "Vulkan drivers");
    if (!status) status = vw_loops_check_choice();
    if (status) return status;
    struct vw_gpu *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    vw_shader_cache_separate_widths();
    status = vw_instance_open(&made->instance, params->validation);
    if (!status) status = choose(made, params->device);
    if (!status && params->clamp) clamp_limits(&made->chosen.limits, params->clamp);
    if (!status) status = vw_wait_choose_limit(made);
    if (!status) status = create_device(made);
    if (!status) status = vw_transfer_open(made);
    if (!status) status = vw_pushes_open(made);
    if (!status) status = vw_shader_cache_open(made);
    if (status) {
        vw_gpu_close(&made);
        return status;
    }
    made->timers_wanted = params->timers && made->chosen.limits.timestamps;
    *gpu = made;
    return VW_OK;
}

// Waits, unless the device is lost or hung; either is reported before.
static void finish_work(struct vw_gpu *gpu) {
    struct vw_saved_error why = vw_error_save(); // the device may be closing because something failed
    if (!gpu->hung && gpu->transfer_fence) (void)vw_transfer_drain(gpu, "the device");
    vw_error_restore(&why);
}

// Frees only what belongs to the host alone: a hung device may still use everything else, so it stays open.
static void abandon(struct vw_gpu *gpu) {
    static struct vw_gpu *hung; // the program can still find them, so that searches for leaks pass over them
    gpu->hung_before = hung;
    hung = gpu;
    vw_buffer_destroy(&gpu->staging);
    free(gpu->timers);
    gpu->timers = NULL;
}

enum vw_status vw_gpu_close(struct vw_gpu **gpu) {
    struct vw_gpu *closing = *gpu;
    if (!closing) return VW_OK;
    *gpu = NULL;
    if (closing->device) finish_work(closing);
    if (closing->hung) {
        abandon(closing);
        return vw_instance_check(&closing->instance);
    }
    if (closing->device) {
        vw_buffer_destroy(&closing->staging);
        vw_shader_cache_close(closing);
        vw_pipelines_destroy(closing);
        vw_pushes_close(closing);
        vw_transfer_close(closing);
        vkDestroyDevice(closing->device, NULL);
    }
    enum vw_status status = vw_instance_check(&closing->instance);
    vw_instance_close(&closing->instance);
    free(closing->timers);
    free(closing);
    return status;
}

const struct vw_gpu_info *vw_gpu_get_info(const struct vw_gpu *gpu) { return &gpu->chosen.info; }

const struct vw_gpu_limits *vw_gpu_get_limits(const struct vw_gpu *gpu) { return &gpu->chosen.limits; }
uint64_t vw_gpu_buffer_bytes(const struct vw_gpu *gpu) { return gpu->buffer_bytes; }
