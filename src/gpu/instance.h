// The Vulkan instance, with or without the validation layer.
#ifndef VIEWWORTH_GPU_INSTANCE_H
#define VIEWWORTH_GPU_INSTANCE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <volk.h>

#include "viewworth/status.h"

// An instance with its validation; `complaints` counts the messages of the validation layer.
struct vw_instance {
    VkInstance handle;
    VkDebugUtilsMessengerEXT messenger;
    bool debug_utils; // object names and labels can be set
    atomic_uint complaints;
};

// Opens an instance, which must not move until vw_instance_close(); that accepts a half-open or zeroed one.
enum vw_status vw_instance_open(struct vw_instance *instance, bool validation);
void vw_instance_close(struct vw_instance *instance);
// Returns VW_OK, or VW_ERROR_DEVICE once validation has complained.
enum vw_status vw_instance_check(struct vw_instance *instance);
// Names an object of a device for debuggers.
void vw_instance_name_object(const struct vw_instance *instance, VkDevice device, VkObjectType type, uint64_t handle,
                             const char *name);

// ---- Extensions ----------------------------------------------------------------------------------------------------

// Extensions that viewworth uses are enabled if they are offered.
enum { VW_EXTENSIONS_MAX = 4 };

// The extensions for a VkInstanceCreateInfo or VkDeviceCreateInfo. `names` are static texts.
struct vw_extension_choice {
    const char *names[VW_EXTENSIONS_MAX];
    uint32_t count;
    VkInstanceCreateFlags instance_flags;
    bool debug_utils; // object names and labels can be set
};

bool vw_extension_is_offered(const VkExtensionProperties *offered, uint32_t offered_count, const char *name);

// Chooses those of an instance. `offered`: by the loader; `validation`: with those that the validation layer needs.
// Drivers on top of another interface, such as MoltenVK, are listed only for a program that enables portability
// enumeration.
struct vw_extension_choice vw_extensions_of_instance(const VkExtensionProperties *offered, uint32_t offered_count,
                                                     bool validation);

// Chooses those of a device. If portability subset is offered, the specification demands that it is enabled.
struct vw_extension_choice vw_extensions_of_device(const VkExtensionProperties *offered, uint32_t offered_count);

// ---- Errors --------------------------------------------------------------------------------------------------------

// Records that Vulkan `call` on `object` ("buffer rays", "pass forward_field", ...) ended with the VkResult `result`,
// and what to do.
enum vw_status vw_gpu_fail(int result, const char *call, const char *object);

#endif
