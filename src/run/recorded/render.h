// Renders with the trained field of a run: a view beside its photo, or what a camera without a photo sees, at one pose
// or along a path, frame by frame.
#ifndef VIEWWORTH_RUN_RECORDED_RENDER_H
#define VIEWWORTH_RUN_RECORDED_RENDER_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_render_params {
    const char *out;    // the folder of the run
    const char *view;   // its name, also without folder or extension, or its place among the validation views; NULL: 0
    const char *to;     // image (.png or .exr) or folder to write; NULL: in OUT
    const char *device; // NULL: the preferred one
    bool depth;         // also the depth of each pixel, in NAME_depth.exr beside NAME.png
    const char *pose;   // numbers of one camera_to_world; NULL: none
    const char *path;   // orbit, spiral, cameras or a file (scene/camera_path.h); NULL: none
    uint32_t frames;    // count of a path that is not a file
    const char *video;  // .mp4 or .gif of the path; NULL: none
};

struct vw_rendered_view {
    char *view, *image_path; // owned
    enum vw_split split;
    double psnr_db; // over the whole view; NaN when no pixel counts
    bool fitted;    // validation fits a gain and a bias to each view, which this PSNR lacks
};

// Writes the image: photo left, render right, or the render alone. `rendered` is zero before; free it also after a
// failure.
enum vw_status vw_render_view(const struct vw_render_params *params, struct vw_rendered_view *rendered);
void vw_rendered_view_free(struct vw_rendered_view *rendered);

struct vw_rendered_path {
    char *to; // owned: the image of a pose, the folder of a path's frames
    uint32_t frame_count;
    const char *video; // borrowed; NULL: none was made
};

// Writes an image for params->pose, or frame_0001.png and so on for params->path, and the video. An effect that sees
// views by their photos sees frames by that of params->view. `rendered` is zero before; free it also after a failure.
enum vw_status vw_render_path(const struct vw_render_params *params, struct vw_rendered_path *rendered);
void vw_rendered_path_free(struct vw_rendered_path *rendered);

#endif
