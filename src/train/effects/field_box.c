// The inner region is a ball around what cameras and points have in common: its centre lies midway between the median
// camera and the median of the points nearer to it than half of them, its radius reaches nearly all cameras and half of
// the points. So it contains a courtyard with its cameras as well as a facade that all cameras face, however far the
// horizon is. Medians and quantiles, since one camera that was placed wrongly, or points at the horizon, must not
// shrink everything else.
//
// A box that is smaller says where detail is wanted, be it declared, or found in cameras that look inwards: it stays.
#include "train/effects/field_box.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "train/pixels.h"

static const double CAMERA_SHARE = 0.95, POINT_SHARE = 0.5; // within the ball
static const double MARGIN = 1.1;
enum { POINTS_MIN = 64 }; // as for the scene's box: fewer tell less than the cameras do

struct place {
    const double *world[3]; // coordinates, in a view's pose or a point
    double key;             // places are sorted by it
    uint32_t index;         // and then by this, so that equal keys keep their order
};

static int compare_places(const void *a, const void *b) {
    const struct place *left = a, *right = b;
    if (left->key != right->key) return left->key > right->key ? 1 : -1;
    return (left->index > right->index) - (left->index < right->index);
}

static void median_place(struct place *places, uint32_t count, double median[3]) {
    for (int axis = 0; axis < 3; axis++) {
        for (uint32_t i = 0; i < count; i++) places[i].key = *places[i].world[axis];
        qsort(places, count, sizeof *places, compare_places);
        median[axis] = 0.5 * (places[(count - 1) / 2].key + places[count / 2].key);
    }
}

// Sorts by the distance from a point, and returns the distance within which a share of the places lies.
static double reach(struct place *places, uint32_t count, const double from_world[3], double share) {
    for (uint32_t i = 0; i < count; i++) {
        const double *const *world = places[i].world;
        places[i].key = hypot(hypot(*world[0] - from_world[0], *world[1] - from_world[1]), *world[2] - from_world[2]);
    }
    qsort(places, count, sizeof *places, compare_places);
    return count ? places[(uint32_t)(share * (count - 1))].key : 0.0;
}

// Returns whether a view counts. Views that a training leaves out do not move its box.
static bool is_used(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count, uint32_t view) {
    enum vw_split split = scene->views[view].split;
    for (uint32_t i = 0; train_views && i < train_count; i++)
        if (train_views[i] == view) return true;
    return split == VW_SPLIT_VAL || split == VW_SPLIT_TEST || (split == VW_SPLIT_TRAIN && !train_views);
}

static uint32_t list_cameras(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count,
                             struct place *places) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const double(*pose)[4] = scene->views[v].camera_to_world;
        if (!is_used(scene, train_views, train_count, v)) continue;
        places[count++] = (struct place){.world = {&pose[0][3], &pose[1][3], &pose[2][3]}, .index = v};
    }
    return count;
}

static uint32_t list_points(const struct vw_scene *scene, struct place *places) {
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const double *position = scene->points[p].position_world;
        places[p] = (struct place){.world = {&position[0], &position[1], &position[2]}, .index = p};
    }
    return scene->point_count < POINTS_MIN ? 0 : scene->point_count;
}

static struct vw_box inner_ball(struct place *cameras, uint32_t camera_count, struct place *points,
                                uint32_t point_count) {
    struct vw_box ball = {0};
    double points_middle[3];
    median_place(cameras, camera_count, ball.centre_world);
    if (point_count) {
        reach(points, point_count, ball.centre_world, POINT_SHARE); // nearest first
        median_place(points, (point_count + 1) / 2, points_middle);
        for (int i = 0; i < 3; i++) ball.centre_world[i] += 0.5 * (points_middle[i] - ball.centre_world[i]);
    }
    double of_cameras = reach(cameras, camera_count, ball.centre_world, CAMERA_SHARE);
    ball.half_extent_world = MARGIN * fmax(of_cameras, reach(points, point_count, ball.centre_world, POINT_SHARE));
    return ball;
}

