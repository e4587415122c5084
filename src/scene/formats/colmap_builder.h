// A COLMAP model while it is read. colmap_files.c parses files; this builder interprets and checks the numbers. Its
// messages name the record and the field; colmap_files.c adds the file, and the line of a text file.
#ifndef VIEWWORTH_SCENE_FORMATS_COLMAP_BUILDER_H
#define VIEWWORTH_SCENE_FORMATS_COLMAP_BUILDER_H

#include "scene/formats/colmap.h"

enum { COLMAP_PARAMS_MAX = 12 };
enum colmap_file { COLMAP_CAMERAS, COLMAP_IMAGES, COLMAP_POINTS, COLMAP_FILES };

struct colmap_builder {
    struct vw_colmap_model *model;
    const char *scene_folder; // no file may be outside of it
    size_t camera_capacity, image_capacity, feature_capacity, point_capacity, track_capacity;
    struct colmap_id *camera_ids,
        *image_ids;      // owned; sorted; of the model's cameras and images, once their file is read
    uint64_t *point_ids; // owned; in the order of the points
    size_t point_id_capacity;
};

// The index of the camera or image with an id.
struct colmap_id {
    uint32_t id, index;
};

struct colmap_image_fields {
    uint32_t id, camera_id;
    double rotation[4];    // quaternion w x y z, world to camera
    double translation[3]; // world to camera
    const char *name;
};

struct colmap_point_fields {
    uint64_t id;
    double position_world[3], error_px;
    uint8_t rgb[3];
};

// The model with that number or name; refused if it is not supported. `camera` is the id for messages.
struct colmap_camera_model;
enum vw_status colmap_camera_model_by_id(uint32_t camera, int32_t id, const struct colmap_camera_model **model);
enum vw_status colmap_camera_model_by_name(uint32_t camera, const char *name, const struct colmap_camera_model **model);
uint32_t colmap_camera_param_count(const struct colmap_camera_model *model);
enum vw_status colmap_camera_make(uint32_t camera, const struct colmap_camera_model *model, uint64_t width_px,
                                  uint64_t height_px, const double params[COLMAP_PARAMS_MAX], struct vw_camera *made);
// Returns the number of params of the first model that has this camera, with its number and their values.
uint32_t colmap_camera_params(const struct vw_camera *camera, int32_t *id, double params[COLMAP_PARAMS_MAX]);

// Adds one record after another (colmap_builder.c). Features and tracks belong to the image or point added last.
enum vw_status colmap_add_camera(struct colmap_builder *builder, uint32_t id, const struct vw_camera *camera);
enum vw_status colmap_add_image(struct colmap_builder *builder, const struct colmap_image_fields *fields);
enum vw_status colmap_add_feature(struct colmap_builder *builder, double x_px, double y_px);
enum vw_status colmap_add_point(struct colmap_builder *builder, const struct colmap_point_fields *fields);
enum vw_status colmap_add_track(struct colmap_builder *builder, uint32_t image_id, uint32_t feature);
// Checks what only a whole file shows: that it has records, and that their ids differ.
enum vw_status colmap_file_done(struct colmap_builder *builder, enum colmap_file file);
void colmap_builder_clear(struct colmap_builder *builder); // its own memory, not the model's

#endif
