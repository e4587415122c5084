// The network of the effect appearance_encoder: its initial values.
#ifndef VIEWWORTH_TRAIN_EFFECTS_ENCODER_NETWORK_H
#define VIEWWORTH_TRAIN_EFFECTS_ENCODER_NETWORK_H

#include "train/fields/initial_values.h"

// `values` is its first number, `width4` the width of the colour network / 4. Codes are 0, so that the field starts as
// it would without them.
void vw_encoder_initialise(uint32_t width4, float *values, const struct vw_drawn *drawn);

#endif