enum vw_status vw_contraction_box(const struct vw_scene *scene, const uint32_t *train_views, uint32_t train_count,
                                  struct vw_box *box) {
    struct place *cameras = vw_allocate(scene->view_count, sizeof *cameras);
    struct place *points = vw_allocate(scene->point_count, sizeof *points);
    enum vw_status status = cameras && points ? VW_OK : VW_ERROR_MEMORY;
    *box = scene->box;
    uint32_t camera_count = status ? 0 : list_cameras(scene, train_views, train_count, cameras),
             point_count = status ? 0 : list_points(scene, points);
    if (camera_count) {
        struct vw_box ball = inner_ball(cameras, camera_count, points, point_count);
        if (ball.half_extent_world > 0.0 && ball.half_extent_world < scene->box.half_extent_world) *box = ball;
    }
    free(cameras);
    free(points);
    return status;
}

// ---- Depths ---------------------------------------------------------------------------------------------------------

// In box edges; the inner region's radius is half of one. Of samples spaced in disparity from a near distance n on, 1 -
// 2 n lie within half an edge of the camera. So n decides how many are left for the rest: at 1/16 four of 32, at 1/8
// eight.
static const double NEAR_LEAST_EDGES = 1.0 / 16.0, NEAR_EDGES = 1.0 / 8.0;
// Beyond the centre. What lies farther moves by less than 1 / 8000 of the field's cube, half a cell of its finest
// grids.
static const double FAR_EDGES = 1000.0;

// Returns how near a view sees. Where points tell, they are believed down to the least distance. Otherwise half of the
// space between a camera and the inner region is assumed to be empty: cameras that surround a scene look at what lies
// within.
static double near_edges(const struct vw_view *view, double edge_world, double distance_edges) {
    if (view->far_world > 0.0) return fmax(PIXELS_NEAR_MARGIN * view->near_world / edge_world, NEAR_LEAST_EDGES);
    return fmax(0.5 * (distance_edges - 0.5), NEAR_EDGES);
}

void vw_contraction_set_depths(const struct vw_view *view, const struct vw_box *box, struct vw_gpu_camera *camera) {
    double edge_world = 2.0 * box->half_extent_world, distance2 = 0.0;
    for (int i = 0; i < 3; i++)
        distance2 += pow((view->camera_to_world[i][3] - box->centre_world[i]) / edge_world, 2.0);
    double near = near_edges(view, edge_world, sqrt(distance2));
    double far = fmax(PIXELS_FAR_MARGIN * view->far_world / edge_world, sqrt(distance2) + FAR_EDGES);
    camera->more.y = (float)near;
    camera->more.z = (float)fmax(near, far);
}

// ---- The effect wide_box --------------------------------------------------------------------------------------------

static const double SHARE = 0.99, LEAST = 1.0, MOST = 4.0, WITHOUT_POINTS = 2.0;

// Returns the distance from the box's centre, in its half extents; by the largest coordinate, since the box is a cube.
static double distance_of(const struct vw_point *point, const struct vw_box *box) {
    double most = 0.0;
    for (int i = 0; i < 3; i++) most = fmax(most, fabs(point->position_world[i] - box->centre_world[i]));
    return most / box->half_extent_world;
}

enum vw_status vw_wide_box(const struct vw_scene *scene, struct vw_box *box) {
    double widening = WITHOUT_POINTS;
    if (scene->point_count >= POINTS_MIN && scene->track_count) {
        double *distances = vw_allocate(scene->track_count, sizeof *distances);
        uint32_t count = 0;
        if (!distances) return VW_ERROR_MEMORY;
        for (uint32_t p = 0; p < scene->point_count; p++)
            for (uint32_t t = 0; t < scene->points[p].track_count; t++)
                distances[count++] = distance_of(&scene->points[p], &scene->box);
        vw_sort(distances, count);
        if (count) widening = MARGIN * vw_quantile_of_sorted(distances, count, SHARE);
        free(distances);
    }
    *box = scene->box;
    box->half_extent_world *= fmin(fmax(widening, LEAST), MOST);
    return VW_OK;
}
