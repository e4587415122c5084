#include "gpu/state.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/instance.h"
#include "gpu/transfer.h"

enum { STAGING_BYTES = 16 << 20 };

// ---- Memory ---------------------------------------------------------------------------------------------------------

// Returns the first memory type of `type_bits` that has all `wanted` properties, or -1.
static int find_memory_type(const struct vw_gpu *gpu, uint32_t type_bits, VkMemoryPropertyFlags wanted) {
    for (uint32_t i = 0; i < gpu->memory.memoryTypeCount; i++)
        if ((type_bits >> i & 1) && (gpu->memory.memoryTypes[i].propertyFlags & wanted) == wanted) return (int)i;
    return -1;
}

static int choose_memory_type(const struct vw_gpu *gpu, uint32_t type_bits, enum vw_buffer_memory memory) {
    const VkMemoryPropertyFlags coherent = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    int type = -1;
    if (memory == VW_BUFFER_DEVICE) type = find_memory_type(gpu, type_bits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (memory == VW_BUFFER_SHARED)
        type = find_memory_type(gpu, type_bits, coherent | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (memory == VW_BUFFER_READBACK)
        type = find_memory_type(gpu, type_bits, coherent | VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
    if (type < 0) type = find_memory_type(gpu, type_bits, memory == VW_BUFFER_DEVICE ? 0 : coherent);
    return type;
}

static enum vw_status fail_room(const struct vw_buffer *buffer, int type) {
    const struct vw_gpu *gpu = buffer->gpu;
    uint64_t room_bytes = gpu->memory.memoryHeaps[gpu->memory.memoryTypes[type].heapIndex].size;
    return vw_fail(VW_ERROR_MEMORY,
                   "%s: the device has no room for its %.1f MiB beside %.1f MiB of this run (the device has %.0f MiB, "
                   "which other programs use as well); use fewer --rays, --samples or --val-rays, a smaller "
                   "--log2-table or --width, or another --device",
                   buffer->name, (double)buffer->size_bytes / 0x1p20,
                   (double)(gpu->buffer_bytes - buffer->size_bytes) / 0x1p20, (double)room_bytes / 0x1p20);
}

static enum vw_status allocate_memory(struct vw_buffer *buffer, enum vw_buffer_memory memory) {
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(buffer->gpu->device, buffer->handle, &needs);
    int type = choose_memory_type(buffer->gpu, needs.memoryTypeBits, memory);
    if (type < 0)
        return vw_fail(VW_ERROR_DEVICE, "%s: the device has no memory for it; choose another --device", buffer->name);
    const VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                       .allocationSize = needs.size,
                                       .memoryTypeIndex = (uint32_t)type};
    VkResult result = vkAllocateMemory(buffer->gpu->device, &info, NULL, &buffer->memory);
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY && memory == VW_BUFFER_SHARED) // a small heap, which others use, too
        return allocate_memory(buffer, VW_BUFFER_UPLOAD);
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY) return fail_room(buffer, type);
    if (result) return vw_gpu_fail(result, "vkAllocateMemory", buffer->name);
    result = vkBindBufferMemory(buffer->gpu->device, buffer->handle, buffer->memory, 0);
    if (result) return vw_gpu_fail(result, "vkBindBufferMemory", buffer->name);
    if (memory == VW_BUFFER_DEVICE) return VW_OK;
    result = vkMapMemory(buffer->gpu->device, buffer->memory, 0, VK_WHOLE_SIZE, 0, &buffer->mapped);
    return result ? vw_gpu_fail(result, "vkMapMemory", buffer->name) : VW_OK;
}

// ---- Transfers that the host waits for ------------------------------------------------------------------------------

static enum vw_status clear_buffer(struct vw_buffer *buffer) {
    if (buffer->mapped) {
        memset(buffer->mapped, 0, buffer->size_bytes);
        return VW_OK;
    }
    enum vw_status status = vw_transfer_begin(buffer->gpu, buffer->name);
    if (status) return status;
    vkCmdFillBuffer(buffer->gpu->transfer, buffer->handle, 0, VK_WHOLE_SIZE, 0);
    return vw_transfer_finish(buffer->gpu, buffer->name);
}

