// The order of photos in a training: how many steps it has, which photo each step takes, and how many steps a
// submission contains. Steps count from 1; step 0 is the untrained field.
#ifndef VIEWWORTH_TRAIN_PHOTO_ORDER_H
#define VIEWWORTH_TRAIN_PHOTO_ORDER_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_photo_order {
    uint32_t *train_views, train_count; // owned; scene indices, ascending
    uint32_t *kept, kept_count;         // owned; indices in train_views of those that are not left out
    uint32_t *substitutes;              // owned; the kept ones in the order in which they take over steps
    uint32_t epochs;
    uint64_t order_seed;
    uint32_t *order; // owned; of the epoch `ordered_epoch`: indices in train_views
    uint64_t ordered_epoch;
    uint32_t submission_steps_max,
        submission_steps; // the most steps a submission may have, and how many the next one has
    bool adapts;          // submission_steps grows until a submission takes long enough
    double step_s;        // the least time that a step of a submission took; INFINITY: unknown
};

// Creates the order on `views` (scene indices, ascending), or on the scene's split train when it is NULL.
// VW_ERROR_USAGE when the list is wrong, VW_ERROR_INPUT when there is no view.
enum vw_status vw_photo_order_create(const struct vw_scene *scene, const uint32_t *views, uint32_t view_count,
                                     const struct vw_config *config, struct vw_photo_order *photo_order);
void vw_photo_order_destroy(struct vw_photo_order *photo_order);

// Leaves out some of the train views (scene indices, ascending): their steps are taken on the others, in turn. Before
// the first step is asked for. VW_ERROR_USAGE when a view is not trained on or none is left.
enum vw_status vw_photo_order_leave_out(const uint32_t *views, uint32_t count, struct vw_photo_order *photo_order);

uint64_t vw_photo_order_total_steps(const struct vw_photo_order *photo_order);
uint32_t vw_photo_order_epoch_of_step(const struct vw_photo_order *photo_order, uint64_t step); // 0 for step 0
uint64_t vw_photo_order_epoch_end(const struct vw_photo_order *photo_order,
                                  uint64_t step); // the last step of the step's epoch
// Returns the photo of a step (from 1), by the epoch's shuffled order: its index in train_views, and in the scene.
uint32_t vw_photo_order_photo_of_step(struct vw_photo_order *photo_order, uint64_t step);
uint32_t vw_photo_order_view_of_step(struct vw_photo_order *photo_order, uint64_t step);

// The bytes that a step exchanges with the device, and how many a submission may have.
struct vw_submission_room {
    uint32_t pixels_per_step;
    uint64_t bytes_per_step, submission_bytes;
};
// Sets the size of submissions: `steps_per_submission`, or (0) one that adapts to the time that steps take. A
// submission has up to 1,024 steps if there is room for them, else up to 64, and never more than 2^20 pixels.
void vw_photo_order_set_submissions(struct vw_photo_order *photo_order, const struct vw_submission_room *room,
                                    uint32_t steps_per_submission);
// Takes into account that a submission of `step_count` steps took that long.
void vw_photo_order_adapt_submissions(struct vw_photo_order *photo_order, uint32_t step_count, double seconds);

#endif
