// When a barrier is due. An *epoch* is the segment of commands between two full barriers of one batch; every buffer
// remembers the last epochs that read and wrote it. All work runs on one queue, where any barrier drains the device in
// practice, so one full barrier that starts a new epoch serves every buffer at once.
#ifndef VIEWWORTH_GPU_HAZARD_H
#define VIEWWORTH_GPU_HAZARD_H

#include <stdbool.h>
#include <stdint.h>

#include "gpu/compute.h"

struct vw_batch;

struct vw_last_access {
    uint64_t read_epoch; // 0: never
    uint64_t write_epoch;
};

// Whether an access in `epoch` must wait: anything after a write, or a write after a read.
static inline bool vw_hazard(struct vw_last_access last, uint64_t epoch, bool writes) {
    return last.write_epoch == epoch || (writes && last.read_epoch == epoch);
}

// Barriers that recording has put between commands since vw_batch_begin (not the one that ends the batch).
uint32_t vw_batch_barriers(const struct vw_batch *batch);

#endif
