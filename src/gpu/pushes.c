#include "gpu/pushes.h"

#include <string.h>

#include "gpu/buffer.h"
#include "gpu/spirv.h"

enum { BUFFER_BYTES_LEAST = 256 }; // it doubles, since another buffer voids what all submissions have recorded

enum vw_status vw_pushes_open(struct vw_gpu *gpu) {
    const VkDescriptorSetLayoutBinding block = {.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                                .descriptorCount = 1,
                                                .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &block};
    VkResult result = vkCreateDescriptorSetLayout(gpu->device, &info, NULL, &gpu->push_layout);
    return result ? vw_gpu_fail(result, "vkCreateDescriptorSetLayout", "push blocks") : VW_OK;
}

void vw_pushes_close(struct vw_gpu *gpu) { vkDestroyDescriptorSetLayout(gpu->device, gpu->push_layout, NULL); }

enum vw_status vw_pushes_create(struct vw_gpu *gpu, struct vw_pushes *pushes) {
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes =
                                                 &(VkDescriptorPoolSize){VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 1}};
    VkResult result = vkCreateDescriptorPool(gpu->device, &pool, NULL, &pushes->pool);
    if (result) return vw_gpu_fail(result, "vkCreateDescriptorPool", "push blocks");
    const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pushes->pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &gpu->push_layout};
    result = vkAllocateDescriptorSets(gpu->device, &set, &pushes->set);
    return result ? vw_gpu_fail(result, "vkAllocateDescriptorSets", "push blocks") : VW_OK;
}

void vw_pushes_destroy(struct vw_gpu *gpu, struct vw_pushes *pushes) {
    if (!gpu->hung) vkDestroyDescriptorPool(gpu->device, pushes->pool, NULL);
    vw_buffer_destroy(&pushes->buffer);
}

// Makes room: whatever block a dispatch binds, its range is as long as the largest one.
static enum vw_status reserve(struct vw_gpu *gpu, struct vw_pushes *pushes, size_t size_bytes) {
    struct vw_buffer_params params = {
        .name = "push blocks", .size_bytes = BUFFER_BYTES_LEAST, .memory = VW_BUFFER_SHARED};
    while (params.size_bytes < size_bytes + VW_PUSH_BYTES_MAX) params.size_bytes *= 2;
    if (pushes->buffer && vw_buffer_size_bytes(pushes->buffer) >= params.size_bytes) return VW_OK;
    vw_buffer_destroy(&pushes->buffer);
    enum vw_status status = vw_buffer_create(gpu, &params, &pushes->buffer);
    if (status) return status;
    const VkDescriptorBufferInfo range = {pushes->buffer->handle, 0, VW_PUSH_BYTES_MAX};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = pushes->set,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                        .pBufferInfo = &range};
    vkUpdateDescriptorSets(gpu->device, 1, &write, 0, NULL);
    return VW_OK;
}

enum vw_status vw_pushes_write(struct vw_gpu *gpu, struct vw_pushes *pushes, const void *blocks, size_t size_bytes) {
    if (!size_bytes) return VW_OK;
    enum vw_status status = reserve(gpu, pushes, size_bytes);
    if (!status) memcpy(vw_buffer_map(pushes->buffer), blocks, size_bytes);
    return status;
}
