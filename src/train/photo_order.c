#include "train/photo_order.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"

enum {
    STEPS_PER_SUBMISSION_MAX = 1024,
    STEPS_WITHOUT_ROOM_MAX = 64,
    PIXELS_PER_SUBMISSION_MAX = 1 << 20,
};
static const double SUBMISSION_SECONDS =
    0.25; // long enough to hide submission, short enough for a watchdog and a progress bar

// ---- Views ----------------------------------------------------------------------------------------------------------

static enum vw_status copy_views(const struct vw_scene *scene, const uint32_t *views, uint32_t count,
                                 struct vw_photo_order *photo_order) {
    for (uint32_t i = 0; i < count; i++)
        if (views[i] >= scene->view_count || (i > 0 && views[i] <= views[i - 1]))
            return vw_fail(VW_ERROR_USAGE,
                           "train_views[%u] is %u; give indices of the scene's %u views in ascending order", i,
                           views[i], scene->view_count);
    photo_order->train_views = vw_allocate(count, sizeof *views);
    if (!photo_order->train_views) return VW_ERROR_MEMORY;
    memcpy(photo_order->train_views, views, count * sizeof *views);
    photo_order->train_count = count;
    return VW_OK;
}

enum vw_status vw_photo_order_create(const struct vw_scene *scene, const uint32_t *views, uint32_t view_count,
                                     const struct vw_config *config, struct vw_photo_order *photo_order) {
    *photo_order = (struct vw_photo_order){
        .epochs = config->epochs, .order_seed = vw_config_seed_of(config, VW_VARY_ORDER), .ordered_epoch = UINT64_MAX};
    enum vw_status status =
        views ? copy_views(scene, views, view_count, photo_order)
              : vw_scene_list_views(scene, VW_SPLIT_TRAIN, &photo_order->train_views, &photo_order->train_count);
    if (status) return status;
    if (!photo_order->train_count)
        return vw_fail(VW_ERROR_INPUT, "%s: no view is left to train on; check the splits", scene->path);
    photo_order->order = vw_allocate(photo_order->train_count, sizeof *photo_order->order);
    return photo_order->order ? VW_OK : VW_ERROR_MEMORY;
}

void vw_photo_order_destroy(struct vw_photo_order *photo_order) {
    free(photo_order->train_views);
    free(photo_order->order);
    free(photo_order->kept);
    free(photo_order->substitutes);
}

// ---- Left out -------------------------------------------------------------------------------------------------------

enum vw_status vw_photo_order_leave_out(const uint32_t *views, uint32_t count, struct vw_photo_order *photo_order) {
    uint32_t found = 0;
    if (count == 0) return VW_OK;
    photo_order->kept = vw_allocate(photo_order->train_count, sizeof *photo_order->kept);
    photo_order->substitutes = vw_allocate(photo_order->train_count, sizeof *photo_order->substitutes);
    if (!photo_order->kept || !photo_order->substitutes) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < photo_order->train_count; i++)
        if (found < count && photo_order->train_views[i] == views[found]) found++;
        else photo_order->kept[photo_order->kept_count++] = i;
    if (found < count)
        return vw_fail(VW_ERROR_USAGE, "left_out_views[%u] is not trained on; give train_views in ascending order",
                       found);
    if (photo_order->kept_count > 0) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "left_out_views has all train views; leave one to train on");
}

static bool is_left_out(const struct vw_photo_order *photo_order, uint32_t photo) {
    for (uint32_t low = 0, high = photo_order->kept_count; low < high;) {
        uint32_t middle = (low + high) / 2;
        if (photo_order->kept[middle] == photo) return false;
        if (photo_order->kept[middle] < photo) low = middle + 1;
        else high = middle;
    }
    return true;
}

