#include "lab/methods/photo_sightings.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

enum { PLACES_MOST = 4096, RAYS_PER_SIDE_MOST = 8 }; // limits of places on rays, and of rays of a photo
enum { NOT_VALUED = -1, VALIDATES = -2 };

struct work {
    const struct vw_scene *scene;
    uint32_t photo_count;
    int64_t *numbers;       // by view: its place among the photos, VALIDATES or NOT_VALUED
    uint32_t *seers;        // scratch: views that see a place
    uint32_t *last_points;  // by view: 1 + the last point that it was found to see
    uint32_t *place_counts; // by photo: places that it sees
    uint32_t validated;     // places that validation photos see
    struct vw_photo_sightings *sightings;
};

// ---- Projection ----

static void turn_to_camera(const struct vw_view *view, const double position_world[3], double direction[3]) {
    for (int j = 0; j < 3; j++) {
        direction[j] = 0;
        for (int i = 0; i < 3; i++)
            direction[j] += view->camera_to_world[i][j] * (position_world[i] - view->camera_to_world[i][3]);
    }
}

bool vw_view_project(const struct vw_view *view, const double position_world[3], double *x_px, double *y_px,
                     double *depth_world) {
    double direction[3];
    turn_to_camera(view, position_world, direction);
    if (depth_world) *depth_world = -direction[2];
    // Beyond the reach of the lens model, its polynomial folds back into the photo.
    double out = hypot(direction[0], direction[1]) / -direction[2], inverse[3];
    if (!vw_camera_project(&view->camera, direction, x_px, y_px)) return false;
    if (!(*x_px >= 0 && *x_px < view->camera.width_px && *y_px >= 0 && *y_px < view->camera.height_px)) return false;
    return !vw_camera_is_distorted(&view->camera) || (vw_camera_unproject(&view->camera, *x_px, *y_px, inverse) &&
                                                      fabs(hypot(inverse[0], inverse[1]) - out) <= 1e-3 * fmax(1, out));
}

static double reprojection_error(const struct vw_view *view, const struct vw_point *point,
                                 const struct vw_track *track) {
    double direction[3], x_px, y_px, most = hypot(view->camera.width_px, view->camera.height_px);
    turn_to_camera(view, point->position_world, direction);
    if (!vw_camera_project(&view->camera, direction, &x_px, &y_px)) return most;
    return fmin(hypot(x_px - track->x_px, y_px - track->y_px), most);
}

// ---- Places ----

static void add_place(struct work *work, uint32_t seer_count) {
    uint32_t trained = 0, validated = 0, val_count = work->scene->split_count[VW_SPLIT_VAL];
    for (uint32_t i = 0; i < seer_count; i++) {
        trained += work->numbers[work->seers[i]] >= 0;
        validated += work->numbers[work->seers[i]] == VALIDATES;
    }
    work->validated += validated > 0;
    for (uint32_t i = 0; i < seer_count; i++) {
        if (work->numbers[work->seers[i]] < 0) continue;
        uint32_t photo = (uint32_t)work->numbers[work->seers[i]];
        struct vw_photo_sightings *sightings = &work->sightings[photo];
        work->place_counts[photo]++;
        sightings->overlap_train += (trained - 1.0) / (work->photo_count - 1.0);
        sightings->overlap_val += validated / (double)val_count;
        if (validated) sightings->coverage += 1.0 / trained;
    }
}

static void add_points(struct work *work) {
    const struct vw_scene *scene = work->scene;
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        uint32_t count = 0;
        for (uint32_t t = 0; t < point->track_count; t++) {
            uint32_t view = scene->tracks[point->first_track + t].view;
            if (work->last_points[view] == p + 1) continue; // a file may list a point several times in one photo
            work->last_points[view] = p + 1;
            work->seers[count++] = view;
        }
        add_place(work, count);
    }
}

static double depth_of_box(const struct vw_scene *scene, const struct vw_view *view) {
    double depth = 0;
    for (int i = 0; i < 3; i++)
        depth -= (scene->box.centre_world[i] - view->camera_to_world[i][3]) * view->camera_to_world[i][2];
    return fmax(depth, scene->box.half_extent_world); // also if the view looks away
}

static bool place_on_ray(const struct vw_scene *scene, const struct vw_view *view, double x_px, double y_px,
                         double position_world[3]) {
    double direction[3], depth = depth_of_box(scene, view);
    if (!vw_camera_unproject(&view->camera, x_px, y_px, direction)) return false;
    for (int i = 0; i < 3; i++) {
        position_world[i] = view->camera_to_world[i][3];
        for (int j = 0; j < 3; j++) position_world[i] += depth * view->camera_to_world[i][j] * direction[j];
    }
    return true;
}

