#include "gpu/wait.h"

#include <math.h>
#include <stdlib.h>

// A batch of a GPU takes seconds at most. On a CPU one of many steps may rightly take minutes.
static const double LIMIT_S = 120.0, CPU_LIMIT_S = 3600.0, LONGEST_LIMIT_S = 1e9;
static const char LIMIT_NAME[] = "VIEWWORTH_DEVICE_TIMEOUT_S";

enum vw_status vw_wait_choose_limit(struct vw_gpu *gpu) {
    const char *text = getenv(LIMIT_NAME);
    gpu->wait_limit_s = gpu->chosen.info.kind == VW_GPU_CPU ? CPU_LIMIT_S : LIMIT_S;
    if (!text) return VW_OK;
    char *end;
    gpu->wait_limit_s = strtod(text, &end);
    if (end != text && !*end && gpu->wait_limit_s > 0.0 && gpu->wait_limit_s <= LONGEST_LIMIT_S) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "%s: \"%s\" is not a number of seconds above 0; set one or unset it", LIMIT_NAME,
                   text);
}

static enum vw_status fail_hung(const struct vw_gpu *gpu, const char *work) {
    return vw_fail(
        VW_ERROR_DEVICE_LOST,
        "the device did not finish %s in %g s; if it only is slow, use fewer --rays, --samples or --val-rays, "
        "or set %s to more seconds; else update the driver, or choose another --device (--resume goes on)",
        work, gpu->wait_limit_s, LIMIT_NAME);
}

enum vw_status vw_wait_check(const struct vw_gpu *gpu, const char *work) {
    return gpu->hung ? fail_hung(gpu, work) : VW_OK;
}

enum vw_status vw_wait_for_fence(struct vw_gpu *gpu, VkFence fence, const char *work) {
    if (gpu->hung) return fail_hung(gpu, work);
    VkResult result = vkWaitForFences(gpu->device, 1, &fence, VK_TRUE, (uint64_t)ceil(1e9 * gpu->wait_limit_s));
    if (result == VK_TIMEOUT) gpu->hung = true;
    if (gpu->hung) return fail_hung(gpu, work);
    return result ? vw_gpu_fail(result, "vkWaitForFences", work) : VW_OK;
}
