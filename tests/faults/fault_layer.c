// A Vulkan layer that makes calls of the device fail, for scripts/faults. Its manifest lies beside it in the build
// folder; VK_LAYER_PATH names that folder, VK_INSTANCE_LAYERS=VK_LAYER_VIEWWORTH_faults switches it on. Numbers count
// from 1.
//
//     FAULT_LOG=FILE           every call that may fail is a line of FILE: its number and kind
//     FAULT_DEVICE_LOST=N      the Nth submission or wait says that the device is lost, as do all later ones
//     FAULT_DEVICE_HANGS=N     the Nth of these, if it is a wait, runs into its time limit, as do all later waits
//     FAULT_DEVICE_MEMORY=N    the Nth allocation says that there is no memory on the device,
//     FAULT_REPEAT=1           as do all later ones
#include <fcntl.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *version);

static const char layer_name[] = "VK_LAYER_VIEWWORTH_faults";
static atomic_long device_calls, allocations;

// The next functions in the chain. There is one instance and one device at a time.
static PFN_vkGetInstanceProcAddr next_instance_function;
static PFN_vkGetDeviceProcAddr next_device_function;
static VkInstance current_instance;
static VkDevice current_device;

static long read_number(const char *name) {
    const char *text = getenv(name);
    return text ? strtol(text, NULL, 10) : 0;
}

static void write_log(const char *kind, long number) {
    const char *path = getenv("FAULT_LOG");
    int file = path ? open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666) : -1;
    if (file < 0) return;
    dprintf(file, "%ld %s\n", number, kind);
    close(file);
}

static bool is_lost(void) {
    long number = ++device_calls, lost = read_number("FAULT_DEVICE_LOST");
    write_log("device", number);
    return lost && number >= lost;
}

// ---- Calls that fail -----------------------------------------------------------------------------------------------

#define NEXT(name) ((PFN_##name)next_device_function(current_device, #name))

static VKAPI_ATTR VkResult VKAPI_CALL submit(VkQueue queue, uint32_t count, const VkSubmitInfo *info, VkFence fence) {
    return is_lost() ? VK_ERROR_DEVICE_LOST : NEXT(vkQueueSubmit)(queue, count, info, fence);
}

static VKAPI_ATTR VkResult VKAPI_CALL wait_for_fences(VkDevice device, uint32_t count, const VkFence *fences,
                                                      VkBool32 all, uint64_t timeout_ns) {
    VkResult result = NEXT(vkWaitForFences)(device, count, fences, all, timeout_ns);
    long hangs = read_number("FAULT_DEVICE_HANGS");
    if (is_lost()) return VK_ERROR_DEVICE_LOST;
    return hangs && device_calls >= hangs ? VK_TIMEOUT : result;
}

static VKAPI_ATTR VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkDeviceMemory *memory) {
    long number = ++allocations, failing = read_number("FAULT_DEVICE_MEMORY");
    write_log("allocation", number);
    if (failing && (number == failing || (number > failing && read_number("FAULT_REPEAT"))))
        return VK_ERROR_OUT_OF_DEVICE_MEMORY;
    return NEXT(vkAllocateMemory)(device, info, allocator, memory);
}

// ---- The chain -----------------------------------------------------------------------------------------------------

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo *info,
                                                      const VkAllocationCallbacks *allocator, VkInstance *instance) {
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)(uintptr_t)info->pNext;
    while (link &&
           (link->sType != VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO))
        link = (VkLayerInstanceCreateInfo *)(uintptr_t)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_instance_function = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateInstance create = (PFN_vkCreateInstance)next_instance_function(NULL, "vkCreateInstance");
    VkResult result = create(info, allocator, instance);
    if (!result) current_instance = *instance;
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                                                    const VkAllocationCallbacks *allocator, VkDevice *device) {
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)(uintptr_t)info->pNext;
    while (link && (link->sType != VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO || link->function != VK_LAYER_LINK_INFO))
        link = (VkLayerDeviceCreateInfo *)(uintptr_t)link->pNext;
    if (!link) return VK_ERROR_INITIALIZATION_FAILED;
    next_device_function = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateDevice create = (PFN_vkCreateDevice)next_instance_function(current_instance, "vkCreateDevice");
    VkResult result = create(physical, info, allocator, device);
    if (!result) current_device = *device;
    return result;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find_device_function(VkDevice device, const char *name);
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find_instance_function(VkInstance instance, const char *name);

static PFN_vkVoidFunction find_own(const char *name) {
    static const struct {
        const char *name;
        PFN_vkVoidFunction function;
    } own[] = {
        {"vkCreateInstance", (PFN_vkVoidFunction)create_instance},
        {"vkCreateDevice", (PFN_vkVoidFunction)create_device},
        {"vkGetInstanceProcAddr", (PFN_vkVoidFunction)find_instance_function},
        {"vkGetDeviceProcAddr", (PFN_vkVoidFunction)find_device_function},
        {"vkQueueSubmit", (PFN_vkVoidFunction)submit},
        {"vkWaitForFences", (PFN_vkVoidFunction)wait_for_fences},
        {"vkAllocateMemory", (PFN_vkVoidFunction)allocate_memory},
    };
    for (size_t i = 0; i < sizeof own / sizeof own[0]; i++)
        if (!strcmp(name, own[i].name)) return own[i].function;
    return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find_device_function(VkDevice device, const char *name) {
    PFN_vkVoidFunction function = find_own(name);
    return function ? function : next_device_function(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL find_instance_function(VkInstance instance, const char *name) {
    PFN_vkVoidFunction function = find_own(name);
    return function ? function : next_instance_function(instance, name);
}

VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *version) {
    write_log(layer_name, 0);
    version->loaderLayerInterfaceVersion = 2;
    version->pfnGetInstanceProcAddr = find_instance_function;
    version->pfnGetDeviceProcAddr = find_device_function;
    version->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
