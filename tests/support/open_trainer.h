// Creating a trainer in a test that says nothing of effects.
#ifndef VIEWWORTH_TESTS_SUPPORT_OPEN_TRAINER_H
#define VIEWWORTH_TESTS_SUPPORT_OPEN_TRAINER_H

#include "train/trainer.h"

// Decides the effects by config->effects and the scene alone, without a pilot run, unless `params` has some.
enum vw_status test_trainer_open(struct vw_trainer_params params, struct vw_trainer **trainer);

#endif
