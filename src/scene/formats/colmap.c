#include "scene/formats/colmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "scene/builder.h"

// ---- Points --------------------------------------------------------------------------------------------------------

enum { TRACK_VIEWS_MIN = 2 };

bool vw_colmap_probe(const char *path) {
    char *model_folder = vw_folder_exists(path) ? vw_colmap_find(path) : NULL;
    bool found = model_folder != NULL;
    free(model_folder);
    return found;
}

// ---- Points ----

// Returns the position of a feature in a view's photo, which may have another size than the model's.
static struct vw_track track_in_view(const struct vw_colmap_model *model, const struct vw_colmap_track *track,
                                     uint32_t view_index, const struct vw_scene *scene) {
    const struct vw_colmap_image *image = &model->images[track->image];
    const struct vw_colmap_feature *feature = &model->features[image->first_feature + track->feature];
    const struct vw_camera *given = &model->cameras[image->camera].camera, *camera = &scene->views[view_index].camera;
    return (struct vw_track){
        .view = view_index,
        .x_px = (float)(feature->x_px * camera->width_px / given->width_px),
        .y_px = (float)(feature->y_px * camera->height_px / given->height_px),
    };
}

// Appends a point, unless too few of the scene's views see it. The array has room for it.
static void take_point(const struct vw_colmap_model *model, const struct vw_colmap_point *given, const uint32_t *views,
                       struct vw_scene *scene) {
    struct vw_point point = {.first_track = scene->track_count};
    for (uint64_t t = given->first_track; t < given->first_track + given->track_count; t++) {
        uint32_t view = views[model->tracks[t].image];
        if (view != UINT32_MAX)
            scene->tracks[point.first_track + point.track_count++] =
                track_in_view(model, &model->tracks[t], view, scene);
    }
    if (point.track_count < TRACK_VIEWS_MIN) return;
    memcpy(point.position_world, given->position_world, sizeof point.position_world);
    for (int i = 0; i < 3; i++) point.rgb[i] = (float)given->rgb[i] / 255;
    scene->points[scene->point_count++] = point;
    scene->track_count += point.track_count;
}

enum vw_status vw_colmap_take_points(const struct vw_colmap_model *model, const uint32_t *views,
                                     struct vw_scene *scene) {
    struct vw_point *points = vw_allocate(model->point_count, sizeof *points);
    struct vw_track *tracks = vw_allocate(model->track_count, sizeof *tracks);
    if (!points || !tracks || model->track_count > UINT32_MAX) {
        free(points);
        free(tracks);
        return points && tracks
                   ? vw_fail(VW_ERROR_INPUT, "%zu observations in the COLMAP model; at most %u are supported",
                             model->track_count, UINT32_MAX)
                   : VW_ERROR_MEMORY;
    }
    free(scene->points);
    free(scene->tracks);
    scene->points = points;
    scene->tracks = tracks;
    scene->point_count = scene->track_count = 0;
    for (size_t p = 0; p < model->point_count; p++) take_point(model, &model->points[p], views, scene);
    return vw_near_far_measure(scene);
}

// ---- Views ----

static enum vw_status add_view(struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                               const struct vw_colmap_image *image, const char *name, const char *path) {
    struct vw_camera camera = model->cameras[image->camera].camera;
    struct vw_image_header header;
    bool rescaled = false;
    enum vw_status status = vw_scene_photo_probe(builder, path, &header);
    if (status) return vw_fail_context(status, "image %u: field name", image->id);
    status = vw_camera_fit(path, header.width_px, header.height_px, &camera, &rescaled);
    if (status) return status;
    struct vw_view *view = vw_scene_builder_add_view(builder, name, path, &header);
    if (!view) return VW_ERROR_MEMORY;
    view->camera = camera;
    memcpy(view->camera_to_world, image->camera_to_world, sizeof view->camera_to_world);
    builder->rescaled_count += rescaled;
    return VW_OK;
}

// Leaves *view unchanged if the photo is missing.
static enum vw_status add_image(struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                                const struct vw_colmap_image *image, const char *photo_folder, uint32_t *view) {
    char *name = vw_format_text("%s/%s", photo_folder, image->name);
    char *path = name ? vw_path_join(builder->folder, name) : NULL;
    enum vw_status status = path ? VW_OK : VW_ERROR_MEMORY;
    if (!status && vw_file_exists(path)) {
        status = add_view(builder, model, image, name, path);
        if (!status) *view = builder->scene->view_count - 1;
    } else if (!status) {
        status = vw_scene_builder_count_missing(builder, name);
    }
    free(name);
    free(path);
    return status;
}

enum vw_status vw_colmap_add_views(struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                                   const char *photo_folder, uint32_t *views) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < model->image_count; i++) {
        views[i] = UINT32_MAX;
        status = add_image(builder, model, &model->images[i], photo_folder, &views[i]);
    }
    if (status) return status;
    if (builder->missing_count == model->image_count)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: none of the %zu photos of the COLMAP model exists (first: %s); put them there",
                       builder->folder, model->image_count, builder->missing_name);
    return vw_scene_builder_note_repairs(builder);
}

// ---- The loader ----

