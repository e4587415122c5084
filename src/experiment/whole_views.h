// Whole views of a trained field: their errors and SSIM, and pictures of some of them, with the photo left and the
// render right.
#ifndef VIEWWORTH_EXPERIMENT_WHOLE_VIEWS_H
#define VIEWWORTH_EXPERIMENT_WHOLE_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "train/trainer.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

// Views of which the retrainings with a seed save a picture.
struct vw_saved_views {
    const uint32_t *views; // scene indices; borrowed, as is the folder, which must exist
    uint32_t count;        // 0: none
    const char *folder;
    uint64_t seed;
};

// Returns the path of the picture of a retraining (its id) and a view, owned by the caller; NULL when memory is short.
char *vw_saved_view_path(const struct vw_saved_views *saved, const char *retraining_id, uint32_t view);
// Returns whether all pictures of a retraining are there, as files and not as links. Also false when memory is short.
bool vw_saved_views_exist(const struct vw_saved_views *saved, const char *retraining_id);

// Measures views, one entry of `errors` and `ssims` for each, and saves the pictures of those in `saved`.
enum vw_status vw_whole_views_measure(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count,
                                      const struct vw_saved_views *saved, const char *retraining_id,
                                      struct vw_view_error *errors, double *ssims);

// Writes to `to` the photo of the first of some saved pictures of one view, then the render of each. VW_ERROR_INPUT
// when a picture is of another size, or cannot be read.
enum vw_status vw_side_by_side_write(const char *to, char *const *pictures, uint32_t count);

#endif
