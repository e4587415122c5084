// COLMAP models: cameras, images and points3D, binary or text, in sparse/0, sparse/ or dense/sparse.
//
// vw_colmap_read() reads and checks a model; vw_colmap_load() makes a scene from it. PhotoTourism scenes use a model
// for poses and points, transforms.json scenes for points.
#ifndef VIEWWORTH_SCENE_FORMATS_COLMAP_H
#define VIEWWORTH_SCENE_FORMATS_COLMAP_H

#include "scene/name_index.h"
#include "viewworth/scene.h"

struct vw_scene_builder;

// The camera of an image, for the photo size that the model was made with.
struct vw_colmap_camera {
    uint32_t id;
    struct vw_camera camera; // all numbers finite; sizes and focal lengths above 0
};

// A feature of an image. In COLMAP as in viewworth, the centre of the top left pixel is (0.5, 0.5).
struct vw_colmap_feature {
    double x_px, y_px;
};

struct vw_colmap_image {
    uint32_t id;
    char *name;      // owned; relative to the folder of the photos; safe (see vw_path_leaves_folder) and unique
    uint32_t camera; // index in cameras
    double camera_to_world[3][4];          // OpenGL axes, as in vw_view
    uint64_t first_feature, feature_count; // range in features
};

// An observation: an image's feature shows a point.
struct vw_colmap_track {
    uint32_t image;   // index in images
    uint32_t feature; // index among the image's features
};

struct vw_colmap_point {
    double position_world[3]; // finite
    uint8_t rgb[3];
    double error_px;                   // mean reprojection error as COLMAP wrote it; below 0: unknown
    uint64_t first_track, track_count; // range in tracks
};

// A model in the order of its files. Everything in it has been checked: ids and names are unique, indices are in range.
struct vw_colmap_model {
    struct vw_colmap_camera *cameras;   // owned
    struct vw_colmap_image *images;     // owned
    struct vw_colmap_feature *features; // owned
    struct vw_colmap_point *points;     // owned
    struct vw_colmap_track *tracks;     // owned
    struct vw_name_index names;         // owned; of the images
    size_t camera_count, image_count, feature_count, point_count, track_count;
};

// Finds the folder of the model in a scene folder, owned by the caller: the first of sparse/0, sparse, dense/sparse/0
// and dense/sparse that has cameras.bin or cameras.txt. NULL if there is none (without a message).
char *vw_colmap_find(const char *scene_folder);

// Reads a model; binary files take precedence over text. Refuses model files and image names that leave `scene_folder`,
// also through links. Does not check whether the photos exist. VW_ERROR_INPUT with one line that names file and field;
// `*model` is then unchanged. The caller frees the model with vw_colmap_clear().
enum vw_status vw_colmap_read(const char *model_folder, const char *scene_folder, struct vw_colmap_model *model);
// Frees what a model owns and empties it; accepts an empty or half-read one.
void vw_colmap_clear(struct vw_colmap_model *model);

// Returns the index in images of the one with that name (a leading "./" is ignored); -1 when the model has none.
ptrdiff_t vw_colmap_find_image(const struct vw_colmap_model *model, const char *name);

// Appends a view for each image whose photo is in `photo_folder` (for example "images"), which is relative to the scene
// folder. The view's name is photo_folder/image name. Cameras are fitted to photos of another size. views[i] becomes
// the view of image i, UINT32_MAX if its photo is missing. Adds notes on missing and rescaled photos. VW_ERROR_INPUT
// if no photo exists.
enum vw_status vw_colmap_add_views(struct vw_scene_builder *builder, const struct vw_colmap_model *model,
                                   const char *photo_folder, uint32_t *views);

// Copies the model's points into the scene, replacing its points, and measures near and far of its views from them.
// Image i is view views[i] of the scene; UINT32_MAX: none. Feature positions are scaled from the model's camera to the
// view's, which may have another size of the same shape. Points that fewer than two views see are left out. Call it
// after all views are there and before --downscale is applied.
enum vw_status vw_colmap_take_points(const struct vw_colmap_model *model, const uint32_t *views,
                                     struct vw_scene *scene);

#endif
