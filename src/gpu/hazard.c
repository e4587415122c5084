#include "gpu/hazard.h"

#include "base/memory.h"

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