static enum vw_status copy_and_wait(struct vw_buffer *from, uint64_t from_offset_bytes, struct vw_buffer *to,
                                    uint64_t to_offset_bytes, uint64_t size_bytes, const char *object) {
    enum vw_status status = vw_transfer_begin(from->gpu, object);
    if (status) return status;
    const VkBufferCopy region = {.srcOffset = from_offset_bytes, .dstOffset = to_offset_bytes, .size = size_bytes};
    vkCmdCopyBuffer(from->gpu->transfer, from->handle, to->handle, 1, &region);
    return vw_transfer_finish(from->gpu, object);
}

// Creates the staging buffer, host-cached since it serves both directions.
static enum vw_status need_staging(struct vw_gpu *gpu) {
    if (gpu->staging) return VW_OK;
    return vw_buffer_create(
        gpu, &(struct vw_buffer_params){.name = "staging", .size_bytes = STAGING_BYTES, .memory = VW_BUFFER_READBACK},
        &gpu->staging);
}

enum vw_status vw_buffer_check_range(const struct vw_buffer *buffer, uint64_t offset_bytes, uint64_t size_bytes) {
    if (offset_bytes <= buffer->size_bytes && size_bytes <= buffer->size_bytes - offset_bytes) return VW_OK;
    return vw_fail(VW_ERROR_DEVICE, "%s: bytes %llu and %llu more are beyond its %llu bytes", buffer->name,
                   (unsigned long long)offset_bytes, (unsigned long long)size_bytes,
                   (unsigned long long)buffer->size_bytes);
}

enum vw_status vw_buffer_write(struct vw_buffer *buffer, uint64_t offset_bytes, const void *data, uint64_t size_bytes) {
    enum vw_status status = vw_buffer_check_range(buffer, offset_bytes, size_bytes);
    if (status) return status;
    if (buffer->mapped) {
        status = vw_transfer_drain(buffer->gpu, buffer->name);
        if (!status) memcpy((char *)buffer->mapped + offset_bytes, data, size_bytes);
        return status;
    }
    status = need_staging(buffer->gpu);
    struct vw_buffer *staging = buffer->gpu->staging;
    for (uint64_t done = 0; !status && done < size_bytes; done += STAGING_BYTES) {
        uint64_t part = size_bytes - done < STAGING_BYTES ? size_bytes - done : STAGING_BYTES;
        memcpy(staging->mapped, (const char *)data + done, part);
        status = copy_and_wait(staging, 0, buffer, offset_bytes + done, part, buffer->name);
    }
    return status;
}

enum vw_status vw_buffer_read(struct vw_buffer *buffer, uint64_t offset_bytes, void *data, uint64_t size_bytes) {
    enum vw_status status = vw_buffer_check_range(buffer, offset_bytes, size_bytes);
    if (status) return status;
    if (buffer->mapped) {
        status = vw_transfer_drain(buffer->gpu, buffer->name);
        if (!status) memcpy(data, (char *)buffer->mapped + offset_bytes, size_bytes);
        return status;
    }
    status = need_staging(buffer->gpu);
    struct vw_buffer *staging = buffer->gpu->staging;
    for (uint64_t done = 0; !status && done < size_bytes; done += STAGING_BYTES) {
        uint64_t part = size_bytes - done < STAGING_BYTES ? size_bytes - done : STAGING_BYTES;
        status = copy_and_wait(buffer, offset_bytes + done, staging, 0, part, buffer->name);
        if (!status) memcpy((char *)data + done, staging->mapped, part);
    }
    return status;
}

// ---- Life -----------------------------------------------------------------------------------------------------------

static enum vw_status create_handle(struct vw_buffer *buffer) {
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = (buffer->size_bytes + 3) & ~(uint64_t)3, // vkCmdFillBuffer clears whole words
        .usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT,
    };
    VkResult result = vkCreateBuffer(buffer->gpu->device, &info, NULL, &buffer->handle);
    if (result) return vw_gpu_fail(result, "vkCreateBuffer", buffer->name);
    vw_instance_name_object(&buffer->gpu->instance, buffer->gpu->device, VK_OBJECT_TYPE_BUFFER,
                            (uint64_t)buffer->handle, buffer->name);
    return VW_OK;
}

