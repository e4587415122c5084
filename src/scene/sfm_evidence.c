// Points of structure from motion beside another scene file. They are used only if they have the same coordinates as
// its cameras: a transforms.json is often rotated, moved and scaled after COLMAP.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "scene/builder.h"
#include "scene/formats/colmap.h"

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
