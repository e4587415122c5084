// The boxes that effects choose for the field. `unbounded`: the inner region that its contraction leaves unchanged, and
// the range of depths in which rays are sampled. `wide_box`: a box around the scene's own that contains nearly all that
// photos see; the scene's box leaves out the farthest points, which gives near content more of the field.
#ifndef VIEWWORTH_TRAIN_EFFECTS_FIELD_BOX_H
#define VIEWWORTH_TRAIN_EFFECTS_FIELD_BOX_H

#include "interface.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Computes the box whose inscribed ball is the inner region: around the cameras and the nearer half of the points, but
// never larger than the box of the scene. It depends on poses and points alone. The cameras are those of the splits val
// and test and of `train_views` (scene indices; NULL: the split train).
enum vw_status vw_contraction_box(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count,
                                  struct vw_box *box);

// Replaces the depths of a view's camera (vw_pixels_camera) by the near and far ones for sampling in disparity.
void vw_contraction_set_depths(const struct vw_view *view, const struct vw_box *box, struct vw_gpu_camera *camera);

// Computes the cube with the centre of the scene's box that contains 99 % of the observations of points, plus a tenth.
// It is at least as large as the scene's box and at most four times as large. It is twice as large for a scene with few
// points. It depends on the scene's box and points alone.
enum vw_status vw_wide_box(const struct vw_scene *scene, struct vw_box *box);

#endif
