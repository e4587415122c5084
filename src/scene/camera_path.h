// Cameras without photos: a camera that moves through a scene, and poses that a user gives.
//
// A frame is a vw_view of which nothing but camera, camera_to_world and the range of depths is set, and, of a frame of
// a transforms.json, the name: its file_path, NULL without one. Its range of depths is the mean of those of the scene's
// views, weighted by 1 / distance^4: that of a view in its own place, smooth between views. Beyond it the field was not
// trained.
#ifndef VIEWWORTH_SCENE_CAMERA_PATH_H
#define VIEWWORTH_SCENE_CAMERA_PATH_H

#include "viewworth/scene.h"

enum { VW_CAMERA_PATH_FRAMES_MOST = 9999, VW_CAMERA_PATH_SIDE_MOST_PX = 8192 };

struct vw_camera_path {
    struct vw_view *frames; // owned, with their names
    uint32_t count;
};
void vw_camera_path_free(struct vw_camera_path *path);

// Returns a camera without its lens: focal lengths, principal point and size.
struct vw_camera vw_camera_pinhole(const struct vw_camera *camera);
// Returns the same with pictures of another size, whose pixels need not be square.
struct vw_camera vw_camera_resized(const struct vw_camera *camera, uint32_t width_px, uint32_t height_px);
// Places a camera that looks at `target`, with its upper side towards `up`. Returns false where it would look along
// `up`, or has no way to look.
bool vw_camera_look_at(const double position[3], const double target[3], const double up[3],
                       double camera_to_world[3][4]);

// Makes `count` frames by the pinhole camera of `view`. `name`:
//   orbit    a circle about the mean up of the cameras, at their median distance from that axis and their median
//            height, through the azimuth of `view`; it looks at the point nearest to all optical axes. Without such a
//            point, at the centre of the box.
//   spiral   as NeRF renders scenes that face forward: two turns about the mean camera, as wide as 90 % of the cameras
//            are from it along each of its axes; it looks at one point of the mean axis, at the depth of orbit's point.
//   cameras  through all cameras in the order of their names, where numbers count as such: positions by Catmull-Rom,
//            rotations along the shortest arc. The first frame is the first camera, the last one the last.
// VW_ERROR_USAGE if no such path follows from the cameras.
enum vw_status vw_camera_path_make(const struct vw_scene *scene, const char *name, uint32_t view, uint32_t count,
                                   struct vw_camera_path *path);
bool vw_camera_path_is(const char *name); // one of these

// Reads the frames of a file: camera_path of nerfstudio (camera_to_world, fov, render_width, render_height), or frames
// of a transforms.json, without their lenses. Coordinates are the scene's. A transforms file without w and h, or
// without a focal length, has those of `view`. VW_ERROR_INPUT names the field.
enum vw_status vw_camera_path_read(const struct vw_scene *scene, const char *file, uint32_t view,
                                   struct vw_camera_path *path);
// Makes one frame of the 12 or 16 numbers of camera_to_world, rows first, with spaces or commas between. `where` begins
// the message of VW_ERROR_USAGE.
enum vw_status vw_camera_path_parse(const struct vw_scene *scene, const char *where, const char *numbers, uint32_t view,
                                    struct vw_camera_path *path);

// Sets the range of depths of a frame as said above; it stays 0, 0 in a scene without points.
void vw_camera_path_set_depths(const struct vw_scene *scene, struct vw_view *frame);

#endif
