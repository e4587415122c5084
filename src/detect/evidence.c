#include "detect/evidence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/field_box.h"

// ---- Facts ---------------------------------------------------------------------------------------------------------

static bool is_used(const struct vw_view *view) { return view->split == VW_SPLIT_TRAIN || view->split == VW_SPLIT_VAL; }

static double corner_shift_px(const struct vw_camera *camera, double x_px, double y_px) {
    double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px,
                           -(y_px - camera->centre_y_px) / camera->focal_y_px, -1.0};
    double moved_x_px, moved_y_px;
    if (!vw_camera_project(camera, direction, &moved_x_px, &moved_y_px)) return 0.0;
    return hypot(moved_x_px - x_px, moved_y_px - y_px);
}

double vw_fact_distortion(const struct vw_scene *scene) {
    double largest_px = 0.0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        if (!vw_camera_is_distorted(camera)) continue;
        for (int corner = 0; corner < 4; corner++)
            largest_px = fmax(largest_px, corner_shift_px(camera, corner & 1 ? camera->width_px : 0.0,
                                                          corner & 2 ? camera->height_px : 0.0));
    }
    return largest_px;
}

static bool has_alpha(const struct vw_view *view) { return view->image.has_alpha; }
static bool has_mask(const struct vw_view *view) { return view->has_mask; }

static double share(const struct vw_scene *scene, bool (*holds)(const struct vw_view *view)) {
    uint32_t count = 0, used = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!is_used(&scene->views[v])) continue;
        count += holds(&scene->views[v]);
        used++;
    }
    return used ? (double)count / used : 0.0;
}

double vw_fact_background(const struct vw_scene *scene) { return share(scene, has_alpha); }

double vw_fact_masks(const struct vw_scene *scene) { return share(scene, has_mask); }

// ---- Exposures -----------------------------------------------------------------------------------------------------

static const double NORMAL_95 = 1.645;

// Returns the gain in dB of an error that is smaller by `reduction`, and then at the level.
static double gain_of(double reduction) {
    return 10.0 * log10(1.0 + fmax(reduction, 0.0) / pow(10.0, -0.1 * PHOTOMETRIC_LEVEL_DB));
}

enum vw_status vw_photometric_measure(const struct vw_scene *scene, struct vw_photometric_evidence *evidence) {
    const struct vw_exposure *exposures = NULL;
    double reduction = 0.0, variance = 0.0;
    *evidence = (struct vw_photometric_evidence){.gain_db = NAN, .stderr_db = NAN, .low_db = NAN};
    enum vw_status status = vw_scene_estimate_exposures(scene, &exposures);
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        const struct vw_exposure *exposure = &exposures[v];
        if (!isfinite(exposure->reduction_stderr)) continue;
        reduction += exposure->error_without - exposure->error_with;
        variance += pow(exposure->reduction_stderr, 2.0);
        evidence->observation_count += exposure->observation_count;
        evidence->photo_count++;
    }
    if (status || !evidence->photo_count) return status;
    double mean = reduction / evidence->photo_count, error = sqrt(variance) / evidence->photo_count;
    evidence->gain_db = gain_of(mean);
    evidence->stderr_db = gain_of(mean + error) - evidence->gain_db;
    evidence->low_db = gain_of(mean - NORMAL_95 * error);
    return VW_OK;
}

// ---- Extent --------------------------------------------------------------------------------------------------------

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
