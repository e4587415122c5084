// The network of the effect `visibility`: its params and what it sees of photos.
#ifndef VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_NETWORK_H
#define VIEWWORTH_TRAIN_EFFECTS_VISIBILITY_NETWORK_H

#include "gpu/compute.h"
#include "interface.h"
#include "train/fields/initial_values.h"
#include "viewworth/scene.h"

// Trainable numbers of the network, and of one photo's code.
enum { VISIBILITY_NETWORK_PARAMS = 913, VISIBILITY_CODE_PARAMS = 4 * VISIBILITY_CODE4 };

// Initial values of the network: `values` is its first number; all is visible to 1/2.
void vw_visibility_initialise(float *values, const struct vw_drawn *drawn);

// Scales from pixels to the network's coordinates, vec2 per view.
enum vw_status vw_visibility_create_scales(struct vw_gpu *gpu, const struct vw_scene *scene, struct vw_buffer **scales);

#endif