static void add_position(struct work *work, const double position_world[3]) {
    double x_px, y_px;
    uint32_t count = 0;
    for (uint32_t v = 0; v < work->scene->view_count; v++)
        if (work->numbers[v] != NOT_VALUED &&
            vw_view_project(&work->scene->views[v], position_world, &x_px, &y_px, NULL))
            work->seers[count++] = v;
    add_place(work, count);
}

static void add_rays(struct work *work) {
    const struct vw_scene *scene = work->scene;
    uint32_t views = work->photo_count + scene->split_count[VW_SPLIT_VAL];
    uint32_t side = (uint32_t)sqrt((double)PLACES_MOST / views);
    side = side < 1 ? 1 : side > RAYS_PER_SIDE_MOST ? RAYS_PER_SIDE_MOST : side;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (uint32_t ray = 0; work->numbers[v] != NOT_VALUED && ray < side * side; ray++) {
            const struct vw_camera *camera = &scene->views[v].camera;
            double position_world[3], x_px = (ray % side + 0.5) * camera->width_px / side,
                                      y_px = (double)(ray / side * 2 + 1) * camera->height_px / (2 * side);
            if (place_on_ray(scene, &scene->views[v], x_px, y_px, position_world)) add_position(work, position_world);
        }
}

// ---- Reprojection ----

// Sorts the errors by photo.
static enum vw_status find_reprojection(struct work *work) {
    const struct vw_scene *scene = work->scene;
    uint32_t *ends = vw_allocate((size_t)work->photo_count + 1, sizeof *ends);
    double *errors = vw_allocate(scene->track_count, sizeof *errors);
    enum vw_status status = ends && errors ? VW_OK : VW_ERROR_MEMORY;
    for (int filling = 0; !status && filling < 2; filling++) {
        for (uint32_t p = 0; p < scene->point_count; p++)
            for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
                const struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
                int64_t photo = work->numbers[track->view];
                if (photo < 0) continue;
                if (filling)
                    errors[ends[photo]] = reprojection_error(&scene->views[track->view], &scene->points[p], track);
                ends[photo + !filling]++;
            }
        for (uint32_t i = 1; !filling && i <= work->photo_count; i++) ends[i] += ends[i - 1];
    }
    for (uint32_t i = 0; !status && i < work->photo_count; i++) {
        uint32_t first = i ? ends[i - 1] : 0, count = ends[i] - first;
        double sum = 0;
        for (uint32_t j = 0; j < count; j++) sum += errors[first + j];
        work->sightings[i].points = count;
        work->sightings[i].reprojection_mean_px = count ? sum / count : NAN;
        work->sightings[i].reprojection_median_px = vw_median(errors + first, count);
    }
    free(errors);
    free(ends);
    return status;
}

// ---- All of it ----

static void take_means(struct work *work) {
    for (uint32_t i = 0; i < work->photo_count; i++) {
        struct vw_photo_sightings *sightings = &work->sightings[i];
        double places = work->place_counts[i] ? work->place_counts[i] : 1;
        sightings->overlap_train = work->photo_count > 1 ? sightings->overlap_train / places : NAN;
        sightings->overlap_val = work->scene->split_count[VW_SPLIT_VAL] ? sightings->overlap_val / places : NAN;
        sightings->coverage = work->validated ? sightings->coverage / work->validated : NAN;
    }
}

enum vw_status vw_photo_sightings_find(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                       struct vw_photo_sightings *sightings) {
    struct work work = {.scene = scene,
                        .photo_count = photo_count,
                        .numbers = vw_allocate(scene->view_count, sizeof *work.numbers),
                        .seers = vw_allocate(scene->view_count, sizeof *work.seers),
                        .last_points = vw_allocate(scene->view_count, sizeof *work.last_points),
                        .place_counts = vw_allocate(photo_count, sizeof *work.place_counts),
                        .sightings = sightings};
    enum vw_status status =
        work.numbers && work.seers && work.last_points && work.place_counts ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; !status && v < scene->view_count; v++)
        work.numbers[v] = scene->views[v].split == VW_SPLIT_VAL ? VALIDATES : NOT_VALUED;
    for (uint32_t i = 0; !status && i < photo_count; i++) {
        work.numbers[photos[i]] = i;
        sightings[i] = (struct vw_photo_sightings){0};
    }
    if (!status && scene->point_count) add_points(&work);
    else if (!status) add_rays(&work);
    if (!status) take_means(&work);
    if (!status) status = find_reprojection(&work);
    free(work.numbers);
    free(work.seers);
    free(work.last_points);
    free(work.place_counts);
    return status;
}
