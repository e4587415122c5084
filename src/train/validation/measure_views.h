// Renders of whole views, and measures of how near the field comes to them: the passes of validation, on all their
// usable pixels or an even share of them, through an evaluator of its own. The errors are summed in double on the host,
// in the order of the pixels.
#ifndef VIEWWORTH_TRAIN_VALIDATION_MEASURE_VIEWS_H
#define VIEWWORTH_TRAIN_VALIDATION_MEASURE_VIEWS_H

#include "train/field.h"
#include "train/trainer.h"

struct vw_measured_field { // all borrowed
    struct vw_radiance_field *field;
    const struct vw_scene *scene; // the field's, or, for whole views, the same at another size
    bool masks;                   // mask files are obeyed
    bool fits;                    // a gain and a bias are fitted to a view's left half, and its right half is measured
    bool allows_blank;            // a view without usable pixels has errors of NaN; else it is a failure
    double *plain_mse; // by view that is measured, its mean squared error without the fit; NULL: not asked for
};

// Measures views as vw_trainer_measure_views() says. The second does as vw_trainer_measure_whole() says.
enum vw_status vw_measure_views(const struct vw_measured_field *measured, const uint32_t *views, uint32_t view_count,
                                uint32_t pixels_max, struct vw_view_error *errors);
enum vw_status vw_measure_whole_view(const struct vw_measured_field *measured, uint32_t view,
                                     struct vw_whole_view *whole);

// ---- The code of a photo that nothing was trained on ----

// The code of a photo that nothing was trained on (effect `appearance_code`), fitted to pixels of its left half: the
// protocol of NeRF-W (Martin-Brualla et al., CVPR 2021, section 4.1) for final figures. Where NeRF-W takes gradient
// steps, these are Gauss-Newton steps (Levenberg 1944, Marquardt 1963) on what is rendered, with the ridge that codes
// have in training; the Jacobian is taken by differences of renders. Validation during a run takes the code 0.
enum { CODE_FIT_RAYS_MAX = 256 };

struct vw_code_fit { // all zero for a field without codes
    float *weights;  // columns of the colour network as they were, from the first one that a code shifts; owned
};

// Fits to `count` <= CODE_FIT_RAYS_MAX pixels. From then on the field renders with the code: its params are those of
// the code 0, with the code's share added to the weights of the constant input. Does nothing for a field without codes.
// After a failure the params are as before.
enum vw_status vw_code_fit_apply(struct vw_radiance_field *field, const struct vw_pixel *pixels, uint32_t count,
                                 struct vw_code_fit *fit);
// Puts the params back, bit for bit, and frees the fit.
enum vw_status vw_code_fit_undo(struct vw_radiance_field *field, struct vw_code_fit *fit);

#endif
