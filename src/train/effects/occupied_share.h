// How much of the box a trained field fills.
#ifndef VIEWWORTH_TRAIN_OCCUPIED_SHARE_H
#define VIEWWORTH_TRAIN_OCCUPIED_SHARE_H

#include "viewworth/status.h"
#include "train/trainer.h"
#include "viewworth/train.h"

// The share of the cells of a lattice of `samples`^3 (of the config) over the box whose middle has a density worth
// sampling: one that makes a sample of a ray across the box at least 1 % opaque. With nothing in flight.
enum vw_status occupied_share(struct vw_trainer *trainer, double *share);

#endif
