#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/instance.h"
#include "gpu/pipeline.h"
#include "gpu/spirv.h"
#include "gpu/transfer.h"

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
        vw_candidate_query(physical[i], &list[i]);
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
    if (!status && params->clamp) vw_limits_clamp(&made->chosen.limits, params->clamp);
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
