#define VOLK_IMPLEMENTATION
#include "gpu/instance.h"

#include <assert.h>
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

// Lists the extensions of the loader, or of `layer` when not NULL; owned by the caller. NULL and none when they cannot
// be queried.
static VkExtensionProperties *list_extensions(const char *layer, uint32_t *count) {
    *count = 0;
    if (vkEnumerateInstanceExtensionProperties(layer, count, NULL) != VK_SUCCESS) *count = 0;
    VkExtensionProperties *extensions = vw_allocate(*count, sizeof *extensions);
    if (!extensions || vkEnumerateInstanceExtensionProperties(layer, count, extensions) != VK_SUCCESS) *count = 0;
    return extensions;
}

static bool has_extension(const char *layer, const char *name) {
    uint32_t count;
    VkExtensionProperties *extensions = list_extensions(layer, &count);
    bool found = vw_extension_is_offered(extensions, count, name);
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
    uint32_t offered_count;
    VkExtensionProperties *offered = list_extensions(NULL, &offered_count);
    const struct vw_extension_choice extensions = vw_extensions_of_instance(offered, offered_count, validation);
    free(offered);
    instance->debug_utils = extensions.debug_utils;

    const char *const layers[] = {validation_layer};
    const VkValidationFeaturesEXT features = {
        .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
        .enabledValidationFeatureCount = 1,
        .pEnabledValidationFeatures =
            &(VkValidationFeatureEnableEXT){VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT},
    };
    const VkInstanceCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
        .pNext = validation ? &features : NULL,
        .flags = extensions.instance_flags,
        .pApplicationInfo = &(VkApplicationInfo){.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                                 .pApplicationName = "viewworth",
                                                 .apiVersion = VK_API_VERSION_1_2},
        .enabledLayerCount = validation ? 1 : 0,
        .ppEnabledLayerNames = layers,
        .enabledExtensionCount = extensions.count,
        .ppEnabledExtensionNames = extensions.names,
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

// ---- Extensions ----------------------------------------------------------------------------------------------------

static const char portability_subset[] = "VK_KHR_portability_subset"; // declared in a header for beta extensions alone

bool vw_extension_is_offered(const VkExtensionProperties *offered, uint32_t offered_count, const char *name) {
    for (uint32_t i = 0; i < offered_count; i++)
        if (!strcmp(offered[i].extensionName, name)) return true;
    return false;
}

static void add(struct vw_extension_choice *choice, const char *name) {
    assert(choice->count < VW_EXTENSIONS_MAX);
    choice->names[choice->count++] = name;
}

struct vw_extension_choice vw_extensions_of_instance(const VkExtensionProperties *offered, uint32_t offered_count,
                                                     bool validation) {
    struct vw_extension_choice choice = {0};
    choice.debug_utils =
        validation || vw_extension_is_offered(offered, offered_count, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (choice.debug_utils) add(&choice, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (validation) add(&choice, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    if (vw_extension_is_offered(offered, offered_count, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
        add(&choice, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
        choice.instance_flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
    }
    return choice;
}

struct vw_extension_choice vw_extensions_of_device(const VkExtensionProperties *offered, uint32_t offered_count) {
    struct vw_extension_choice choice = {0};
    if (vw_extension_is_offered(offered, offered_count, portability_subset)) add(&choice, portability_subset);
    return choice;
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