// Substitutes kept photos for those left out: the kept ones in turn, in an order that is shuffled each time around, so
// that over the training all take over equally many steps.
static void substitute(struct vw_photo_order *photo_order, uint64_t epoch) {
    const uint64_t seed = ~photo_order->order_seed; // differs from the seed of every epoch's order
    uint64_t turn = epoch * (photo_order->train_count - photo_order->kept_count), shuffled = UINT64_MAX;
    for (uint32_t i = 0; i < photo_order->train_count; i++) {
        if (!is_left_out(photo_order, photo_order->order[i])) continue;
        uint64_t round = turn / photo_order->kept_count;
        if (round != shuffled) vw_random_order(seed, round, photo_order->kept_count, photo_order->substitutes);
        shuffled = round;
        photo_order->order[i] = photo_order->kept[photo_order->substitutes[turn++ % photo_order->kept_count]];
    }
}

// ---- Steps ----------------------------------------------------------------------------------------------------------

uint64_t vw_photo_order_total_steps(const struct vw_photo_order *photo_order) {
    return (uint64_t)photo_order->epochs * photo_order->train_count;
}

uint32_t vw_photo_order_epoch_of_step(const struct vw_photo_order *photo_order, uint64_t step) {
    return step > 0 ? (uint32_t)((step - 1) / photo_order->train_count) : 0;
}

uint64_t vw_photo_order_epoch_end(const struct vw_photo_order *photo_order, uint64_t step) {
    return ((uint64_t)vw_photo_order_epoch_of_step(photo_order, step) + 1) * photo_order->train_count;
}

uint32_t vw_photo_order_photo_of_step(struct vw_photo_order *photo_order, uint64_t step) {
    uint32_t epoch = vw_photo_order_epoch_of_step(photo_order, step);
    if (epoch != photo_order->ordered_epoch) {
        vw_random_order(photo_order->order_seed, epoch, photo_order->train_count, photo_order->order);
        if (photo_order->kept) substitute(photo_order, epoch);
    }
    photo_order->ordered_epoch = epoch;
    return photo_order->order[(step - 1) % photo_order->train_count];
}

uint32_t vw_photo_order_view_of_step(struct vw_photo_order *photo_order, uint64_t step) {
    return photo_order->train_views[vw_photo_order_photo_of_step(photo_order, step)];
}

// ---- Submissions ----------------------------------------------------------------------------------------------------

static uint64_t at_most(uint64_t count, uint64_t most) { return count < most ? count : most; }

void vw_photo_order_set_submissions(struct vw_photo_order *photo_order, const struct vw_submission_room *room,
                                    uint32_t steps_per_submission) {
    uint64_t most = room->submission_bytes / room->bytes_per_step;
    if (most < STEPS_WITHOUT_ROOM_MAX) most = STEPS_WITHOUT_ROOM_MAX;
    most = at_most(at_most(most, STEPS_PER_SUBMISSION_MAX), PIXELS_PER_SUBMISSION_MAX / room->pixels_per_step);
    photo_order->submission_steps_max = (uint32_t)most;
    photo_order->step_s = INFINITY;
    photo_order->adapts = steps_per_submission == 0;
    photo_order->submission_steps = steps_per_submission == 0 ? 1 : steps_per_submission;
    if (photo_order->submission_steps > photo_order->submission_steps_max)
        photo_order->submission_steps = photo_order->submission_steps_max;
}

// Adapts the number of steps in a submission. How steps are grouped changes no bit of them. The least time of a step
// counts: the reader of the records may have been busy, with a slow disk for example, before this submission was asked
// for.
void vw_photo_order_adapt_submissions(struct vw_photo_order *photo_order, uint32_t step_count, double seconds) {
    if (!photo_order->adapts || step_count < photo_order->submission_steps) return;
    photo_order->step_s = fmin(photo_order->step_s, seconds / step_count);
    uint32_t doubled = photo_order->submission_steps * 2;
    if (photo_order->step_s * step_count < SUBMISSION_SECONDS && doubled <= photo_order->submission_steps_max)
        photo_order->submission_steps = doubled;
}
