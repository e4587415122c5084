// The times of a submission's passes, by timestamps.
#ifndef VIEWWORTH_GPU_TIMER_H
#define VIEWWORTH_GPU_TIMER_H

#include "gpu/pass.h"

// A pass by its static texts, since it may be gone when its times are collected.
struct vw_timed_pass {
    const char *name, *role;
};

// Timestamps of one submission: two queries around each dispatch, as many as fit.
struct vw_submission_timer {
    VkQueryPool queries;              // VK_NULL_HANDLE: not timed
    struct vw_timed_pass *dispatches; // the timed ones
    uint32_t count;
};

enum vw_status vw_submission_timer_create(struct vw_gpu *gpu, struct vw_submission_timer *timer);
void vw_submission_timer_destroy(struct vw_gpu *gpu, struct vw_submission_timer *timer);
void vw_submission_timer_reset(struct vw_gpu *gpu, struct vw_submission_timer *timer);
// Returns whether the dispatch is timed, that is, whether _stop must follow.
bool vw_submission_timer_start(struct vw_submission_timer *timer, VkCommandBuffer commands, const struct vw_pass *pass);
void vw_submission_timer_stop(struct vw_submission_timer *timer, VkCommandBuffer commands);
// Adds the times of a finished submission to the device's timers.
enum vw_status vw_submission_timer_collect(struct vw_gpu *gpu, struct vw_submission_timer *timer);

#endif
