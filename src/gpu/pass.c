#include "gpu/pass.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/spirv.h"
#include "gpu/state.h"

enum { UNUSED_BYTES = 256 }; // more than any item of a buffer

// ---- Checks ---------------------------------------------------------------------------------------------------------

static enum vw_status check_limit(const char *pass, const char *what, uint64_t value, uint64_t limit) {
    if (value <= limit) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "pass %s: %llu %s, the device has %llu; use a smaller field or another --device",
                   pass, (unsigned long long)value, what, (unsigned long long)limit);
}

static enum vw_status check_feature(const char *pass, const char *what, bool needed, bool present) {
    if (!needed || present) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "pass %s: needs %s, which the device lacks; use the shader's variant without it",
                   pass, what);
}

// Passes that declare more than the floor are those of effects.
static enum vw_status check_storage_buffers(const char *pass, uint32_t count, uint32_t limit) {
    if (count <= limit) return VW_OK;
    return vw_fail(
        VW_ERROR_DEVICE,
        "pass %s: %u storage buffers, the device binds %u; leave out effects (--effects none) or use another "
        "--device",
        pass, count, limit);
}

static enum vw_status check_shader(const char *pass, const struct vw_spirv *spirv, const struct vw_gpu_limits *limits) {
    const uint32_t *size = spirv->workgroup_size;
    uint64_t invocations = (uint64_t)size[0] * size[1] * size[2];
    if (!invocations) return vw_fail(VW_ERROR_DEVICE, "pass %s: its workgroup size is 0; specialise it", pass);
    uint32_t texels = 0;
    for (uint32_t i = 0; i < spirv->slot_count; i++) texels += spirv->slots[i].texel;
    enum vw_status status = check_feature(pass, "64-bit integers", spirv->needs_int64, limits->int64);
    if (!status) status = check_feature(pass, "64-bit atomics", spirv->needs_int64_atomics, limits->int64_atomics);
    if (!status) status = check_limit(pass, "bytes of shared memory", spirv->shared_bytes, limits->shared_memory_bytes);
    if (!status) status = check_limit(pass, "bytes of its push block", spirv->push_bytes, VW_PUSH_BYTES_MAX);
    if (!status) status = check_limit(pass, "invocations a workgroup in x", size[0], limits->workgroup_size_x);
    if (!status) status = check_limit(pass, "invocations a workgroup", invocations, limits->workgroup_invocations);
    if (!status) status = check_storage_buffers(pass, spirv->slot_count - texels, limits->storage_buffers);
    if (!status) status = check_limit(pass, "texel buffers", texels, limits->texel_buffers);
    return status;
}

// Sets `size_bytes` to the size of the bound range.
static enum vw_status check_range(const char *pass, const struct vw_binding *binding,
                                  const struct vw_gpu_limits *limits, uint64_t *size_bytes) {
    const struct vw_buffer *buffer = binding->buffer;
    uint64_t limit =
        binding->texel ? UINT64_MAX : limits->storage_binding_bytes; // a texel view shrinks to its own limit
    uint32_t alignment = binding->texel ? limits->texel_offset_alignment_bytes : limits->storage_offset_alignment_bytes;
    enum vw_status status = vw_buffer_check_range(buffer, binding->offset_bytes, binding->size_bytes);
    if (status) return vw_fail_context(status, "pass %s, slot %u", pass, binding->slot);
    uint64_t size = binding->size_bytes ? binding->size_bytes : buffer->size_bytes - binding->offset_bytes;
    if (!size)
        return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: an empty range of %s", pass, binding->slot, buffer->name);
    if (size > limit)
        return vw_fail(VW_ERROR_DEVICE,
                       "pass %s, slot %u: %llu bytes of %s are more than one binding's %llu; bind windows of it", pass,
                       binding->slot, (unsigned long long)size, buffer->name, (unsigned long long)limit);
    if (alignment && binding->offset_bytes % alignment)
        return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: offset %llu in %s is not a multiple of %u bytes", pass,
                       binding->slot, (unsigned long long)binding->offset_bytes, buffer->name, alignment);
    *size_bytes = size;
    return VW_OK;
}

