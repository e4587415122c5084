// Views as splats see them: a grid of tiles, and how far out its lens reaches.
#include <math.h>

#include "train/renderers/splats/splats.h"

static const double MARGIN = 0.15;     // share of a photo by which a centre may lie beside it before J stays as there
static const double REACH_MOST = 1e15; // so that its square is a float
enum { BORDER_STEPS = 8 };             // points along a side of a photo at which the lens is undone

// The range of x / z and y / z (y down) that the photo shows: least, most.
struct seen {
    double least[2], most[2];
};

static void widen(struct seen *seen, double x, double y) {
    const double at[2] = {x, y};
    for (int i = 0; i < 2; i++) {
        seen->least[i] = fmin(seen->least[i], at[i]);
        seen->most[i] = fmax(seen->most[i], at[i]);
    }
}

// Widens by a place of the border; where the lens has no inverse, by all that it reaches.
static void widen_by_border(const struct vw_camera *camera, double fold, double x_px, double y_px, struct seen *seen) {
    double direction[3];
    if (vw_camera_unproject(camera, x_px, y_px, direction)) {
        widen(seen, direction[0], -direction[1]);
    } else if (isfinite(fold)) {
        widen(seen, -fold, -fold);
        widen(seen, fold, fold);
    }
}

static struct seen seen_by(const struct vw_camera *camera, double fold) {
    struct seen seen = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (int i = 0; i <= BORDER_STEPS; i++) {
        double x_px = (double)camera->width_px * i / BORDER_STEPS, y_px = (double)camera->height_px * i / BORDER_STEPS;
        widen_by_border(camera, fold, x_px, 0.0, &seen);
        widen_by_border(camera, fold, x_px, camera->height_px, &seen);
        widen_by_border(camera, fold, 0.0, y_px, &seen);
        widen_by_border(camera, fold, camera->width_px, y_px, &seen);
    }
    return seen;
}

struct vw_splat_view vw_splat_view_of(uint32_t index, uint32_t first_cell, const struct vw_camera *camera, bool lens,
                                      uint32_t side) {
    struct vw_camera own = {.width_px = camera->width_px,
                            .height_px = camera->height_px,
                            .focal_x_px = camera->focal_x_px,
                            .focal_y_px = camera->focal_y_px,
                            .centre_x_px = camera->centre_x_px,
                            .centre_y_px = camera->centre_y_px};
    if (lens) own = *camera;
    double fold = vw_camera_fold(&own), margins[2];
    struct seen seen = seen_by(&own, fold);
    for (int i = 0; i < 2; i++) margins[i] = MARGIN * (seen.most[i] - seen.least[i]);
    return (struct vw_splat_view){
        .camera = index,
        .first_cell = first_cell,
        .columns = (camera->width_px + side - 1) / side,
        .rows = (camera->height_px + side - 1) / side,
        .slopes = {(float)(seen.least[0] - margins[0]), (float)(seen.least[1] - margins[1]),
                   (float)(seen.most[0] + margins[0]), (float)(seen.most[1] + margins[1])},
        .reach = (float)fmin(fold, REACH_MOST),
    };
}

struct vw_splat_tile vw_splat_tile_at(const struct vw_splat_view *view, uint32_t index, uint32_t column, uint32_t row) {
    return (struct vw_splat_tile){index, row << 16 | column, view->first_cell + row * view->columns + column};
}
