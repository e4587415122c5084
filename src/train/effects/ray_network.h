// The networks of the effects `visibility` and `uncertainty` (ray_network.c).
#ifndef VIEWWORTH_TRAIN_EFFECTS_RAY_NETWORK_H
#define VIEWWORTH_TRAIN_EFFECTS_RAY_NETWORK_H

#include "train/model.h"

// Returns the range of params of the effect's network, empty without the effect.
struct vw_param_range vw_visibility_network(const struct vw_model *model);
struct vw_param_range vw_uncertainty_network(const struct vw_model *model);

#endif
