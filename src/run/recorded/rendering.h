// The beginning of every render: a run and its field, opened, and the view that is named.
#ifndef VIEWWORTH_RUN_RECORDED_RENDERING_H
#define VIEWWORTH_RUN_RECORDED_RENDERING_H

#include "run/out_lock.h"
#include "run/recorded/recorded_run.h"

struct vw_render_params {
    const char *out;    // the folder of the run
    const char *view;   // its name, also without folder or extension, or its place among the validation views; NULL: 0
    const char *to;     // image (.png or .exr) or folder to write; NULL: in OUT
    const char *device; // NULL: the preferred one
    bool only_render;   // leaves the photo of a view out
    bool depth;         // also the depth of each pixel, in NAME_depth.exr beside NAME.png
    const char *pose;   // numbers of one camera_to_world; NULL: none
    const char *path;   // orbit, spiral, cameras or a file (scene/camera_path.h); NULL: none
    uint32_t frames;    // count of a path that is not a file
    const char *video;  // .mp4 or .gif of the path; NULL: none
};

struct vw_rendering {
    struct vw_recorded_run run;
    struct vw_trainer *trainer;
    uint32_t view;
};

// Locks OUT if `to` lies in it, or is NULL. `*lock` is NULL otherwise.
enum vw_status vw_rendering_lock(const char *out, const char *to, struct vw_out_lock **lock);
// Opens the run. Close it also after a failure.
enum vw_status vw_rendering_open(const struct vw_render_params *params, struct vw_rendering *rendering);
void vw_rendering_close(struct vw_rendering *rendering);

// Returns NAME_depth.exr of NAME.png or NAME.exr, owned by the caller.
char *vw_render_name_depth(const char *image);
// Writes it: the expected depth along the axis of a camera in units of the scene, 0 where nothing is seen; one channel
// of floats.
enum vw_status vw_rendering_write_depth(const struct vw_rendering *rendering, const struct vw_view *posed,
                                        const char *image);

// Refuses an image that is neither .png nor .exr. NULL is fine.
enum vw_status vw_render_check_image(const char *to);

// Returns whether a view has this name without its folder, its extension or both.
bool vw_view_has_short_name(const struct vw_view *view, const char *wanted);

#endif
