// COLMAP models written by a test, as binary or as text, without any code of the reader.
#ifndef VIEWWORTH_TESTS_SUPPORT_COLMAP_FILES_H
#define VIEWWORTH_TESTS_SUPPORT_COLMAP_FILES_H

#include <stddef.h>
#include <stdint.h>

struct colmap_test_camera {
    uint32_t id;
    int32_t model;          // COLMAP's number
    const char *model_name; // as the text files spell it
    uint64_t width_px, height_px;
    int param_count;
    double params[12];
};

enum { COLMAP_TEST_FEATURES = 4, COLMAP_TEST_TRACKS = 4 };

struct colmap_test_image {
    uint32_t id, camera_id;
    const char *name;
    double rotation[4], translation[3]; // world to camera; w x y z
    uint64_t feature_count;
    double features[COLMAP_TEST_FEATURES][2];
};

struct colmap_test_point {
    uint64_t id;
    double position[3], error;
    uint8_t rgb[3];
    uint64_t track_count;
    uint32_t tracks[COLMAP_TEST_TRACKS][2]; // image id, feature
};

struct colmap_test_model {
    struct colmap_test_camera cameras[8];
    struct colmap_test_image images[8];
    struct colmap_test_point points[8];
    size_t camera_count, image_count, point_count;
};

// Returns a scene of three photos (images/a.png, b.png, "sub/c d.png" of 8 x 6 pixels, written by tiny_photo_write),
// two cameras and two points that differ in every number. Writes the photos only.
struct colmap_test_model colmap_test_scene(const char *scene_folder);
// Writes cameras, images and points3D into scene_folder/model_folder.
void colmap_write_binary(const char *scene_folder, const char *model_folder, const struct colmap_test_model *model);
void colmap_write_text(const char *scene_folder, const char *model_folder, const struct colmap_test_model *model);

// PhotoTourism folders: cameras side by side at (i, 0, 0) that look along -z, with image ids from 10 on, for photos of
// these names, and two points that the first three see.
enum { DENSE_PHOTOS = 8 };
struct colmap_test_model colmap_dense_model(const char *const names[DENSE_PHOTOS]);
void colmap_write_photos(const char *scene_folder, const char *photo_folder, const char *const names[DENSE_PHOTOS]);
// Writes photos and model below scene_folder/dense, and splits.tsv.
void colmap_write_dense(const char *scene_folder, const char *const names[DENSE_PHOTOS], const char *tsv);

#endif
