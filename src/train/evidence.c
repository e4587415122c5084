// The evidence that needs little: cameras, alpha, masks, depths. evidence_sky.c and evidence_colour.c hold the rest.
#include "evidence.h"

#include <math.h>
#include <stdlib.h>

#include "viewworth/memory.h"

static const double NORMAL_SPREAD = 1.4826; // standard deviation / median absolute deviation

// ---- Sorting ------------------------------------------------------------------------------------------------------------------

static int compare_reals(const void *a, const void *b) {
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

void sort_reals(double *values, uint32_t count) { qsort(values, count, sizeof *values, compare_reals); }

double quantile_of_sorted(const double *sorted, uint32_t count, double share) {
    double place = share * (count - 1);
    uint32_t below = (uint32_t)place, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

double median_of(double *values, uint32_t count) {
    if (!count) return NAN;
    sort_reals(values, count);
    return quantile_of_sorted(values, count, 0.5);
}

double robust_spread(double *values, uint32_t count) {
    double middle = median_of(values, count);
    for (uint32_t i = 0; i < count; i++) values[i] = fabs(values[i] - middle);
    return NORMAL_SPREAD * median_of(values, count);
}

// ---- What counts --------------------------------------------------------------------------------------------------------------

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
    if (!(track->x_px >= 0 && track->x_px < image->width_px && track->y_px >= 0 && track->y_px < image->height_px)) return false;
    return survey_keeps(survey, track->view, (uint32_t)track->x_px, (uint32_t)track->y_px);
}

// ---- Cameras, alpha, masks ------------------------------------------------------------------------------------------------------

static double corner_shift_px(const struct vw_camera *camera, double x_px, double y_px) {
    double direction[3] = {(x_px - camera->centre_x_px) / camera->focal_x_px, -(y_px - camera->centre_y_px) / camera->focal_y_px, -1.0};
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
            *evidence = fmax(*evidence, corner_shift_px(camera, corner & 1 ? camera->width_px : 0.0, corner & 2 ? camera->height_px : 0.0));
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

// ---- Depths -------------------------------------------------------------------------------------------------------------------

static const double NEAR_SHARE = 0.05, FAR_SHARE = 0.95;
enum { POINTS_MIN = 32 }; // of a photo, for percentiles to mean something

static double depth_of(const struct vw_view *view, const double position_world[3]) {
    double depth = 0;
    for (int i = 0; i < 3; i++) depth -= (position_world[i] - view->camera_to_world[i][3]) * view->camera_to_world[i][2];
    return depth;
}

// Where the depths of each view begin when those of all views stand one after another: ends[v] is the end of view v.
static void gather_depths(const struct survey *survey, uint32_t *ends, double *depths) {
    const struct vw_scene *scene = survey->scene;
    for (int pass = 0; pass < 2; pass++) { // count, then fill
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const struct vw_point *point = &scene->points[p];
            for (uint32_t t = point->first_track; t < point->first_track + point->track_count; t++) {
                const struct vw_track *track = &scene->tracks[t];
                double depth = depth_of(&scene->views[track->view], point->position_world);
                if (!(depth > 0) || !survey_keeps_track(survey, track)) continue;
                if (pass) depths[ends[track->view]] = depth;
                ends[track->view + !pass]++; // the count of view v lies one further, so that sums of counts are begins
            }
        }
        for (uint32_t v = 1; !pass && v <= scene->view_count; v++) ends[v] += ends[v - 1];
    }
}

enum vw_status evidence_unbounded(const struct survey *survey, double *evidence) {
    const struct vw_scene *scene = survey->scene;
    uint32_t *ends = vw_allocate((size_t)scene->view_count + 1, sizeof *ends), count = 0;
    double *depths = vw_allocate(scene->track_count, sizeof *depths), *ratios = vw_allocate(scene->view_count, sizeof *ratios);
    enum vw_status status = ends && depths && ratios ? VW_OK : VW_ERROR_MEMORY;
    if (!status) gather_depths(survey, ends, depths);
    for (uint32_t v = 0, begin = 0; !status && v < scene->view_count; begin = ends[v++]) {
        uint32_t seen = ends[v] - begin;
        if (seen < POINTS_MIN) continue;
        sort_reals(depths + begin, seen);
        ratios[count++] = quantile_of_sorted(depths + begin, seen, FAR_SHARE) / quantile_of_sorted(depths + begin, seen, NEAR_SHARE);
    }
    if (!status) *evidence = median_of(ratios, count);
    free(ends);
    free(depths);
    free(ratios);
    return status;
}

enum vw_status evidence_occupancy(const struct survey *survey, double *evidence) {
    *evidence = survey->probe.empty_share;
    return VW_OK;
}
