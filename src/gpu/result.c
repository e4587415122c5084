#include "gpu/result.h"

#include <volk.h>

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