enum vw_status vw_buffer_create(struct vw_gpu *gpu, const struct vw_buffer_params *params, struct vw_buffer **buffer) {
    const char *name = params->name ? params->name : "unnamed";
    if (!params->size_bytes) return vw_fail(VW_ERROR_DEVICE, "buffer %s: its size is 0 bytes; leave it out", name);
    if (params->size_bytes > gpu->chosen.limits.buffer_bytes)
        return vw_fail(VW_ERROR_MEMORY,
                       "buffer %s: %llu bytes are more than the %llu that the device allocates at once; use a smaller "
                       "configuration or another --device",
                       name, (unsigned long long)params->size_bytes,
                       (unsigned long long)gpu->chosen.limits.buffer_bytes);
    struct vw_buffer *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->gpu = gpu;
    made->size_bytes = params->size_bytes;
    gpu->buffer_bytes += made->size_bytes;
    made->name = vw_format_text("buffer %s", name);
    enum vw_status status = made->name ? create_handle(made) : VW_ERROR_MEMORY;
    if (!status) status = allocate_memory(made, params->memory);
    if (!status) status = clear_buffer(made);
    if (status) {
        vw_buffer_destroy(&made);
        return status;
    }
    *buffer = made;
    return VW_OK;
}

void vw_buffer_destroy(struct vw_buffer **buffer) {
    struct vw_buffer *dying = *buffer;
    if (!dying) return;
    if (!dying->gpu->hung) {
        vkDestroyBuffer(dying->gpu->device, dying->handle, NULL);
        vkFreeMemory(dying->gpu->device, dying->memory, NULL);
    }
    dying->gpu->destroyed++;
    dying->gpu->buffer_bytes -= dying->size_bytes;
    free(dying->ranges.list);
    free(dying->name);
    free(dying);
    *buffer = NULL;
}

uint64_t vw_buffer_size_bytes(const struct vw_buffer *buffer) { return buffer->size_bytes; }

void *vw_buffer_map(struct vw_buffer *buffer) { return buffer->mapped; }

// ---- Hazards -------------------------------------------------------------------------------------------------------

enum vw_status vw_ranges_find(struct vw_ranges *ranges, uint64_t offset_bytes, uint64_t size_bytes, uint32_t *index) {
    size_t i = 0;
    while (i < ranges->count &&
           (ranges->list[i].offset_bytes != offset_bytes || ranges->list[i].size_bytes != size_bytes))
        i++;
    if (i == ranges->count) {
        enum vw_status status =
            vw_grow((void **)&ranges->list, &ranges->capacity, ranges->count + 1, sizeof *ranges->list);
        if (status) return status;
        ranges->list[ranges->count++] = (struct vw_range){.offset_bytes = offset_bytes, .size_bytes = size_bytes};
    }
    *index = (uint32_t)i;
    return VW_OK;
}

static bool overlap(const struct vw_range *a, const struct vw_range *b) {
    return a->offset_bytes < b->offset_bytes + b->size_bytes && b->offset_bytes < a->offset_bytes + a->size_bytes;
}

uint64_t vw_ranges_earliest(const struct vw_ranges *ranges, uint32_t index, bool writes) {
    uint64_t earliest = 0;
    for (size_t i = 0; i < ranges->count; i++) {
        const struct vw_range *other = &ranges->list[i];
        if (!overlap(&ranges->list[index], other)) continue;
        if (other->write_stage && other->write_stage >= earliest) earliest = other->write_stage + 1;
        if (writes && other->read_stage && other->read_stage >= earliest) earliest = other->read_stage + 1;
    }
    return earliest;
}

void vw_ranges_note(struct vw_ranges *ranges, uint32_t index, bool writes, uint64_t stage) {
    uint64_t *last = writes ? &ranges->list[index].write_stage : &ranges->list[index].read_stage;
    if (stage > *last) *last = stage;
}
