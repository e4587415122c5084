// The parts of reading transforms.json: the intrinsics and the pose of one frame. `where` names file and frame in messages.
#ifndef VIEWWORTH_TRANSFORMS_H
#define VIEWWORTH_TRANSFORMS_H

#include <jansson.h>

#include "viewworth/scene.h"

// Refuses what would change the meaning of poses or rays and is not modelled: panoramic lenses, rolling shutters.
enum vw_status vw_transforms_refuse_unknown(const char *where, const json_t *object);
// The camera of a frame for an image of the given size. Keys of the frame win over those of the file. A camera model that is not known,
// or distortion that the model does not have, is refused. `*rescaled` tells that the intrinsics were given for another size of the same
// shape.
enum vw_status vw_transforms_camera(const char *where, const json_t *file, const json_t *frame, uint32_t width_px, uint32_t height_px,
                                    struct vw_camera *camera, bool *rescaled);
// The frame's transform_matrix: camera to world, OpenGL axes, a rotation up to one scale (which is divided out)
// and rounding (the nearest rotation is taken), and a position.
enum vw_status vw_transforms_pose(const char *where, const json_t *frame, double camera_to_world[3][4]);

#endif
