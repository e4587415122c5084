// The effect registry: optional parts of image formation, each with its evidence and its specialization constant
// (decision 7).
#ifndef VIEWWORTH_TRAIN_EFFECTS_H
#define VIEWWORTH_TRAIN_EFFECTS_H

#include "viewworth/scene.h"
#include "viewworth/train.h"
#include "interface.h"

// Sets the specialization constants of the effects that are on, in registry order.
void effects_specialize(const struct vw_effect_verdict *verdicts, const struct vw_scene *scene,
                        struct vw_specialization *specialization);

#endif
