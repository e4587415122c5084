#include "gpu/timer.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum { TIMED_DISPATCHES = 2048 }; // per submission; later ones are dropped

enum vw_status vw_submission_timer_create(struct vw_gpu *gpu, struct vw_submission_timer *timer) {
    if (!gpu->timers_wanted) return VW_OK;
    timer->dispatches = vw_allocate(TIMED_DISPATCHES, sizeof *timer->dispatches);
    if (!timer->dispatches) return VW_ERROR_MEMORY;
    const VkQueryPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                        .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                        .queryCount = 2 * TIMED_DISPATCHES};
    VkResult result = vkCreateQueryPool(gpu->device, &info, NULL, &timer->queries);
    return result ? vw_gpu_fail(result, "vkCreateQueryPool", "timers") : VW_OK;
}

void vw_submission_timer_destroy(struct vw_gpu *gpu, struct vw_submission_timer *timer) {
    vkDestroyQueryPool(gpu->device, timer->queries, NULL);
    free(timer->dispatches);
}

void vw_submission_timer_reset(struct vw_gpu *gpu, struct vw_submission_timer *timer) {
    timer->count = 0;
    if (timer->queries) vkResetQueryPool(gpu->device, timer->queries, 0, 2 * TIMED_DISPATCHES);
}

bool vw_submission_timer_start(struct vw_submission_timer *timer, VkCommandBuffer commands,
                               const struct vw_pass *pass) {
    if (!timer->queries || timer->count == TIMED_DISPATCHES) return false;
    timer->dispatches[timer->count] = (struct vw_timed_pass){pass->name, pass->role};
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timer->queries, 2 * timer->count);
    return true;
}

void vw_submission_timer_stop(struct vw_submission_timer *timer, VkCommandBuffer commands) {
    vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, timer->queries, 2 * timer->count + 1);
    timer->count++;
}

static bool same_text(const char *a, const char *b) { return a && b ? !strcmp(a, b) : a == b; }

// Returns the device's timer of that pass, made at first use; NULL when memory is short.
static struct vw_gpu_timer *find_timer(struct vw_gpu *gpu, const struct vw_timed_pass *pass) {
    for (size_t i = 0; i < gpu->timer_count; i++)
        if (!strcmp(gpu->timers[i].name, pass->name) && same_text(gpu->timers[i].role, pass->role))
            return &gpu->timers[i];
    void *timers = gpu->timers;
    if (vw_grow(&timers, &gpu->timer_capacity, gpu->timer_count + 1, sizeof *gpu->timers)) return NULL;
    gpu->timers = timers;
    gpu->timers[gpu->timer_count].name = pass->name;
    gpu->timers[gpu->timer_count].role = pass->role;
    return &gpu->timers[gpu->timer_count++];
}

enum vw_status vw_submission_timer_collect(struct vw_gpu *gpu, struct vw_submission_timer *timer) {
    const uint64_t mask =
        gpu->chosen.timestamp_bits < 64 ? ((uint64_t)1 << gpu->chosen.timestamp_bits) - 1 : UINT64_MAX;
    for (uint32_t i = 0; i < timer->count; i++) {
        uint64_t ticks[2];
        VkResult result = vkGetQueryPoolResults(gpu->device, timer->queries, 2 * i, 2, sizeof ticks, ticks,
                                                sizeof ticks[0], VK_QUERY_RESULT_64_BIT);
        if (result == VK_NOT_READY) continue;
        if (result) return vw_gpu_fail(result, "vkGetQueryPoolResults", timer->dispatches[i].name);
        struct vw_gpu_timer *total = find_timer(gpu, &timer->dispatches[i]);
        if (!total) return VW_ERROR_MEMORY;
        total->dispatches++;
        total->total_ms += (double)((ticks[1] - ticks[0]) & mask) * gpu->chosen.timestamp_ns * 1e-6;
    }
    timer->count = 0;
    return VW_OK;
}

const struct vw_gpu_timer *vw_gpu_timers(const struct vw_gpu *gpu, uint32_t *count) {
    *count = (uint32_t)gpu->timer_count;
    return gpu->timers;
}
