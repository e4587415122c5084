// The network of the effect `uncertainty` (uncertainty.c).
#ifndef VIEWWORTH_TRAIN_EFFECTS_UNCERTAINTY_H
#define VIEWWORTH_TRAIN_EFFECTS_UNCERTAINTY_H

#include "train/model.h"

// Returns its range of the params, empty without the effect.
struct vw_param_range vw_uncertainty_network(const struct vw_model *model);

#endif