static const struct {
    VkFormat format;
    uint32_t bytes;
    bool is_float;
} texel_formats[] = {
    [VW_TEXEL_FLOAT1] = {VK_FORMAT_R32_SFLOAT, 4, true},
    [VW_TEXEL_FLOAT2] = {VK_FORMAT_R32G32_SFLOAT, 8, true},
    [VW_TEXEL_FLOAT4] = {VK_FORMAT_R32G32B32A32_SFLOAT, 16, true},
    [VW_TEXEL_UINT1] = {VK_FORMAT_R32_UINT, 4, false},
    [VW_TEXEL_UINT2] = {VK_FORMAT_R32G32_UINT, 8, false},
    [VW_TEXEL_UINT4] = {VK_FORMAT_R32G32B32A32_UINT, 16, false},
};

static enum vw_status check_kind(const char *pass, const struct vw_spirv_slot *slot, const struct vw_binding *binding) {
    if (slot->texel != (binding->texel != VW_TEXEL_NONE))
        return vw_fail(VW_ERROR_DEVICE,
                       "pass %s, slot %u: the shader declares a %s buffer, the binding is %s texel format", pass,
                       slot->slot, slot->texel ? "texel" : "storage", binding->texel ? "with a" : "without");
    if (slot->texel && slot->texel_float != texel_formats[binding->texel].is_float)
        return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: the shader reads %s texels; bind it with such a format",
                       pass, slot->slot, slot->texel_float ? "float" : "unsigned");
    return VW_OK;
}

// ---- Binding --------------------------------------------------------------------------------------------------------

static enum vw_status create_set(struct vw_pass *pass, const struct vw_spirv *spirv) {
    VkDevice device = pass->gpu->device;
    VkDescriptorPoolSize sizes[VW_SPIRV_MAX_SLOTS];
    if (!spirv->slot_count) return VW_OK;
    for (uint32_t i = 0; i < spirv->slot_count; i++)
        sizes[i] = (VkDescriptorPoolSize){vw_descriptor_type(&spirv->slots[i]), 1};
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = spirv->slot_count,
                                             .pPoolSizes = sizes};
    VkResult result = vkCreateDescriptorPool(device, &pool, NULL, &pass->pool);
    if (result) return vw_gpu_fail(result, "vkCreateDescriptorPool", pass->name);
    const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pass->pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &pass->pipeline->set_layout};
    result = vkAllocateDescriptorSets(device, &set, &pass->set);
    return result ? vw_gpu_fail(result, "vkAllocateDescriptorSets", pass->name) : VW_OK;
}

static enum vw_status create_view(struct vw_pass *pass, const struct vw_binding *binding, uint64_t size_bytes,
                                  VkBufferView *view) {
    uint32_t texel_bytes = texel_formats[binding->texel].bytes;
    uint64_t texels = size_bytes / texel_bytes;
    if (texels > pass->gpu->chosen.limits.texel_elements) texels = pass->gpu->chosen.limits.texel_elements;
    if (!texels)
        return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: %s is smaller than one texel", pass->name, binding->slot,
                       binding->buffer->name);
    const VkBufferViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                         .buffer = binding->buffer->handle,
                                         .format = texel_formats[binding->texel].format,
                                         .offset = binding->offset_bytes,
                                         .range = texels * texel_bytes};
    VkResult result = vkCreateBufferView(pass->gpu->device, &info, NULL, view);
    return result ? vw_gpu_fail(result, "vkCreateBufferView", binding->buffer->name) : VW_OK;
}

static enum vw_status bind_slot(struct vw_pass *pass, const struct vw_spirv_slot *declared,
                                const struct vw_binding *binding, struct vw_pass_slot *slot) {
    uint64_t size_bytes = 0;
    enum vw_status status = check_kind(pass->name, declared, binding);
    if (!status) status = check_range(pass->name, binding, &pass->gpu->chosen.limits, &size_bytes);
    if (status) return status;
    *slot = (struct vw_pass_slot){.buffer = binding->buffer, .writes = declared->writes};
    status = vw_ranges_find(&binding->buffer->ranges, binding->offset_bytes, size_bytes, &slot->range);
    if (!status && declared->texel) status = create_view(pass, binding, size_bytes, &slot->view);
    if (status) return status;
    const VkDescriptorBufferInfo range = {binding->buffer->handle, binding->offset_bytes, size_bytes};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = pass->set,
                                        .dstBinding = declared->slot,
                                        .descriptorCount = 1,
                                        .descriptorType = vw_descriptor_type(declared),
                                        .pBufferInfo = &range,
                                        .pTexelBufferView = &slot->view};
    vkUpdateDescriptorSets(pass->gpu->device, 1, &write, 0, NULL);
    return VW_OK;
}

