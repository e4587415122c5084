#include "scene/view_distance.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

static const double RATIO_MOST = 4;
static const double BETWEEN_LEAST = 0.02; // relative to the median distance to the box's centre
static const double ANGLE_LEAST = 10 * M_PI / 180;
static const double SAME_ANGLE = 2 * M_PI / 180;

double vw_view_between_world(const struct vw_view *a, const struct vw_view *b) {
    double squares = 0;
    for (int i = 0; i < 3; i++) {
        double apart = a->camera_to_world[i][VW_POSE_POSITION] - b->camera_to_world[i][VW_POSE_POSITION];
        squares += apart * apart;
    }
    return sqrt(squares);
}

static double angle(const struct vw_view *a, const struct vw_view *b) {
    double cosine = 0;
    for (int i = 0; i < 3; i++) cosine += a->camera_to_world[i][VW_POSE_BACK] * b->camera_to_world[i][VW_POSE_BACK];
    return acos(fmin(fmax(cosine, -1), 1));
}

static double distance(const struct vw_view_scales *scales, const struct vw_view *a, const struct vw_view *b) {
    double by_place = vw_view_between_world(a, b) / scales->between_world;
    return fmax(by_place, angle(a, b) / scales->angle);
}

static bool is_copy(const struct vw_view_scales *scales, const struct vw_view *a, const struct vw_view *b) {
    return a->split == b->split && vw_view_between_world(a, b) <= scales->copy_world && angle(a, b) <= SAME_ANGLE;
}

// Finds the train view nearest to `view`, other than itself and, if it is a train view, its copies; NULL: none.
static const struct vw_view *find_nearest(const struct vw_scene *scene, const struct vw_view_scales *scales,
                                          const struct vw_view *view, double *least) {
    const struct vw_view *nearest = NULL;
    *least = INFINITY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_view *other = &scene->views[i];
        if (other->split != VW_SPLIT_TRAIN || other == view || is_copy(scales, view, other)) continue;
        double apart = distance(scales, view, other);
        if (nearest && !(apart < *least)) continue;
        nearest = other;
        *least = apart;
    }
    return nearest;
}

// Computes the median, over the train views, of the distance to the nearest other one, in these units.
static double median_to_nearest(const struct vw_scene *scene, const struct vw_view_scales *scales, double *values) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->view_count; i++)
        if (scene->views[i].split == VW_SPLIT_TRAIN && find_nearest(scene, scales, &scene->views[i], &values[count]))
            count++;
    return count ? vw_median(values, count) : 0;
}

static double median_to_centre(const struct vw_scene *scene, double *values) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        double apart = 0;
        if (scene->views[i].split != VW_SPLIT_TRAIN) continue;
        for (int k = 0; k < 3; k++)
            apart = hypot(apart, scene->views[i].camera_to_world[k][VW_POSE_POSITION] - scene->box.centre_world[k]);
        values[count++] = apart;
    }
    return vw_median(values, count);
}

static struct vw_view_scales find_scales(const struct vw_scene *scene, double *values) {
    double least_world = fmax(BETWEEN_LEAST * median_to_centre(scene, values), 1e-3 * scene->box.half_extent_world);
    const struct vw_view_scales by_place = {1, INFINITY, least_world, 1},
                                by_angle = {INFINITY, 1, least_world, 1}; // units that ignore the other distance
    struct vw_view_scales scales = {fmax(median_to_nearest(scene, &by_place, values), least_world),
                                    fmax(median_to_nearest(scene, &by_angle, values), ANGLE_LEAST), least_world, 1};
    scales.typical = fmax(median_to_nearest(scene, &scales, values), 1);
    return scales;
}

enum vw_status vw_view_scales_find(const struct vw_scene *scene, struct vw_view_scales *scales) {
    if (scene->split_count[VW_SPLIT_TRAIN] < 2)
        return vw_fail(VW_ERROR_USAGE, "%s: has a single train photo; distances need two or more", scene->path);
    double *values = vw_allocate(scene->view_count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    *scales = find_scales(scene, values);
    free(values);
    return VW_OK;
}

double vw_view_apart(const struct vw_view_scales *scales, const struct vw_view *a, const struct vw_view *b) {
    return distance(scales, a, b) / scales->typical;
}

uint32_t vw_view_nearest(const struct vw_scene *scene, const struct vw_view_scales *scales, const uint32_t *views,
                         uint32_t count, const struct vw_view *pose, double *apart) {
    uint32_t nearest = 0;
    *apart = INFINITY;
    for (uint32_t i = 0; i < count; i++) {
        double one = vw_view_apart(scales, pose, &scene->views[views[i]]);
        if (one < *apart) *apart = one, nearest = i;
    }
    return nearest;
}

enum vw_status vw_scene_view_distances(const struct vw_scene *scene, enum vw_split split,
                                       struct vw_view_distance **distances, uint32_t *count) {
    double *values = vw_allocate(scene->view_count, sizeof *values);
    struct vw_view_distance *made = vw_allocate(scene->view_count, sizeof *made);
    if (!values || !made) {
        free(values);
        free(made);
        return VW_ERROR_MEMORY;
    }
    uint32_t made_count = 0;
    bool measurable = scene->split_count[VW_SPLIT_TRAIN] >= 2;
    struct vw_view_scales scales = measurable ? find_scales(scene, values) : (struct vw_view_scales){0};
    for (uint32_t v = 0; measurable && v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        if (view->split != split) continue;
        double apart;
        const struct vw_view *nearest = find_nearest(scene, &scales, view, &apart);
        if (!nearest) continue;
        made[made_count++] = (struct vw_view_distance){.view = v,
                                                       .nearest = (uint32_t)(nearest - scene->views),
                                                       .between_world = vw_view_between_world(view, nearest),
                                                       .angle_deg = angle(view, nearest) * 180 / M_PI,
                                                       .ratio = apart / scales.typical,
                                                       .far = apart > RATIO_MOST * scales.typical};
    }
    free(values);
    *distances = made;
    *count = made_count;
    return VW_OK;
}
