// Names of objects for debuggers, and what validation layers complain of.
#include "gpu/state.h"

enum vw_status vw_gpu_check_validation(struct vw_gpu *gpu) {
    unsigned complaints = atomic_load(&gpu->instance.complaints);
    if (!complaints) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "Vulkan validation complained %u times; see the messages on stderr", complaints);
}

void vw_gpu_set_name(struct vw_gpu *gpu, VkObjectType type, uint64_t handle, const char *name) {
    if (!gpu->instance.debug_utils) return;
    const VkDebugUtilsObjectNameInfoEXT info = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                                .objectType = type,
                                                .objectHandle = handle,
                                                .pObjectName = name};
    vkSetDebugUtilsObjectNameEXT(gpu->device, &info); // only for debug tools: a failure changes nothing
}
