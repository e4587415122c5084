// The extent of a scene by its points and cameras: the depths that views see, and the box, chosen in this order:
//
// 1. The box that the scene file declares (aabb_scale), if it contains what the cameras look at.
// 2. From SfM points: along each axis the range from the 2nd to the 98th percentile of the points (so that outliers do
//    not count) plus a tenth, extended to the point that the cameras look at (see 3), if there is one. The box is the
//    cube with the centre of that range and its longest side.
// 3. From cameras that look inwards: the centre is the point with the least sum of squared distances to all optical
//    axes. The half extent is 1.1 * median over cameras of (distance to that point * tangent of half the wider field
//    of view): the half width that a typical camera sees at that distance, plus a tenth. If there is no such point (the
//    axes are parallel or diverge), the depth of the scene is unknown and assumed to be 4 times the spread of the
//    cameras.
//
// Sums and differences are relative to the cameras' centroid, so that coordinates of a million metres keep their
// precision.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "scene/builder.h"
#include "viewworth/scene.h"

// ---- Depths --------------------------------------------------------------------------------------------------------

static double depth_of(const struct vw_view *view, const double position_world[3]) {
    double depth = 0;
    for (int i = 0; i < 3; i++)
        depth -= (position_world[i] - view->camera_to_world[i][3]) * view->camera_to_world[i][2];
    return depth;
}

// Sorts the depths (> 0) of the points that each view sees by view: those of view v are depths[ends[v - 1]] to
// depths[ends[v] - 1], those of view 0 begin at 0.
static void gather(const struct vw_scene *scene, uint32_t *ends, double *depths) {
    for (int filling = 0; filling < 2; filling++) { // count, then fill
        for (uint32_t p = 0; p < scene->point_count; p++) {
            const struct vw_point *point = &scene->points[p];
            for (uint32_t t = point->first_track; t < point->first_track + point->track_count; t++) {
                uint32_t v = scene->tracks[t].view;
                double depth = depth_of(&scene->views[v], point->position_world);
                if (!(depth > 0)) continue; // it is behind the camera
                if (filling) depths[ends[v]] = depth;
                ends[v + !filling]++; // counts are stored one entry further, so that their sums are the begins
            }
        }
        for (uint32_t v = 1; !filling && v <= scene->view_count; v++) ends[v] += ends[v - 1];
    }
}

static const double NEAR_SHARE = 0.001, FAR_SHARE = 0.999;
// On average, a share of 2 / (n + 1) of what a view sees is outside the range of n points: 6 % here, which the margins
// of vw_pixels_camera() cover. With fewer points, whole surfaces could be cut off.
enum { DEPTHS_MIN = 32 };

enum vw_status vw_near_far_measure(struct vw_scene *scene) {
    uint32_t *ends = vw_allocate((size_t)scene->view_count + 1, sizeof *ends);
    double *depths = vw_allocate(scene->track_count, sizeof *depths);
    enum vw_status status = ends && depths ? VW_OK : VW_ERROR_MEMORY;
    if (!status) gather(scene, ends, depths);
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        struct vw_view *view = &scene->views[v];
        uint32_t begin = v ? ends[v - 1] : 0, count = ends[v] - begin;
        bool known = count >= DEPTHS_MIN;
        vw_sort(depths + begin, count);
        view->near_world = known ? vw_quantile_of_sorted(depths + begin, count, NEAR_SHARE) : 0;
        view->far_world = known ? vw_quantile_of_sorted(depths + begin, count, FAR_SHARE) : 0;
    }
    free(ends);
    free(depths);
    return status;
}

// ---- The box -------------------------------------------------------------------------------------------------------

static const double MARGIN = 1.1;
static const double STRAY_SHARE = 0.02; // share of the points that is ignored at either end of an axis
enum { POINTS_MIN = 64 };               // with fewer points, the cameras are better evidence
static const double SPREADS_AWAY = 4;
static const double PARALLEL_DETERMINANT = 0.003; // about the square of the axes' angular spread: 3 degrees
static const double FRONT_SHARE = 0.75;           // share of the cameras that must have the common point in front

struct axes {
    double centroid_world[3];
    double mean_look[3]; // mean of the unit directions: length 1 if all are parallel, near 0 if they cancel
    double spread_world; // root mean square distance from the centroid
    double reach_world;  // largest difference of a coordinate from the centroid's
    double focus[3];     // the point closest to all axes, relative to the centroid
    bool common_point;   // the axes have one, and it is in front of most cameras
};

static void position_of(const struct vw_view *view, const double origin_world[3], double position[3]) {
    for (int i = 0; i < 3; i++) position[i] = view->camera_to_world[i][3] - origin_world[i];
}

static void look_of(const struct vw_view *view, double look[3]) {
    for (int i = 0; i < 3; i++) look[i] = -view->camera_to_world[i][2];
}

