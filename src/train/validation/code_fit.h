// The code of a photo that nothing was trained on (effect `appearance_code`), fitted to pixels of its left half: the
// protocol of NeRF-W (Martin-Brualla et al., CVPR 2021, section 4.1) for final figures. Where NeRF-W takes gradient
// steps, these are Gauss-Newton steps (Levenberg 1944, Marquardt 1963) on what is rendered, with the ridge that codes
// have in training; the Jacobian is taken by differences of renders. Validation during a run takes the code 0.
#ifndef VIEWWORTH_TRAIN_VALIDATION_CODE_FIT_H
#define VIEWWORTH_TRAIN_VALIDATION_CODE_FIT_H

#include "train/field.h"

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
