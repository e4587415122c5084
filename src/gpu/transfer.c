#include "gpu/transfer.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum vw_status vw_transfer_open(struct vw_gpu *gpu) {
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                          .queueFamilyIndex = gpu->chosen.queue_family};
    VkResult result = vkCreateCommandPool(gpu->device, &pool, NULL, &gpu->transfer_pool);
    if (result) return vw_gpu_fail(result, "vkCreateCommandPool", gpu->chosen.info.name);
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = gpu->transfer_pool,
                                                  .commandBufferCount = 1};
    result = vkAllocateCommandBuffers(gpu->device, &commands, &gpu->transfer);
    if (result) return vw_gpu_fail(result, "vkAllocateCommandBuffers", gpu->chosen.info.name);
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    result = vkCreateFence(gpu->device, &fence, NULL, &gpu->transfer_fence);
    return result ? vw_gpu_fail(result, "vkCreateFence", gpu->chosen.info.name) : VW_OK;
}

void vw_transfer_close(struct vw_gpu *gpu) {
    vkDestroyFence(gpu->device, gpu->transfer_fence, NULL);
    vkDestroyCommandPool(gpu->device, gpu->transfer_pool, NULL);
}

enum vw_status vw_transfer_begin(struct vw_gpu *gpu, const char *object) {
    enum vw_status status = vw_wait_check(gpu, object);
    if (status) return status;
    VkResult result = vkResetCommandPool(gpu->device, gpu->transfer_pool, 0);
    if (result) return vw_gpu_fail(result, "vkResetCommandPool", object);
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    result = vkBeginCommandBuffer(gpu->transfer, &info);
    return result ? vw_gpu_fail(result, "vkBeginCommandBuffer", object) : VW_OK;
}

// Submits a fence that follows all earlier submissions; without `info` it submits nothing else.
static enum vw_status submit_and_wait(struct vw_gpu *gpu, const VkSubmitInfo *info, const char *object) {
    enum vw_status status = vw_wait_check(gpu, object);
    if (status) return status;
    VkResult result = vkResetFences(gpu->device, 1, &gpu->transfer_fence);
    if (result) return vw_gpu_fail(result, "vkResetFences", object);
    result = vkQueueSubmit(gpu->queue, info ? 1 : 0, info, gpu->transfer_fence);
    if (result) return vw_gpu_fail(result, "vkQueueSubmit", object);
    char work[128];
    snprintf(work, sizeof work, "what came before the host's access to %s", object);
    return vw_wait_for_fence(gpu, gpu->transfer_fence, work);
}

enum vw_status vw_transfer_finish(struct vw_gpu *gpu, const char *object) {
    vw_barrier_record(gpu->transfer, (struct vw_barrier_params){.indirect = true, .host_reads = true});
    VkResult result = vkEndCommandBuffer(gpu->transfer);
    if (result) return vw_gpu_fail(result, "vkEndCommandBuffer", object);
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &gpu->transfer};
    return submit_and_wait(gpu, &info, object);
}

enum vw_status vw_transfer_drain(struct vw_gpu *gpu, const char *object) { return submit_and_wait(gpu, NULL, object); }

void vw_barrier_record(VkCommandBuffer commands, struct vw_barrier_params params) {
    const VkPipelineStageFlags device = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT |
                                        (params.indirect ? VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT : 0);
    const VkAccessFlags writes = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    const VkAccessFlags reads = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                                (params.indirect ? VK_ACCESS_INDIRECT_COMMAND_READ_BIT : 0);
    const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                     .srcAccessMask = writes,
                                     .dstAccessMask =
                                         reads | writes | (params.host_reads ? VK_ACCESS_HOST_READ_BIT : 0)};
    vkCmdPipelineBarrier(commands, device, device | (params.host_reads ? VK_PIPELINE_STAGE_HOST_BIT : 0), 0, 1,
                         &barrier, 0, NULL, 0, NULL);
}

// ---- Waiting, with an end: a device that hangs is reported ----------------------------------------------------------

// A submission of a GPU takes seconds at most. On a CPU one of many steps may rightly take minutes.
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
        "the device did not finish %s in %g s; if it is only slow, use fewer --rays, --samples or --val-rays, "
        "or set %s to more seconds; otherwise update the driver or choose another --device (--resume continues)",
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
