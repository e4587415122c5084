#define VOLK_IMPLEMENTATION
#include "gpu/instance.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

static const char validation_layer[] = "VK_LAYER_KHRONOS_validation";

static VKAPI_ATTR VkBool32 VKAPI_CALL on_validation_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                            VkDebugUtilsMessageTypeFlagsEXT types,
                                                            const VkDebugUtilsMessengerCallbackDataEXT *data,
                                                            void *user) {
    (void)severity;
    (void)types;
    struct vw_instance *instance = user;
    atomic_fetch_add(&instance->complaints, 1);
    const char *label = data->cmdBufLabelCount ? data->pCmdBufLabels[0].pLabelName : "";
    fprintf(stderr, "vulkan validation%s%s: %s\n", *label ? " in " : "", label, data->pMessage);
    return VK_FALSE;
}

static const VkDebugUtilsMessengerCreateInfoEXT messenger_info = {
    .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
    .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
    .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT, // not the loader's notices about other drivers
    .pfnUserCallback = on_validation_message,
};

// Returns whether the loader, or `layer` when not NULL, offers an extension.
static bool has_extension(const char *layer, const char *name) {
    uint32_t count = 0;
    if (vkEnumerateInstanceExtensionProperties(layer, &count, NULL) != VK_SUCCESS) count = 0;
    VkExtensionProperties *extensions = vw_allocate(count, sizeof *extensions);
    bool listed = extensions && vkEnumerateInstanceExtensionProperties(layer, &count, extensions) == VK_SUCCESS;
    bool found = false;
    for (uint32_t i = 0; listed && i < count; i++) found |= !strcmp(extensions[i].extensionName, name);
    free(extensions);
    return found;
}

static enum vw_status check_loader(bool validation) {
    if (volkInitialize() != VK_SUCCESS)
        return vw_fail(VW_ERROR_NO_DEVICE, "no Vulkan loader; install it (Debian: libvulkan1)");
    if (volkGetInstanceVersion() < VK_API_VERSION_1_2)
        return vw_fail(VW_ERROR_NO_DEVICE, "the Vulkan loader is older than 1.2; update it (Debian: libvulkan1)");
    if (validation && !has_extension(validation_layer, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME))
        return vw_fail(VW_ERROR_DEVICE, "no %s with %s; install it (Debian: vulkan-validationlayers)", validation_layer,
                       VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    return VW_OK;
}

enum vw_status vw_instance_open(struct vw_instance *instance, bool validation) {
    enum vw_status status = check_loader(validation);
    if (status) return status;
    const char *const layers[] = {validation_layer};
    const char *const extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
    instance->debug_utils = validation || has_extension(NULL, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    const VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures =
            &(VkValidationFeatureEnableEXT){VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT},
    };
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validation ? &features : NULL,
        .pApplicationInfo = &(VkApplicationInfo){.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                                 .pApplicationName = "viewworth",
                                                 .apiVersion = VK_API_VERSION_1_2},
        .enabledLayerCount = validation ? 1 : 0,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = (uint32_t)instance->debug_utils + validation,
        .ppEnabledExtensionNames = extensions,
    };
    VkResult result = vkCreateInstance(&info, NULL, &instance->handle);
    if (result) return vw_gpu_fail(result, "vkCreateInstance", "Vulkan");
    // Loaded without a device, volk's pointers dispatch on the handle: several open devices may share them.
    volkLoadInstance(instance->handle);
    if (!validation) return VW_OK;

    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info;
    messenger.pUserData = instance;
    result = vkCreateDebugUtilsMessengerEXT(instance->handle, &messenger, NULL, &instance->messenger);
    return result ? vw_gpu_fail(result, "vkCreateDebugUtilsMessengerEXT", "Vulkan") : VW_OK;
}

void vw_instance_close(struct vw_instance *instance) {
    if (!instance->handle) return;
    if (instance->messenger) vkDestroyDebugUtilsMessengerEXT(instance->handle, instance->messenger, NULL);
    vkDestroyInstance(instance->handle, NULL);
    instance->handle = VK_NULL_HANDLE;
}

// ---- Complaints of the validation layer, and names for debuggers ----------------------------------------------------

enum vw_status vw_instance_check(struct vw_instance *instance) {
    unsigned complaints = atomic_load(&instance->complaints);
    if (!complaints) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "Vulkan validation complained %u times; see the messages on stderr", complaints);
}

void vw_instance_name_object(const struct vw_instance *instance, VkDevice device, VkObjectType type, uint64_t handle,
                             const char *name) {
    if (!instance->debug_utils) return;
    const VkDebugUtilsObjectNameInfoEXT info = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                                .objectType = type,
                                                .objectHandle = handle,
                                                .pObjectName = name};
    vkSetDebugUtilsObjectNameEXT(device, &info); // only for debug tools: a failure changes nothing
}

// ---- Errors --------------------------------------------------------------------------------------------------------

enum vw_status vw_gpu_fail(int result, const char *call, const char *object) {
    switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY:
        return vw_fail(VW_ERROR_MEMORY, "%s: out of host memory in %s; close other programs or use --downscale", object,
                       call);
    case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    case VK_ERROR_OUT_OF_POOL_MEMORY:
        return vw_fail(VW_ERROR_MEMORY,
                       "%s: out of device memory in %s; use fewer --rays, --samples or --val-rays, or another --device",
                       object, call);
    case VK_ERROR_TOO_MANY_OBJECTS:
        return vw_fail(VW_ERROR_MEMORY, "%s: the device allows no more allocations in %s; lower --together", object,
                       call);
    case VK_ERROR_DEVICE_LOST:
        return vw_fail(
            VW_ERROR_DEVICE_LOST,
            "%s: the device stopped answering in %s; run again (--resume continues); if it happens again, update "
            "the driver or choose another --device",
            object, call);
    case VK_ERROR_INCOMPATIBLE_DRIVER:
        return vw_fail(VW_ERROR_NO_DEVICE, "%s: no Vulkan driver in %s; install one (Debian: mesa-vulkan-drivers)",
                       object, call);
    default:
        return vw_fail(VW_ERROR_DEVICE, "%s: %s failed with VkResult %d; update the driver or choose another --device",
                       object, call, result);
    }
}
