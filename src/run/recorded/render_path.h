// Renders what a camera without photos sees of a run's field: one pose, or a path frame by frame.
#ifndef VIEWWORTH_RUN_RECORDED_RENDER_PATH_H
#define VIEWWORTH_RUN_RECORDED_RENDER_PATH_H

#include "run/recorded/rendering.h"

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