// Binds a buffer of the pass's own, so that passes which do not use it need not wait for each other.
static enum vw_status bind_unused(struct vw_pass *pass, const struct vw_binding *binding, struct vw_binding *stand_in) {
    const struct vw_buffer_params params = {.name = "unused", .size_bytes = UNUSED_BYTES};
    *stand_in = (struct vw_binding){.slot = binding->slot, .size_bytes = UNUSED_BYTES, .texel = binding->texel};
    enum vw_status status = pass->unused ? VW_OK : vw_buffer_create(pass->gpu, &params, &pass->unused);
    stand_in->buffer = pass->unused;
    return status;
}

static enum vw_status bind_slots(struct vw_pass *pass, const struct vw_spirv *spirv,
                                 const struct vw_pass_params *params) {
    pass->slots = vw_allocate(spirv->slot_count, sizeof *pass->slots);
    if (!pass->slots) return VW_ERROR_MEMORY;
    pass->slot_count = spirv->slot_count;
    for (uint32_t i = 0; i < spirv->slot_count; i++) {
        uint32_t slot = spirv->slots[i].slot;
        const struct vw_binding *bound = NULL;
        for (uint32_t j = 0; j < params->binding_count; j++) {
            if (params->bindings[j].slot != slot) continue;
            if (bound) return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: bound twice", pass->name, slot);
            bound = &params->bindings[j];
        }
        struct vw_binding stand_in;
        if (bound && bound->unused) {
            enum vw_status status = bind_unused(pass, bound, &stand_in);
            if (status) return status;
            bound = &stand_in;
        }
        if (!bound || !bound->buffer)
            return vw_fail(VW_ERROR_DEVICE, "pass %s, slot %u: the shader declares it, but no buffer is bound",
                           pass->name, slot);
        enum vw_status status = bind_slot(pass, &spirv->slots[i], bound, &pass->slots[i]);
        if (status) return status;
    }
    return VW_OK;
}

// ---- Life -----------------------------------------------------------------------------------------------------------

enum vw_status vw_pass_create(struct vw_gpu *gpu, const struct vw_pass_params *params, struct vw_pass **pass) {
    struct vw_spirv spirv;
    enum vw_status status = vw_spirv_read(params->shader, params->specialization, params->specialization_count, &spirv);
    if (!status) status = check_shader(params->shader->name, &spirv, &gpu->chosen.limits);
    if (status) return status;
    struct vw_pass *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->gpu = gpu;
    made->name = params->shader->name;
    made->role = params->role;
    made->push_bytes = spirv.push_bytes;
    made->workgroup_invocations = spirv.workgroup_size[0] * spirv.workgroup_size[1] * spirv.workgroup_size[2];
    status = vw_pipeline_find(gpu, params, &spirv, &made->pipeline);
    if (!status) status = create_set(made, &spirv);
    if (!status) status = bind_slots(made, &spirv, params);
    if (status) {
        vw_pass_destroy(&made);
        return status;
    }
    *pass = made;
    return VW_OK;
}

static void destroy_handles(struct vw_pass *pass) {
    VkDevice device = pass->gpu->device;
    vkDestroyDescriptorPool(device, pass->pool, NULL);
    for (uint32_t i = 0; i < pass->slot_count; i++) vkDestroyBufferView(device, pass->slots[i].view, NULL);
}

void vw_pass_destroy(struct vw_pass **pass) {
    struct vw_pass *dying = *pass;
    if (!dying) return;
    if (!dying->gpu->hung) destroy_handles(dying);
    dying->gpu->destroyed++;
    vw_buffer_destroy(&dying->unused);
    free(dying->slots);
    free(dying);
    *pass = NULL;
}

const char *vw_pass_name(const struct vw_pass *pass) { return pass->name; }
