// The inside of struct consistency: for consistency.c and its tests.
#ifndef VIEWWORTH_TRAIN_CONSISTENCY_PRIVATE_H
#define VIEWWORTH_TRAIN_CONSISTENCY_PRIVATE_H

#include "train/step.h"

struct consistency {
    uint32_t side, ray_count, padded_rays; // the picture's, and its rays
    struct vw_push_codes codes;
    struct vw_buffer *rays, *ray_loss, *colours, *d_sky, *d_weights;
    struct appearance_encoder seen; // of the picture: one thumbnail, and so on
    struct encoder_gradient seen_gradient;
    struct encoder_passes give, see; // the given photo's code; the picture's
    struct gradient_passes gradient;
    struct vw_pass *composite, *shrink, *spread_colours, *add;
};

#endif