static enum vw_status load_model(struct vw_scene_builder *builder, const char *model_folder,
                                 struct vw_colmap_model *model, uint32_t **views) {
    enum vw_status status = vw_colmap_read(model_folder, builder->folder, model);
    if (status) return status;
    *views = vw_allocate(model->image_count, sizeof **views);
    if (!*views) return VW_ERROR_MEMORY;
    bool dense = strstr(model_folder + strlen(builder->folder), "dense/");
    status = vw_colmap_add_views(builder, model, dense ? "dense/images" : "images", *views);
    if (!status) status = vw_colmap_take_points(model, *views, builder->scene);
    return status ? status : vw_bounds_choose(NULL, builder->scene);
}

enum vw_status vw_colmap_load(struct vw_scene_builder *builder) {
    struct vw_colmap_model model = {0};
    uint32_t *views = NULL;
    char *model_folder = vw_colmap_find(builder->folder);
    if (!model_folder)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: no COLMAP model; give a folder whose sparse/0 contains cameras, images and points3D",
                       builder->folder);
    enum vw_status status = load_model(builder, model_folder, &model, &views);
    vw_colmap_clear(&model);
    free(model_folder);
    free(views);
    return status;
}

// ---- Points for other scenes ---------------------------------------------------------------------------------------

// Points of structure from motion beside another scene file. They are used only if they have the same coordinates as
// its cameras: a transforms.json is often rotated, moved and scaled after COLMAP.
static const double ROTATION_TOLERANCE = 1e-3; // difference of matrix entries: 0.06 degrees
static const double POSITION_TOLERANCE = 1e-3; // relative to the cameras' spread
static const double FOCAL_TOLERANCE = 1e-3;    // relative to the focal length, for the same photo size
enum { AGREEING_VIEWS_MIN = 2 };

// Finds the model's image of a photo by its path relative to the scene folder or to images/ in it.
static ptrdiff_t find_image(const struct vw_colmap_model *model, const char *folder, const char *image_path) {
    const char *name = vw_view_name_of(image_path + strlen(folder) + (image_path[strlen(folder)] == '/'));
    ptrdiff_t found = vw_colmap_find_image(model, name);
    if (found < 0 && !strncmp(name, "images/", strlen("images/")))
        found = vw_colmap_find_image(model, name + strlen("images/"));
    return found;
}

// Returns the root mean square distance of the cameras from their centroid.
static double measure_spread(const struct vw_scene *scene) {
    double sum[3] = {0}, square = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int i = 0; i < 3; i++) sum[i] += scene->views[v].camera_to_world[i][3] / scene->view_count;
    for (uint32_t v = 0; v < scene->view_count; v++)
        for (int i = 0; i < 3; i++) square += pow(scene->views[v].camera_to_world[i][3] - sum[i], 2);
    return sqrt(square / scene->view_count);
}

static bool agrees(const struct vw_view *view, const struct vw_colmap_image *image, const struct vw_camera *camera,
                   double spread_world) {
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            if (!(fabs(view->camera_to_world[i][j] - image->camera_to_world[i][j]) <= ROTATION_TOLERANCE)) return false;
        if (!(fabs(view->camera_to_world[i][3] - image->camera_to_world[i][3]) <= POSITION_TOLERANCE * spread_world))
            return false;
    }
    double focal_px = camera->focal_x_px * view->camera.width_px / camera->width_px;
    return fabs(view->camera.focal_x_px - focal_px) <= FOCAL_TOLERANCE * focal_px;
}

// Fills `views` (see vw_colmap_take_points) and decides whether the model's cameras are those of the scene.
static enum vw_status compare(const struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                              uint32_t *views, bool *agree) {
    struct vw_scene *scene = builder->scene;
    double spread_world = measure_spread(scene);
    uint32_t agreeing = 0;
    for (size_t i = 0; i < model->image_count; i++) views[i] = UINT32_MAX;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        ptrdiff_t i = find_image(model, builder->folder, builder->photos[v].image_path);
        if (i < 0) continue;
        const struct vw_colmap_image *image = &model->images[i];
        if (!agrees(view, image, &model->cameras[image->camera].camera, spread_world))
            return vw_scene_note(
                scene, "the points of the COLMAP model beside the scene file are not used: its camera of %s differs",
                view->name);
        views[i] = v;
        agreeing++;
    }
    *agree = agreeing >= AGREEING_VIEWS_MIN;
    return *agree
               ? VW_OK
               : vw_scene_note(
                     scene, "the points of the COLMAP model beside the scene file are not used: it has other photos");
}

static enum vw_status add_points(struct vw_scene_builder *builder, const struct vw_colmap_model *model) {
    bool agree = false;
    uint32_t *views = vw_allocate(model->image_count, sizeof *views);
    if (!views) return VW_ERROR_MEMORY;
    enum vw_status status = compare(builder, model, views, &agree);
    if (!status && agree) status = vw_colmap_take_points(model, views, builder->scene);
    free(views);
    return status;
}

enum vw_status vw_sfm_evidence_find(struct vw_scene_builder *builder) {
    char *model_folder = vw_colmap_find(builder->folder);
    if (!model_folder) return VW_OK;
    struct vw_colmap_model model = {0};
    enum vw_status status = vw_colmap_read(model_folder, builder->folder, &model);
    if (!status) status = add_points(builder, &model);
    vw_colmap_clear(&model);
    free(model_folder);
    return status;
}
