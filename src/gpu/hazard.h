// The commands of a submission that may run side by side. A *stage* is the work between two full barriers. Buffers
// remember, by the ranges that are bound or copied, the last stages that read and wrote them. A command belongs into
// the earliest stage that its ranges allow, also before commands that were recorded earlier. All work runs on one
// queue, where any barrier drains the device in practice, so a full barrier between stages serves every buffer at once.
#ifndef VIEWWORTH_GPU_HAZARD_H
#define VIEWWORTH_GPU_HAZARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "gpu/compute.h"

struct vw_range {
    uint64_t offset_bytes, size_bytes;
    uint64_t read_stage, write_stage; // the last ones; 0: never
};

struct vw_ranges {
    struct vw_range *list; // owned
    size_t count, capacity;
};

// Finds the index of a range, which is added when it is new. VW_ERROR_MEMORY.
enum vw_status vw_ranges_find(struct vw_ranges *ranges, uint64_t offset_bytes, uint64_t size_bytes, uint32_t *index);
// Returns the earliest stage in which the range may be read or written: after every overlapping write, and, if it is
// written, after every read of it. 0: any.
uint64_t vw_ranges_earliest(const struct vw_ranges *ranges, uint32_t index, bool writes);
void vw_ranges_note(struct vw_ranges *ranges, uint32_t index, bool writes, uint64_t stage);

// Returns how many commands the submission recorded.
uint32_t vw_submission_commands(const struct vw_submission *submission);
// Returns how many barriers are between them; the one that ends the submission does not count.
uint32_t vw_submission_barriers(const struct vw_submission *submission);

#endif
