// Views on which a trained field is measured: an even share of their pixels, or whole views with SSIM, of some of which
// a picture is saved, with the photo left and the render right.
#ifndef VIEWWORTH_EXPERIMENT_MEASURED_VIEWS_H
#define VIEWWORTH_EXPERIMENT_MEASURED_VIEWS_H

#include <stdbool.h>
#include <stdint.h>

#include "ledger/retraining.h"
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

// Without whole views, at most VW_PIXELS_OF_SPLIT pixels of a split are measured, the same number in every view, but at
// least 1,024 in each.
enum { VW_PIXELS_OF_SPLIT = 1 << 13 };

struct vw_measured_views {
    uint32_t *views, count; // owned, as the others; scene indices: all validation and test photos, then the train
                            // photos of which the retraining asks for PSNR
    struct vw_view_error *errors;
    double *ssims; // NaN of a view that has none
};

// Measures the views for a retraining, and averages over the splits into `result`. `saved` is NULL, or: whole views are
// measured, and these pictures saved. Free `*measured` also after a failure.
enum vw_status vw_measured_views_make(struct vw_trainer *trainer, const struct vw_scene *scene,
                                      const struct vw_retrain_params *retraining, const struct vw_saved_views *saved,
                                      const char *retraining_id, struct vw_measured_views *measured,
                                      struct vw_retrain_result *result);
void vw_measured_views_free(struct vw_measured_views *measured);

// Writes to `to` the photo of the first of some saved pictures of one view, then the render of each. VW_ERROR_INPUT
// when a picture is of another size, or cannot be read.
enum vw_status vw_side_by_side_write(const char *to, char *const *pictures, uint32_t count);

#endif
