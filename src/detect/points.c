#include "detect/points.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/contraction.h"

enum { CELLS = 8, POINTS_MIN = 64 }; // along the sides of a photo; as for the scene's box

static uint32_t cell_of(float place_px, uint32_t side_px) {
    float cell = place_px * CELLS / (float)side_px;
    return cell < 0.0f ? 0 : cell >= CELLS ? CELLS - 1 : (uint32_t)cell;
}

// Marks the cell of an observation and its neighbours.
static void mark(bool *cells, uint32_t column, uint32_t row) {
    for (uint32_t y = row ? row - 1 : 0; y <= row + 1 && y < CELLS; y++)
        for (uint32_t x = column ? column - 1 : 0; x <= column + 1 && x < CELLS; x++) cells[y * CELLS + x] = true;
}

static enum vw_status measure_bare(const struct vw_scene *scene, double *share) {
    bool *cells = vw_allocate((size_t)scene->view_count * CELLS * CELLS, sizeof *cells);
    uint32_t bare = 0, photos = 0;
    if (!cells) return VW_ERROR_MEMORY;
    for (uint32_t t = 0; t < scene->track_count; t++) {
        const struct vw_track *track = &scene->tracks[t];
        const struct vw_camera *camera = &scene->views[track->view].camera;
        mark(cells + (size_t)track->view * CELLS * CELLS, cell_of(track->x_px, camera->width_px),
             cell_of(track->y_px, camera->height_px));
    }
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (scene->views[v].split != VW_SPLIT_TRAIN) continue;
        for (uint32_t i = 0; i < CELLS * CELLS; i++) bare += !cells[(size_t)v * CELLS * CELLS + i];
        photos++;
    }
    free(cells);
    *share = photos ? (double)bare / photos / (CELLS * CELLS) : 0.0;
    return VW_OK;
}

enum vw_status vw_point_evidence_find(const struct vw_scene *scene, struct vw_point_evidence *evidence) {
    struct vw_box inner;
    *evidence = (struct vw_point_evidence){.known = scene->point_count >= POINTS_MIN && scene->track_count};
    if (!evidence->known) return VW_OK;
    enum vw_status status = vw_contraction_box(scene, NULL, 0, &inner);
    if (!status) status = measure_bare(scene, &evidence->bare_share);
    if (status) return status;
    evidence->outside_share = (double)vw_scene_count_outside(scene, &scene->box) / scene->track_count;
    evidence->inner_share = inner.half_extent_world / scene->box.half_extent_world;
    return VW_OK;
}
