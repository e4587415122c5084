// Whole views of a trained field: their errors and SSIM, and pictures of some of them, photo left and render right.
#ifndef VIEWWORTH_CLI_WHOLE_VIEWS_H
#define VIEWWORTH_CLI_WHOLE_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/step_record.h"
#include "viewworth/train.h"

// Views of which every trial leaves a picture, so that what is recalled has them as well.
struct vw_kept_views {
    const uint32_t *views; // scene indices; borrowed, as is the folder, which must exist
    uint32_t count;        // 0: none are kept
    const char *folder;
};

// The picture of a trial (its id) and a view, owned by the caller; NULL when memory is short.
char *vw_kept_view_path(const struct vw_kept_views *kept, const char *trial_id, uint32_t view);
// Whether a trial has left all of them. False when memory is short, too.
bool vw_kept_views_exist(const struct vw_kept_views *kept, const char *trial_id);

// Measures views, one entry of `errors` and `ssims` for each, and leaves the pictures of those that are kept.
enum vw_status vw_whole_views_measure(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count,
                                      const struct vw_kept_views *kept, const char *trial_id, struct vw_view_error *errors, double *ssims);

#endif
