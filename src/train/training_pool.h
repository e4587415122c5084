// A pool of trainings: as many at a time as its devices take. Each has a seat on a device; the seats take one
// submission of steps in turn, so that trainings on one device share submissions, and the next training gets the seat
// of one that has ended. Results are bit-identical to those of trainings one by one.
#ifndef VIEWWORTH_TRAIN_TRAINING_POOL_H
#define VIEWWORTH_TRAIN_TRAINING_POOL_H

#include <stdbool.h>
#include <stdint.h>

#include "train/shared_submissions.h"
#include "viewworth/gpu.h"
#include "viewworth/status.h"

enum { VW_POOL_DEVICES_MAX = 16, VW_POOL_SEATS_MAX = VW_POOL_DEVICES_MAX * VW_TRAINERS_TOGETHER_MAX };

struct vw_training_device {
    struct vw_gpu *gpu;
    struct vw_submissions *submissions; // shared by all trainings on the device
};

struct vw_pool_seat {
    uint32_t place;       // the number of the training
    uint32_t device;      // index of its device
    double wall_s, cpu_s; // its share of the time so far; for display only
    bool taken;
};

enum vw_pool_answer {
    VW_POOL_SEATED,  // the training takes steps
    VW_POOL_NO_SEAT, // there is nothing to train
    VW_POOL_WAITS,   // for the end of a training that has a seat
};

struct vw_training_pool {
    const struct vw_training_device *devices; // open
    uint32_t device_count;
    uint32_t together; // trainings on each device; 0: as many as it suggests, by the memory that the first one takes
    // Begins the training seat->place on seat->device; `*answer` is VW_POOL_SEATED. A failure leaves nothing open.
    enum vw_status (*begin)(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer);
    enum vw_status (*advance)(void *context, const struct vw_pool_seat *seat, bool *ended);
    // Closes a training that has ended, or failed with `status`. What it returns counts.
    enum vw_status (*end)(void *context, const struct vw_pool_seat *seat, enum vw_status status);
    void *context;
};

// Makes the trainings 0 ... count - 1, which begin in this order. After a failure no other begins, but those that have
// a seat go on to their end. Returns the first failure.
enum vw_status vw_training_pool_run(const struct vw_training_pool *pool, uint32_t count);

#endif
