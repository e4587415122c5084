// The evidence that requires little: cameras, alpha, masks, depths. evidence_sky.c and evidence_colour.c hold the rest.
#include "detect/evidence.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

// ---- What counts ----------------------------------------------------------------------------------------------------

bool survey_uses_view(const struct survey *survey, uint32_t view) {
    enum vw_split split = survey->scene->views[view].split;
    return split == VW_SPLIT_TRAIN || split == VW_SPLIT_VAL;
}

bool survey_keeps(const struct survey *survey, uint32_t view, uint32_t x_px, uint32_t y_px) {
    const struct vw_view *seen = &survey->scene->views[view];
    return survey->masks ? vw_view_keeps(seen, x_px, y_px) : vw_view_can_use(seen, x_px, y_px);
}

bool survey_keeps_track(const struct survey *survey, const struct vw_track *track) {
    const struct vw_image *image = &survey->scene->views[track->view].image;
    if (!survey_uses_view(survey, track->view)) return false;
    if (!(track->x_px >= 0 && track->x_px < image->width_px && track->y_px >= 0 && track->y_px < image->height_px))
        return false;
    return survey_keeps(survey, track->view, (uint32_t)track->x_px, (uint32_t)track->y_px);
}

// ---- Cameras, alpha, masks ------------------------------------------------------------------------------------------

static double corner_shift_px(const struct vw_camera *camera, double x_px, double y_px) {
    double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px,
                           -(y_px - camera->centre_y_px) / camera->focal_y_px, -1.0};
    double moved_x_px, moved_y_px;
    if (!vw_camera_project(camera, direction, &moved_x_px, &moved_y_px)) return 0.0;
    return hypot(moved_x_px - x_px, moved_y_px - y_px);
}

enum vw_status evidence_distortion(const struct survey *survey, double *evidence) {
    *evidence = 0.0;
    for (uint32_t v = 0; v < survey->scene->view_count; v++) {
        const struct vw_camera *camera = &survey->scene->views[v].camera;
        if (!vw_camera_is_distorted(camera)) continue;
        for (int corner = 0; corner < 4; corner++)
            *evidence = fmax(*evidence, corner_shift_px(camera, corner & 1 ? camera->width_px : 0.0,
                                                        corner & 2 ? camera->height_px : 0.0));
    }
    return VW_OK;
}

enum vw_status evidence_background(const struct survey *survey, double *evidence) {
    const struct vw_scene *scene = survey->scene;
    uint32_t transparent = 0, used = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!survey_uses_view(survey, v)) continue;
        transparent += scene->views[v].image.has_alpha;
        used++;
    }
    *evidence = used ? (double)transparent / used : 0.0;
    return VW_OK;
}

enum vw_status evidence_masks(const struct survey *survey, double *evidence) {
    const struct vw_scene *scene = survey->scene;
    uint32_t masked = 0, used = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        if (!survey_uses_view(survey, v)) continue;
        masked += scene->views[v].has_mask;
        used++;
    }
    *evidence = used ? (double)masked / used : 0.0;
    return VW_OK;
}

// ---- Depths ---------------------------------------------------------------------------------------------------------

static const double NEAR_SHARE = 0.05, FAR_SHARE = 0.95;
enum { POINTS_MIN = 32 }; // of a photo, for percentiles to mean something

static bool counts_track(const void *survey, const struct vw_track *track) { return survey_keeps_track(survey, track); }

enum vw_status evidence_unbounded(const struct survey *survey, double *evidence) {
    const struct vw_scene *scene = survey->scene;
    uint32_t *ends = NULL, count = 0;
    double *depths = NULL, *ratios = vw_allocate(scene->view_count, sizeof *ratios);
    enum vw_status status = ratios ? vw_scene_depths(scene, counts_track, survey, &ends, &depths) : VW_ERROR_MEMORY;
    for (uint32_t v = 0, begin = 0; !status && v < scene->view_count; begin = ends[v++]) {
        uint32_t seen = ends[v] - begin;
        if (seen < POINTS_MIN) continue;
        vw_sort(depths + begin, seen);
        ratios[count++] = vw_quantile_of_sorted(depths + begin, seen, FAR_SHARE) /
                          vw_quantile_of_sorted(depths + begin, seen, NEAR_SHARE);
    }
    if (!status) *evidence = vw_median(ratios, count);
    free(ends);
    free(depths);
    free(ratios);
    return status;
}

enum vw_status evidence_occupancy(const struct survey *survey, double *evidence) {
    *evidence = survey->pilot.empty_share;
    return VW_OK;
}
