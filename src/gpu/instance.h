// The Vulkan instance, with or without the validation layer.
#ifndef VIEWWORTH_GPU_INSTANCE_H
#define VIEWWORTH_GPU_INSTANCE_H

#include <stdatomic.h>
#include <stdbool.h>
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

#endif
