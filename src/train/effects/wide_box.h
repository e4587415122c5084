// The effect `wide_box`: a box around the scene's own that contains nearly all that photos see. The scene's box leaves
// out the farthest points, which gives near content more of the field.
#ifndef VIEWWORTH_TRAIN_EFFECTS_WIDE_BOX_H
#define VIEWWORTH_TRAIN_EFFECTS_WIDE_BOX_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// Computes the cube with the centre of the scene's box that contains 99 % of the observations of points, plus a tenth.
// It is at least as large as the scene's box and at most four times as large. It is twice as large for a scene with few
// points. It depends on the scene's box and points alone.
enum vw_status wide_box(const struct vw_scene *scene, struct vw_box *box);

#endif
