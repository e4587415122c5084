#include "train/training_pool.h"

#include "base/clock.h"

struct work {
    const struct vw_training_pool *pool;
    struct vw_pool_seat seats[VW_POOL_SEATS_MAX];
    uint32_t seat_count, busy, next;      // next: the training that begins next
    double counted_wall_s, counted_cpu_s; // shared out among the seats
    struct vw_first_failure failure;
};

static void share_time(struct work *work) {
    double wall_s = vw_now_s(), cpu_s = vw_cpu_s();
    for (uint32_t i = 0; i < work->seat_count; i++) {
        struct vw_pool_seat *seat = &work->seats[i];
        if (!seat->taken) continue;
        seat->wall_s += (wall_s - work->counted_wall_s) / work->busy;
        seat->cpu_s += (cpu_s - work->counted_cpu_s) / work->busy;
    }
    work->counted_wall_s = wall_s;
    work->counted_cpu_s = cpu_s;
}

static uint64_t used_bytes(const struct vw_training_device *device) {
    return vw_submissions_unshared_bytes(device->submissions, device->gpu);
}

// Sets how many trainings there are at a time, once the first one shows how much memory each takes.
static void set_seats(struct work *work, uint64_t bytes_each) {
    const struct vw_training_pool *pool = work->pool;
    uint32_t together =
        pool->together ? pool->together : vw_trainers_together(vw_gpu_get_info(pool->devices->gpu), bytes_each);
    uint32_t seats = together * pool->device_count;
    work->seat_count = seats < VW_POOL_SEATS_MAX ? seats : VW_POOL_SEATS_MAX;
}

static enum vw_pool_answer begin(struct work *work) {
    const struct vw_training_pool *pool = work->pool;
    enum vw_pool_answer answer = VW_POOL_SEATED;
    uint32_t free = 0;
    while (work->seats[free].taken) free++;
    struct vw_pool_seat *seat = &work->seats[free];
    *seat = (struct vw_pool_seat){.place = work->next, .device = free % pool->device_count};
    uint64_t before = used_bytes(pool->devices);
    enum vw_status status = pool->begin(pool->context, seat, &answer);
    share_time(work);
    vw_first_failure_note(&work->failure, status);
    seat->taken = !status && answer == VW_POOL_SEATED;
    work->busy += seat->taken;
    if (seat->taken && !work->seat_count) set_seats(work, used_bytes(pool->devices) - before);
    return answer;
}

static void begin_some(struct work *work, uint32_t count) {
    bool waits = false;
    while (!waits && !work->failure.status && work->next < count && (!work->busy || work->busy < work->seat_count)) {
        waits = begin(work) == VW_POOL_WAITS;
        work->next += !waits;
    }
}

static void take_turns(struct work *work) {
    const struct vw_training_pool *pool = work->pool;
    for (uint32_t i = 0; i < work->seat_count; i++) {
        struct vw_pool_seat *seat = &work->seats[i];
        bool ended = false;
        if (!seat->taken) continue;
        enum vw_status status = pool->advance(pool->context, seat, &ended);
        share_time(work);
        if (!status && !ended) continue;
        seat->taken = false;
        work->busy--;
        vw_first_failure_note(&work->failure, pool->end(pool->context, seat, status));
    }
}

enum vw_status vw_training_pool_run(const struct vw_training_pool *pool, uint32_t count) {
    struct work work = {.pool = pool, .counted_wall_s = vw_now_s(), .counted_cpu_s = vw_cpu_s()};
    do {
        begin_some(&work, count);
        take_turns(&work);
    } while (work.busy > 0 || (!work.failure.status && work.next < count));
    return vw_first_failure_report(&work.failure);
}
