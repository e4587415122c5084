// The network of the effect `visibility` (visibility.c).
#ifndef VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H
#define VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_H

#include "train/model.h"

// Returns its range of the params, empty without the effect.
struct vw_param_range vw_visibility_network(const struct vw_model *model);

#endif
