#include "base/hash.h"
#include "base/memory.h"
#include "scene/builder.h"
#include "scene/photo_source.h"
#include "scene/val_weights.h"

static void add_camera(struct vw_hasher *hasher, const struct vw_camera *camera) {
    const double values[] = {camera->focal_x_px, camera->focal_y_px, camera->centre_x_px, camera->centre_y_px,
                             camera->k1,         camera->k2,         camera->k3,          camera->k4,
                             camera->k5,         camera->k6,         camera->p1,          camera->p2};
    vw_hasher_add_integer(hasher, camera->width_px);
    vw_hasher_add_integer(hasher, camera->height_px);
    vw_hasher_add_integer(hasher, camera->lens);
    for (size_t i = 0; i < VW_ARRAY_COUNT(values); i++) vw_hasher_add_real(hasher, values[i]);
}

static void add_view(struct vw_hasher *hasher, const struct vw_view *view) {
    vw_hasher_add_text(hasher, view->name);
    vw_hasher_add_text(hasher, vw_split_name(view->split));
    vw_hasher_add_bytes(hasher, view->sha256, sizeof view->sha256);
    if (view->mask) vw_hasher_add_bytes(hasher, view->mask, (size_t)view->image.width_px * view->image.height_px);
    else vw_hasher_add_null(hasher);
    add_camera(hasher, &view->camera);
    vw_hasher_add_real(hasher, view->near_world);
    vw_hasher_add_real(hasher, view->far_world);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) vw_hasher_add_real(hasher, view->camera_to_world[i][j]);
}

// Adds what splats begin at, and what exposures are estimated from: points, which views see them, and where.
static void add_points(struct vw_hasher *hasher, const struct vw_scene *scene) {
    vw_hasher_add_integer(hasher, scene->point_count);
    for (uint32_t i = 0; i < scene->point_count; i++) {
        const struct vw_point *point = &scene->points[i];
        for (int axis = 0; axis < 3; axis++) vw_hasher_add_real(hasher, point->position_world[axis]);
        for (int channel = 0; channel < 3; channel++) vw_hasher_add_real(hasher, point->rgb[channel]);
        vw_hasher_add_integer(hasher, point->track_count);
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &scene->tracks[point->first_track + t];
            vw_hasher_add_integer(hasher, track->view);
            vw_hasher_add_real(hasher, track->x_px);
            vw_hasher_add_real(hasher, track->y_px);
        }
    }
}

// Adds nothing when all validation photos weigh the same.
static void add_weights(struct vw_hasher *hasher, const struct vw_scene *scene) {
    if (!vw_scene_has_weights(scene)) return;
    vw_hasher_add_text(hasher, "weights");
    for (uint32_t v = 0; v < scene->view_count; v++) vw_hasher_add_real(hasher, scene->views[v].weight);
}

// Adds nothing where there are no features.
static void add_features(struct vw_hasher *hasher, const struct vw_scene *scene) {
    for (uint32_t v = 0; v < scene->view_count && scene->source; v++) {
        const struct vw_scene_builder_photo *photo = &scene->source->photos[v];
        if (!photo->features_path) continue;
        vw_hasher_add_integer(hasher, v);
        vw_hasher_add_bytes(hasher, photo->features_sha256, sizeof photo->features_sha256);
    }
}

void vw_scene_hash(const struct vw_scene *scene, uint32_t downscale, uint8_t hash[VW_HASH_BYTES]) {
    struct vw_hasher hasher;
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, "viewworth scene 4");
    vw_hasher_add_integer(&hasher, downscale > 1 ? downscale : 1);
    vw_hasher_add_integer(&hasher, scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++) add_view(&hasher, &scene->views[v]);
    for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, scene->box.centre_world[i]);
    vw_hasher_add_real(&hasher, scene->box.half_extent_world);
    for (int i = 0; i < 3; i++) vw_hasher_add_real(&hasher, scene->background[i]);
    add_points(&hasher, scene);
    add_weights(&hasher, scene);
    add_features(&hasher, scene);
    vw_hasher_end(&hasher, hash);
}