// Solves by Cramer's rule; the caller knows that `divisor`, the determinant of m, is not small.
static void solve(const double m[3][3], double divisor, const double right[3], double solution[3]) {
    for (int column = 0; column < 3; column++) {
        double replaced[3][3];
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) replaced[i][j] = j == column ? right[i] : m[i][j];
        solution[column] = vw_determinant(replaced[0], replaced[1], replaced[2]) / divisor;
    }
}

static bool is_before_most(const struct vw_scene *scene, const struct axes *axes) {
    uint32_t before = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        double position[3], look[3], depth = 0;
        position_of(&scene->views[v], axes->centroid_world, position);
        look_of(&scene->views[v], look);
        for (int i = 0; i < 3; i++) depth += (axes->focus[i] - position[i]) * look[i];
        before += depth > 0;
    }
    return before >= FRONT_SHARE * scene->view_count;
}

static void find_centroid(const struct vw_scene *scene, double centroid_world[3]) {
    const double origin_world[3] = {0};
    double first_world[3], mean[3] = {0}; // relative to the first camera
    position_of(&scene->views[0], origin_world, first_world);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        double position[3];
        position_of(&scene->views[v], first_world, position);
        for (int i = 0; i < 3; i++) mean[i] += position[i] / scene->view_count;
    }
    for (int i = 0; i < 3; i++) centroid_world[i] = first_world[i] + mean[i];
}

// Sums the normal equations of the point closest to all axes: the mean of (I - look look^T) times point = the mean of
// the same times position.
static struct axes measure_axes(const struct vw_scene *scene) {
    struct axes axes = {0};
    double matrix[3][3] = {{0}}, right[3] = {0}, square = 0;
    find_centroid(scene, axes.centroid_world);
    for (uint32_t v = 0; v < scene->view_count; v++) {
        double position[3], look[3];
        position_of(&scene->views[v], axes.centroid_world, position);
        look_of(&scene->views[v], look);
        for (int i = 0; i < 3; i++) {
            axes.mean_look[i] += look[i] / scene->view_count;
            square += position[i] * position[i] / scene->view_count;
            axes.reach_world = fmax(axes.reach_world, fabs(position[i]));
            for (int j = 0; j < 3; j++) {
                double across = ((i == j) - look[i] * look[j]) / scene->view_count;
                matrix[i][j] += across;
                right[i] += across * position[j];
            }
        }
    }
    axes.spread_world = sqrt(square);
    double divisor = vw_determinant(matrix[0], matrix[1], matrix[2]);
    if (divisor < PARALLEL_DETERMINANT) return axes;
    solve(matrix, divisor, right, axes.focus);
    axes.common_point = is_before_most(scene, &axes);
    return axes;
}

// Computes the median over views of the half width seen at the focus.
static enum vw_status median_half_width(const struct vw_scene *scene, const struct axes *axes,
                                        double *half_width_world) {
    double *widths = vw_allocate(scene->view_count, sizeof *widths);
    if (!widths) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_camera *camera = &scene->views[v].camera;
        double tangent = 0.5 * fmax(camera->width_px / camera->focal_x_px, camera->height_px / camera->focal_y_px);
        double position[3], square = 0;
        position_of(&scene->views[v], axes->centroid_world, position);
        for (int i = 0; i < 3; i++) square += (axes->focus[i] - position[i]) * (axes->focus[i] - position[i]);
        widths[v] = sqrt(square) * tangent;
    }
    vw_sort(widths, scene->view_count);
    *half_width_world = 0.5 * (widths[(scene->view_count - 1) / 2] + widths[scene->view_count / 2]);
    free(widths);
    return VW_OK;
}

static enum vw_status box_of_cameras(const struct vw_scene *scene, const struct axes *axes, struct vw_box *box,
                                     const char **source) {
    double half_width_world = 0;
    if (axes->common_point) {
        enum vw_status status = median_half_width(scene, axes, &half_width_world);
        if (status) return status;
    }
    if (half_width_world > 0) {
        *source = "cameras: centred on the point closest to all optical axes, as wide as a typical camera sees there";
        for (int i = 0; i < 3; i++) box->centre_world[i] = axes->centroid_world[i] + axes->focus[i];
        box->half_extent_world = MARGIN * half_width_world;
        return VW_OK;
    }
    double depth_world = axes->spread_world > 0 ? SPREADS_AWAY * axes->spread_world : 1;
    *source = "cameras: their axes have no common point, so the depth of the scene is taken as 4 times their spread";
    for (int i = 0; i < 3; i++) box->centre_world[i] = axes->centroid_world[i] + axes->mean_look[i] * depth_world;
    box->half_extent_world = MARGIN * depth_world;
    return VW_OK;
}

// Returns the range of the points along one axis plus one tenth at either end, relative to the cameras' centroid.
static void range_of_points(const struct vw_scene *scene, const struct axes *axes, int axis, double *sorted,
                            double range[2]) {
    for (uint32_t p = 0; p < scene->point_count; p++)
        sorted[p] = scene->points[p].position_world[axis] - axes->centroid_world[axis];
    vw_sort(sorted, scene->point_count);
    uint32_t strays = (uint32_t)(STRAY_SHARE * scene->point_count);
    double low = sorted[strays], high = sorted[scene->point_count - 1 - strays],
           more = 0.5 * (MARGIN - 1) * (high - low);
    range[0] = low - more;
    range[1] = high + more;
    if (!axes->common_point) return;
    range[0] = fmin(range[0], axes->focus[axis]);
    range[1] = fmax(range[1], axes->focus[axis]);
}

