// Reading transforms.json, in parts: its files, the splits of its photos, and the intrinsics and pose of a frame. In
// messages, `where` names file and frame.
#ifndef VIEWWORTH_SCENE_FORMATS_TRANSFORMS_H
#define VIEWWORTH_SCENE_FORMATS_TRANSFORMS_H

#include <jansson.h>

#include "viewworth/scene.h"

// Parses a file; it must not leave `folder` through a link (NULL: the user named the file itself). `*file` is
// owned by the caller.
enum vw_status vw_transforms_parse(const char *folder, const char *path, json_t **file);

// Returns "train_filenames" and so on.
const char *vw_transforms_split_key(enum vw_split split);

// Refuses features that change the meaning of poses or rays and are not supported: panoramic lenses, rolling shutters.
enum vw_status vw_transforms_refuse_unknown(const char *where, const json_t *object);
// Reads the camera of a frame for an image of the given size. Keys of the frame override those of the file. An unknown
// camera model, or distortion that the model does not have, is refused. Sets `*rescaled` if the intrinsics are for
// another size of the same shape.
enum vw_status vw_transforms_camera(const char *where, const json_t *file, const json_t *frame, uint32_t width_px,
                                    uint32_t height_px, struct vw_camera *camera, bool *rescaled);
// Reads the frame's transform_matrix: camera to world, OpenGL axes, a rotation up to one scale (which is divided out)
// and rounding (the nearest rotation is taken), and a position.
enum vw_status vw_transforms_pose(const char *where, const json_t *frame, double camera_to_world[3][4]);
// Takes a pose from such a matrix, which it may change. VW_ERROR_INPUT begins with `where` and `field`.
enum vw_status vw_pose_of_matrix(const char *where, const char *field, double matrix[4][4],
                                 double camera_to_world[3][4]);

// ---- Writing ----

// Returns the four rows of a pose, and a frame: of a photo of that name, with a mask file (NULL: none) and, if
// `own_camera`, its camera. NULL when memory is short.
json_t *vw_pose_to_json(const double camera_to_world[3][4]);
json_t *vw_transforms_frame_to_json(const struct vw_view *view, const char *name, const char *mask, bool own_camera);

#endif
