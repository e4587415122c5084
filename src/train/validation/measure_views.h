// Renders of whole views, and measures of how near the field comes to them: the passes of validation, on all their
// usable pixels or an even share of them, through an evaluator of its own. The errors are summed in double on the host,
// in the order of the pixels.
#ifndef VIEWWORTH_TRAIN_VALIDATION_MEASURE_VIEWS_H
#define VIEWWORTH_TRAIN_VALIDATION_MEASURE_VIEWS_H

#include "train/field.h"
#include "train/trainer.h"

struct vw_measured_field { // all borrowed
    struct vw_radiance_field *field;
    const struct vw_scene *scene;
    bool masks;        // mask files are obeyed
    bool fits;         // a gain and a bias are fitted to a view's left half, and its right half is measured
    bool allows_blank; // a view without usable pixels has errors of NaN; else it is a failure
    double *plain_mse; // by view that is measured, its mean squared error without the fit; NULL: not asked for
};

// Measures views as vw_trainer_measure_views() says. The second does as vw_trainer_measure_whole() says.
enum vw_status vw_measure_views(const struct vw_measured_field *measured, const uint32_t *views, uint32_t view_count,
                                uint32_t pixels_max, struct vw_view_error *errors);
enum vw_status vw_measure_whole_view(const struct vw_measured_field *measured, uint32_t view, uint32_t side_px,
                                     struct vw_whole_view *whole);

// ---- Renders ----

struct vw_picture {
    uint32_t view;       // index in the field's scene
    uint32_t size_px[2]; // at most the view's: a smaller picture takes the pixel in the middle of each of its own
    double depth_share;  // > 0: instead of rgb the expected depth along the camera's axis in world units, 0 where the
                         // ray sees no more than this share of anything
    const struct vw_view *posed; // another camera in place of the view's; NULL: its own
};

// Renders pictures of the same size and kind, one after another: floats, rows top to bottom, rgb or a depth per pixel.
// Owned by the caller.
enum vw_status vw_field_render(struct vw_radiance_field *field, const struct vw_picture *pictures, uint32_t count,
                               float **values);

#endif