// Leaves the box unchanged if there are too few points, or if they are all in one place.
static enum vw_status box_of_points(const struct vw_scene *scene, const struct axes *axes, struct vw_box *box,
                                    const char **source) {
    if (scene->point_count < POINTS_MIN) return VW_OK;
    double *sorted = vw_allocate(scene->point_count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    struct vw_box found = {0};
    for (int axis = 0; axis < 3; axis++) {
        double range[2];
        range_of_points(scene, axes, axis, sorted, range);
        found.centre_world[axis] = axes->centroid_world[axis] + 0.5 * (range[0] + range[1]);
        found.half_extent_world = fmax(found.half_extent_world, 0.5 * (range[1] - range[0]));
    }
    free(sorted);
    if (!(found.half_extent_world > 0)) return VW_OK;
    *box = found;
    *source = "SfM points: from their 2nd to their 98th percentile, and a tenth more";
    return VW_OK;
}

static struct vw_box box_of_ngp(const struct vw_ngp_box *declared) {
    struct vw_box box = {.half_extent_world = 0.5 * declared->aabb_scale / declared->scale};
    for (int i = 0; i < 3; i++) box.centre_world[i] = (0.5 - declared->offset[i]) / declared->scale;
    return box;
}

// Returns whether a declared box contains what the cameras look at; otherwise it uses other coordinates than the poses.
static bool is_plausible(const struct vw_box *declared, const struct vw_box *seen) {
    for (int i = 0; i < 3; i++)
        if (fabs(seen->centre_world[i] - declared->centre_world[i]) > declared->half_extent_world) return false;
    double ratio = declared->half_extent_world / seen->half_extent_world;
    return ratio >= 0.25 && ratio <= 128;
}

// Sums and products of finite numbers can overflow, and squares of small ones vanish.
static enum vw_status check_box(const struct vw_scene *scene, const struct axes *axes, const struct vw_box *box) {
    const double *centre = box->centre_world, reach_world = axes->reach_world;
    if (reach_world > 0 && reach_world < VW_DISTANCE_LEAST_WORLD)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: positions (field transform_matrix, or translation) differ by %g at most, less than %g; "
                       "scale the scene",
                       scene->path, reach_world, VW_DISTANCE_LEAST_WORLD);
    if (box->half_extent_world >= VW_DISTANCE_LEAST_WORLD && isfinite(box->half_extent_world) && isfinite(centre[0]) &&
        isfinite(centre[1]) && isfinite(centre[2]))
        return VW_OK;
    return vw_fail(
        VW_ERROR_INPUT,
        "%s: camera positions or focal lengths are so large or small that the scene has no box; correct them",
        scene->path);
}

enum vw_status vw_bounds_choose(const struct vw_ngp_box *declared, struct vw_scene *scene) {
    struct axes axes = measure_axes(scene);
    struct vw_box box;
    const char *source;
    enum vw_status status = box_of_cameras(scene, &axes, &box, &source);
    struct vw_box seen = box;
    if (!status) status = box_of_points(scene, &axes, &box, &source);
    if (status) return status;
    char *text = NULL;
    if (declared && declared->aabb_scale > 0) {
        struct vw_box ngp = box_of_ngp(declared);
        if (is_plausible(&ngp, &seen)) {
            box = ngp;
            text = vw_format_text("aabb_scale %g of the scene file (scale %g)", declared->aabb_scale, declared->scale);
        } else {
            status = vw_scene_note(scene, "aabb_scale %g is ignored: its box does not contain what the cameras look at",
                                   declared->aabb_scale);
            if (status) return status;
        }
    }
    status = check_box(scene, &axes, &box);
    if (status) {
        free(text);
        return status;
    }
    if (!text) text = vw_copy_text(source);
    if (!text) return VW_ERROR_MEMORY;
    scene->box = box;
    free(scene->box_source);
    scene->box_source = text;
    return VW_OK;
}

void vw_bounds_focus(const struct vw_scene *scene, double focus_world[3]) {
    struct axes axes = measure_axes(scene);
    for (int i = 0; i < 3; i++)
        focus_world[i] = axes.common_point ? axes.centroid_world[i] + axes.focus[i] : scene->box.centre_world[i];
}

uint32_t vw_scene_count_outside(const struct vw_scene *scene, const struct vw_box *box) {
    uint32_t count = 0;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        bool outside = false;
        for (int i = 0; i < 3; i++)
            outside |= fabs(point->position_world[i] - box->centre_world[i]) > box->half_extent_world;
        if (outside) count += point->track_count;
    }
    return count;
}
