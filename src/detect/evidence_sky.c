// Rays that nothing bounds.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "detect/evidence.h"
#include "image/image.h"
#include "base/memory.h"

enum {
    CELLS = 8,       // along each side of a photo
    LOOKS = 8,       // pixels looked at, along each side of a cell
    PHOTOS_MAX = 64, // evenly spaced among those used: bounds the work
    POINTS_MAX = 1 << 15,
    POINTS_MIN = 64, // fewer leave most cells empty whatever they show
};
static const double BRIGHT =
    0.1; // mean over channels: what is darker may be the black that rays into nothing render as
static const double SMOOTH = 0.05; // standard deviation of that within a cell
static const double LEVEL = 0.3;   // mean of the cameras' unit up axes: shorter means that they agree on none

struct cell {
    bool known, pointless, plain; // known: at least half of its pixels count; plain: smooth and bright
};

struct counts {
    uint32_t cells[2], open[2]; // upper and lower
};

static bool find_up(const struct survey *survey, double up[3]) {
    uint32_t used = 0;
    memset(up, 0, 3 * sizeof *up);
    for (uint32_t v = 0; v < survey->scene->view_count; v++) {
        if (!survey_uses_view(survey, v)) continue;
        for (int i = 0; i < 3; i++) up[i] += survey->scene->views[v].camera_to_world[i][1];
        used++;
    }
    return used && sqrt(up[0] * up[0] + up[1] * up[1] + up[2] * up[2]) >= LEVEL * used;
}

static void mark_points(const struct vw_scene *scene, const struct vw_view *view, struct cell cells[CELLS][CELLS]) {
    uint32_t stride = 1 + scene->point_count / POINTS_MAX;
    for (uint32_t p = 0; p < scene->point_count; p += stride) {
        double direction[3] = {0}, x_px, y_px;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                direction[j] +=
                    view->camera_to_world[i][j] * (scene->points[p].position_world[i] - view->camera_to_world[i][3]);
        if (!vw_camera_project(&view->camera, direction, &x_px, &y_px)) continue;
        double column = floor(x_px * CELLS / view->camera.width_px), row = floor(y_px * CELLS / view->camera.height_px);
        if (column >= 0 && column < CELLS && row >= 0 && row < CELLS) cells[(int)row][(int)column].pointless = false;
    }
}

static void look_at(const struct survey *survey, uint32_t view, uint32_t row, uint32_t column, struct cell *cell) {
    const struct vw_image *image = &survey->scene->views[view].image;
    double sum = 0.0, square = 0.0;
    uint32_t kept = 0;
    for (uint32_t look = 0; look < LOOKS * LOOKS; look++) {
        uint32_t x_px = (uint32_t)((column * LOOKS + look % LOOKS + 0.5) * image->width_px / (CELLS * LOOKS));
        uint32_t y_px = (uint32_t)((row * LOOKS + look / LOOKS + 0.5) * image->height_px / (CELLS * LOOKS));
        float rgba[4];
        if (!survey_keeps(survey, view, x_px, y_px)) continue;
        vw_image_pixel(image, x_px, y_px, rgba);
        double value = (double)rgba[3] * (rgba[0] + rgba[1] + rgba[2]) / 3.0; // transparent is no sky
        sum += value;
        square += value * value;
        kept++;
    }
    double mean = sum / fmax(kept, 1), deviation = sqrt(fmax(square / fmax(kept, 1) - mean * mean, 0.0));
    *cell = (struct cell){
        .known = 2 * kept >= LOOKS * LOOKS, .pointless = true, .plain = mean >= BRIGHT && deviation <= SMOOTH};
}

// How far the ray through an image position rises.
static double rise_of(const struct vw_view *view, const double up[3], double x_px, double y_px) {
    const struct vw_camera *camera = &view->camera;
    const double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px,
                                 -(y_px - camera->centre_y_px) / camera->focal_y_px, -1};
    double rise = 0.0, length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + 1.0);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) rise += up[i] * view->camera_to_world[i][j] * direction[j] / length;
    return rise;
}

static void count_cells(const struct vw_view *view, const double up[3], struct cell cells[CELLS][CELLS],
                        struct counts *counts) {
    double width_px = view->camera.width_px, height_px = view->camera.height_px;
    double middle = rise_of(view, up, width_px / 2, height_px / 2);
    for (int column = 0; column < CELLS; column++)
        for (int row = 0; row < CELLS; row++) {
            if (!cells[row][column].known) continue;
            bool lower = rise_of(view, up, (column + 0.5) / CELLS * width_px, (row + 0.5) / CELLS * height_px) < middle;
            bool clear = cells[row][column].plain;
            for (int i = row; i >= 0 && i < CELLS; i += lower ? 1 : -1)
                clear &= cells[i][column].pointless; // out to the photo's border
            counts->cells[lower]++;
            counts->open[lower] += clear;
        }
}

static void survey_photo(const struct survey *survey, uint32_t view, const double up[3], struct counts *counts) {
    struct cell cells[CELLS][CELLS];
    for (uint32_t row = 0; row < CELLS; row++)
        for (uint32_t column = 0; column < CELLS; column++) look_at(survey, view, row, column, &cells[row][column]);
    mark_points(survey->scene, &survey->scene->views[view], cells);
    count_cells(&survey->scene->views[view], up, cells, counts);
}

enum vw_status evidence_sky(const struct survey *survey, double *evidence) {
    const struct vw_scene *scene = survey->scene;
    struct counts counts = {0};
    double up[3];
    uint32_t used = 0,
             stride = 1 + (scene->split_count[VW_SPLIT_TRAIN] + scene->split_count[VW_SPLIT_VAL]) / PHOTOS_MAX;
    *evidence = NAN;
    if (scene->point_count < POINTS_MIN || !find_up(survey, up)) return VW_OK;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (survey_uses_view(survey, v) && used++ % stride == 0) survey_photo(survey, v, up, &counts);
    double share[2];
    for (int half = 0; half < 2; half++)
        share[half] = counts.cells[half] ? (double)counts.open[half] / counts.cells[half] : 0.0;
    *evidence = fmax(share[0] - share[1], 0.0);
    return VW_OK;
}
