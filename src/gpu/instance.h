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

// ---- Errors --------------------------------------------------------------------------------------------------------

// Records that Vulkan `call` on `object` ("buffer rays", "pass forward_field", ...) ended with the VkResult `result`,
// and what to do.
enum vw_status vw_gpu_fail(int result, const char *call, const char *object);

#endif
