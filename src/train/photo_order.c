#include "train/photo_order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"

enum {
    STEPS_PER_BATCH_MAX = 1024,
    STEPS_WITHOUT_ROOM_MAX = 64,
    PIXELS_PER_BATCH_MAX = 1 << 20,
};
static const double BATCH_SECONDS =
    0.25; // long enough to hide submission, short enough for a watchdog and a progress bar

// ---- Views ----------------------------------------------------------------------------------------------------------

static enum vw_status copy_views(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                 struct vw_photo_order *schedule) {
    for (uint32_t i = 0; i < count; i++)
        if (views[i] >= scene->view_count || (i > 0 && views[i] <= views[i - 1]))
            return vw_fail(VW_ERROR_USAGE,
                           "train_views[%u] is %u; give indices of the scene's %u views in ascending order", i,
                           views[i], scene->view_count);
    schedule->train_views = vw_allocate(count, sizeof *views);
    if (!schedule->train_views) return VW_ERROR_MEMORY;
    memcpy(schedule->train_views, views, count * sizeof *views);
    schedule->train_count = count;
    return VW_OK;
}

enum vw_status vw_photo_order_create(const struct vw_scene *scene, const uint32_t *views, uint32_t view_count,
                                     const struct vw_config *config, struct vw_photo_order *schedule) {
    *schedule = (struct vw_photo_order){
        .epochs = config->epochs, .order_seed = vw_config_seed_of(config, VW_VARY_ORDER), .ordered_epoch = UINT64_MAX};
    enum vw_status status =
        views ? copy_views(scene, views, view_count, schedule)
              : vw_scene_list_views(scene, VW_SPLIT_TRAIN, &schedule->train_views, &schedule->train_count);
    if (status) return status;
    if (!schedule->train_count)
        return vw_fail(VW_ERROR_INPUT, "%s: no view is left to train on; check the splits", scene->path);
    schedule->order = vw_allocate(schedule->train_count, sizeof *schedule->order);
    return schedule->order ? VW_OK : VW_ERROR_MEMORY;
}

void vw_photo_order_destroy(struct vw_photo_order *schedule) {
    free(schedule->train_views);
    free(schedule->order);
    free(schedule->kept);
    free(schedule->substitutes);
}

// ---- Left out -------------------------------------------------------------------------------------------------------

enum vw_status vw_photo_order_leave_out(const uint32_t *views, uint32_t count, struct vw_photo_order *schedule) {
    uint32_t found = 0;
    if (count == 0) return VW_OK;
    schedule->kept = vw_allocate(schedule->train_count, sizeof *schedule->kept);
    schedule->substitutes = vw_allocate(schedule->train_count, sizeof *schedule->substitutes);
    if (!schedule->kept || !schedule->substitutes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < schedule->train_count; i++)
        if (found < count && schedule->train_views[i] == views[found]) found++;
        else schedule->kept[schedule->kept_count++] = i;
    if (found < count)
        return vw_fail(VW_ERROR_USAGE, "left_out_views[%u] is not trained on; give train_views in ascending order",
                       found);
    if (schedule->kept_count > 0) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "left_out_views has all train views; leave one to train on");
}

static bool is_left_out(const struct vw_photo_order *schedule, uint32_t photo) {
    for (uint32_t low = 0, high = schedule->kept_count; low < high;) {
        uint32_t middle = (low + high) / 2;
        if (schedule->kept[middle] == photo) return false;
        if (schedule->kept[middle] < photo) low = middle + 1;
        else high = middle;
    }
    return true;
}

// Substitutes kept photos for those left out: the kept ones in turn, in an order that is shuffled each time around, so
// that over the training all take over equally many steps.
static void substitute(struct vw_photo_order *schedule, uint64_t epoch) {
    const uint64_t seed = ~schedule->order_seed; // differs from the seed of every epoch's order
    uint64_t turn = epoch * (schedule->train_count - schedule->kept_count), shuffled = UINT64_MAX;
    for (uint32_t i = 0; i < schedule->train_count; i++) {
        if (!is_left_out(schedule, schedule->order[i])) continue;
        uint64_t round = turn / schedule->kept_count;
        if (round != shuffled) vw_random_order(seed, round, schedule->kept_count, schedule->substitutes);
        shuffled = round;
        schedule->order[i] = schedule->kept[schedule->substitutes[turn++ % schedule->kept_count]];
    }
}

// ---- Steps ----------------------------------------------------------------------------------------------------------

uint64_t vw_photo_order_total_steps(const struct vw_photo_order *schedule) {
    return (uint64_t)schedule->epochs * schedule->train_count;
}

uint32_t vw_photo_order_epoch_of_step(const struct vw_photo_order *schedule, uint64_t step) {
    return step > 0 ? (uint32_t)((step - 1) / schedule->train_count) : 0;
}

uint64_t vw_photo_order_epoch_end(const struct vw_photo_order *schedule, uint64_t step) {
    return ((uint64_t)vw_photo_order_epoch_of_step(schedule, step) + 1) * schedule->train_count;
}

uint32_t vw_photo_order_photo_of_step(struct vw_photo_order *schedule, uint64_t step) {
    uint32_t epoch = vw_photo_order_epoch_of_step(schedule, step);
    if (epoch != schedule->ordered_epoch) {
        vw_random_order(schedule->order_seed, epoch, schedule->train_count, schedule->order);
        if (schedule->kept) substitute(schedule, epoch);
    }
    schedule->ordered_epoch = epoch;
    return schedule->order[(step - 1) % schedule->train_count];
}

uint32_t vw_photo_order_view_of_step(struct vw_photo_order *schedule, uint64_t step) {
    return schedule->train_views[vw_photo_order_photo_of_step(schedule, step)];
}

// ---- Batches --------------------------------------------------------------------------------------------------------

static uint64_t at_most(uint64_t count, uint64_t most) { return count < most ? count : most; }

void vw_photo_order_set_batches(struct vw_photo_order *schedule, const struct vw_batch_room *room,
                                uint32_t steps_per_batch) {
    uint64_t most = room->batch_bytes / room->bytes_per_step;
    if (most < STEPS_WITHOUT_ROOM_MAX) most = STEPS_WITHOUT_ROOM_MAX;
    most = at_most(at_most(most, STEPS_PER_BATCH_MAX), PIXELS_PER_BATCH_MAX / room->pixels_per_step);
    schedule->batch_steps_max = (uint32_t)most;
    schedule->step_s = INFINITY;
    schedule->adapts = steps_per_batch == 0;
    schedule->batch_steps = steps_per_batch == 0 ? 1 : steps_per_batch;
    if (schedule->batch_steps > schedule->batch_steps_max) schedule->batch_steps = schedule->batch_steps_max;
}

// Adapts the number of steps in a batch. How steps are grouped changes no bit of them. The least time of a step counts:
// the reader of the records may have been busy, with a slow disk for example, before this batch was asked for.
void vw_photo_order_adapt_batches(struct vw_photo_order *schedule, uint32_t step_count, double seconds) {
    if (!schedule->adapts || step_count < schedule->batch_steps) return;
    schedule->step_s = fmin(schedule->step_s, seconds / step_count);
    uint32_t doubled = schedule->batch_steps * 2;
    if (schedule->step_s * step_count < BATCH_SECONDS && doubled <= schedule->batch_steps_max)
        schedule->batch_steps = doubled;
}
