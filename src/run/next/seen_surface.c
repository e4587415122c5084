#include "run/next/seen_surface.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "scene/camera_path.h"
#include "train/trainer.h"

enum { SIDE = 8, BINS = 24 }; // cells along the edge, and directions
enum { CELLS = 2 * SIDE * 2 * SIDE * 2 * SIDE * BINS };

static uint32_t bin_of(const double direction[3]) {
    uint32_t largest = 0;
    for (uint32_t i = 1; i < 3; i++)
        if (fabs(direction[i]) > fabs(direction[largest])) largest = i;
    uint32_t bin = 0;
    for (uint32_t i = 0; i < 3; i++) bin = 2 * bin + (direction[(largest + i) % 3] < 0);
    return 8 * largest + bin;
}

uint32_t vw_seen_surface_cell(const struct vw_box *box, const double point_world[3], const double direction_world[3]) {
    double place[3], most = 0;
    for (int i = 0; i < 3; i++) {
        place[i] = (point_world[i] - box->centre_world[i]) / box->half_extent_world;
        most = fmax(most, fabs(place[i]));
    }
    double contracted = most > 1 ? (2 - 1 / most) / most : 1;
    uint32_t cell = 0;
    for (int i = 0; i < 3; i++) {
        double along = floor((place[i] * contracted + 2) / 2 * SIDE);
        cell = cell * 2 * SIDE + (uint32_t)fmin(fmax(along, 0), 2 * SIDE - 1);
    }
    return cell * BINS + bin_of(direction_world);
}

enum vw_status vw_seen_surface_create(const struct vw_known_views *known, struct vw_seen_surface *surface) {
    const struct vw_box *box = vw_trainer_effect_box(known->trainer);
    *surface = (struct vw_seen_surface){.known = known,
                                        .box = box ? *box : known->scene->box,
                                        .counts = vw_allocate(CELLS, sizeof(uint32_t)),
                                        .last = vw_allocate(CELLS, sizeof(uint32_t))};
    enum vw_status status = surface->counts && surface->last ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < known->count && !status; i++) {
        struct vw_seen_cells seen = {0};
        status = vw_seen_surface_look(surface, &known->scene->views[known->views[i]], &seen);
        if (!status) vw_seen_surface_add(surface, &seen);
        free(seen.cells);
    }
    return status;
}

uint32_t vw_seen_surface_photos(const struct vw_seen_surface *surface, uint32_t cell) {
    uint32_t photos = 0;
    for (uint32_t bin = 0; bin < BINS; bin++) photos += surface->counts[cell / BINS * BINS + bin];
    return photos < surface->photo_count ? photos : surface->photo_count;
}

void vw_seen_surface_destroy(struct vw_seen_surface *surface) {
    free(surface->counts);
    free(surface->last);
    *surface = (struct vw_seen_surface){0};
}

// Returns the same camera with few pixels.
static struct vw_view coarsen(const struct vw_view *pose) {
    struct vw_view coarse = {.near_world = pose->near_world, .far_world = pose->far_world};
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 4; k++) coarse.camera_to_world[row][k] = pose->camera_to_world[row][k];
    struct vw_camera *camera = &coarse.camera;
    *camera = vw_camera_pinhole(&pose->camera);
    double width_px = fmin(VW_SEEN_WIDTH_PX, camera->width_px),
           height_px = fmax(1, round(width_px * camera->height_px / camera->width_px));
    double across = width_px / camera->width_px, down = height_px / camera->height_px;
    camera->width_px = (uint32_t)width_px;
    camera->height_px = (uint32_t)height_px;
    camera->focal_x_px *= across;
    camera->centre_x_px *= across;
    camera->focal_y_px *= down;
    camera->centre_y_px *= down;
    return coarse;
}

static uint32_t cell_of_pixel(const struct vw_box *box, const struct vw_view *coarse, uint32_t place, double depth) {
    double camera[3], direction_world[3], point_world[3];
    uint32_t x_px = place % coarse->camera.width_px, y_px = place / coarse->camera.width_px;
    if (!(depth > 0) || !vw_camera_unproject(&coarse->camera, x_px + 0.5, y_px + 0.5, camera)) return VW_SEEN_NOTHING;
    for (int i = 0; i < 3; i++) {
        const double *row = coarse->camera_to_world[i];
        direction_world[i] = row[0] * camera[0] + row[1] * camera[1] + row[2] * camera[2];
        point_world[i] = row[3] + depth * direction_world[i];
    }
    return vw_seen_surface_cell(box, point_world, direction_world);
}

enum vw_status vw_seen_surface_look(const struct vw_seen_surface *surface, const struct vw_view *pose,
                                    struct vw_seen_cells *seen) {
    const struct vw_view coarse = coarsen(pose);
    float *depths = NULL;
    enum vw_status status =
        vw_trainer_render_posed(surface->known->trainer, surface->known->views[0], &coarse, true, &depths);
    if (status) return status;
    seen->count = coarse.camera.width_px * coarse.camera.height_px;
    seen->cells = vw_allocate(seen->count, sizeof *seen->cells);
    for (uint32_t i = 0; seen->cells && i < seen->count; i++)
        seen->cells[i] = cell_of_pixel(&surface->box, &coarse, i, depths[i]);
    free(depths);
    return seen->cells ? VW_OK : VW_ERROR_MEMORY;
}

void vw_seen_surface_add(struct vw_seen_surface *surface, const struct vw_seen_cells *seen) {
    uint32_t photo = ++surface->photo_count;
    for (uint32_t i = 0; i < seen->count; i++) {
        uint32_t cell = seen->cells[i];
        if (cell == VW_SEEN_NOTHING || surface->last[cell] == photo) continue;
        surface->last[cell] = photo;
        surface->counts[cell]++;
    }
}
