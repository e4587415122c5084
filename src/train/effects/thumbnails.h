// Thumbnails: photos as the encoder of the effect appearance_encoder sees them, 32 x 32 area means.
#ifndef VIEWWORTH_TRAIN_EFFECTS_THUMBNAILS_H
#define VIEWWORTH_TRAIN_EFFECTS_THUMBNAILS_H

#include "interface.h"
#include "train/pixels.h"

struct vw_thumbnail_choice {
    struct vw_pixel_columns columns; // the photo's
    bool masks;                      // mask files are obeyed
};

// Writes THUMBNAIL_PIXELS pixels, rows top to bottom. Each is the mean over an equal part of the columns, parts of
// pixels counted by their area: x, y, z of 2 rgb - 1, w of 1. A pixel that is left out (vw_view_keeps) counts as 0 in
// all four, a transparent one by its alpha. So w is the share that counts, and a photo all masked is all 0.
void vw_thumbnail_make(const struct vw_view *view, const struct vw_thumbnail_choice *choice, vw_float4 *thumbnail);

#endif
