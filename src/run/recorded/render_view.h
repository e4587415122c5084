// Renders a view with the trained field of a run, beside its photo.
#ifndef VIEWWORTH_RUN_RECORDED_RENDER_VIEW_H
#define VIEWWORTH_RUN_RECORDED_RENDER_VIEW_H

#include "run/recorded/rendering.h"

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

#endif
