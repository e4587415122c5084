// quality: how well a train photo fits. It finds photos with occluders, wrong exposure, noise or a wrong pose, but not
// blur. It does not say what they are worth.
//
// It is the mean of two ranks, each scaled to [0,1] (ties share their mean): that of dv_loss, and that of minus the
// mean training loss over the photo's visits in the last third of the E epochs (rounded up). 1 fits best. Its standard
// error is that of a block bootstrap (Kuensch, "The jackknife and the bootstrap for general stationary observations",
// Annals of Statistics 1989), seeded: 400 times, blocks of neighbouring epochs (E^(1/3) long, at most half of the late
// third; circular) are drawn anew, within the late third and within the epochs before it, for both ranks and all photos
// alike. The variance is divided by the share that such blocks show of it (1 - length of a block / late epochs) and
// raised by half for what all epochs of a run share (as in uncertainty.h). The 95 % interval is that of Student with E
// - 1 degrees of freedom, cut to [0,1]; NaN below four epochs.
//
// train_fit: the same training loss in dB, -10 log10 of the mean. A rank does not tell by how much a photo fits worse
// than the others; this does, and is a photo's own evidence when it is called an outlier (viewworth/selection.h).
#ifndef VIEWWORTH_VALUE_QUALITY_H
#define VIEWWORTH_VALUE_QUALITY_H

#include "viewworth/value.h"

// Appends both scores per train image, in image order; nothing if no train image has both a delta of val_l1 and a late
// training loss. An image without both gets the value 0 with 0 visits, as by the other methods. `scores` must have room
// for 2 image_count more. VW_ERROR_INPUT for a step on an image that is not in `images`, VW_ERROR_MEMORY.
enum vw_status vw_quality_append(const struct vw_value_input *input, struct vw_ledger_score *scores,
                                 uint32_t *score_count);

#endif
