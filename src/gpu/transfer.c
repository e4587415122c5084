#include "gpu/transfer.h"

#include "gpu/barrier.h"

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
    return result ? vw_gpu_fail(result, "vkAllocateCommandBuffers", gpu->chosen.info.name) : VW_OK;
}

void vw_transfer_close(struct vw_gpu *gpu) { vkDestroyCommandPool(gpu->device, gpu->transfer_pool, NULL); }

enum vw_status vw_transfer_begin(struct vw_gpu *gpu, const char *object) {
    VkResult result = vkResetCommandPool(gpu->device, gpu->transfer_pool, 0);
    if (result) return vw_gpu_fail(result, "vkResetCommandPool", object);
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    result = vkBeginCommandBuffer(gpu->transfer, &info);
    return result ? vw_gpu_fail(result, "vkBeginCommandBuffer", object) : VW_OK;
}

enum vw_status vw_transfer_finish(struct vw_gpu *gpu, const char *object) {
    vw_barrier_record(gpu->transfer, (struct vw_barrier_params){.host_reads = true});
    VkResult result = vkEndCommandBuffer(gpu->transfer);
    if (result) return vw_gpu_fail(result, "vkEndCommandBuffer", object);
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &gpu->transfer};
    result = vkQueueSubmit(gpu->queue, 1, &info, VK_NULL_HANDLE);
    if (result) return vw_gpu_fail(result, "vkQueueSubmit", object);
    result = vkQueueWaitIdle(gpu->queue);
    return result ? vw_gpu_fail(result, "vkQueueWaitIdle", object) : VW_OK;
}
