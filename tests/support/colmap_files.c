#include "support/colmap_files.h"
#include "support/cmocka_test.h"

#include "base/file.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

// Makes the rotation by `angle` about an axis of any length.
static void turn(double angle, double x, double y, double z, double rotation[4]) {
    double scale = sin(angle / 2) / sqrt(x * x + y * y + z * z);
    rotation[0] = cos(angle / 2);
    rotation[1] = x * scale;
    rotation[2] = y * scale;
    rotation[3] = z * scale;
}

struct colmap_test_model colmap_test_scene(const char *scene_folder) {
    struct colmap_test_model model = {
        .camera_count = 2,
        .cameras = {{7, 4, "OPENCV", 8, 6, 8, {9.5, 9.25, 4.125, 2.875, -0.125, 0.0625, 0.01, -0.02}},
                    {3, 2, "SIMPLE_RADIAL", 16, 12, 4, {20.5, 8.25, 5.75, -0.03125}}},
        .image_count = 3,
        .images = {{12, 7, "a.png", .translation = {0.1, -0.2, 3}, .feature_count = 3,
                    .features = {{1.5, 2.5}, {3.25, 4.75}, {7, 0.5}}},
                   {4, 3, "b.png", .translation = {-0.7, 0.3, 4}, .feature_count = 2,
                    .features = {{10.5, 2.25}, {3, 11}}},
                   {9, 7, "sub/c d.png", .translation = {0.4, 0.5, 5}}},
        .point_count = 2,
        .points = {{5, {0.25, -0.5, 1.25}, 0.75, {10, 200, 255}, 2, {{12, 1}, {4, 0}}},
                   {1ull << 40, {-1.5, 0.125, 2}, 1.5, {0, 1, 2}, 2, {{4, 1}, {12, 2}}}},
    };
    turn(0.3, 1, 2, 3, model.images[0].rotation);
    turn(-1.1, 0, 1, 0.2, model.images[1].rotation);
    turn(2.5, -0.3, 0.4, 1, model.images[2].rotation);
    tiny_photo_write(temporary_path(scene_folder, "images/a.png"), 1);
    tiny_photo_write(temporary_path(scene_folder, "images/b.png"), 2);
    tiny_photo_write(temporary_path(scene_folder, "images/sub/c d.png"), 3);
    return model;
}

static FILE *create(const char *scene_folder, const char *model_folder, const char *name) {
    char folder[4096];
    snprintf(folder, sizeof folder, "%s", temporary_path(scene_folder, model_folder));
    assert_int_equal(vw_folder_create(folder), VW_OK);
    FILE *file = fopen(temporary_path(folder, name), "wb");
    assert_non_null(file);
    return file;
}

static void put(FILE *file, const void *value, size_t size_bytes) {
    assert_int_equal(fwrite(value, 1, size_bytes, file), size_bytes);
}
static void put_u32(FILE *file, uint32_t value) { put(file, &value, sizeof value); }
static void put_u64(FILE *file, uint64_t value) { put(file, &value, sizeof value); }
static void put_reals(FILE *file, const double *values, size_t count) { put(file, values, count * sizeof *values); }

void colmap_write_binary(const char *scene_folder, const char *model_folder, const struct colmap_test_model *model) {
    FILE *file = create(scene_folder, model_folder, "cameras.bin");
    put_u64(file, model->camera_count);
    for (size_t i = 0; i < model->camera_count; i++) {
        const struct colmap_test_camera *camera = &model->cameras[i];
        put_u32(file, camera->id);
        put_u32(file, (uint32_t)camera->model);
        put_u64(file, camera->width_px);
        put_u64(file, camera->height_px);
        put_reals(file, camera->params, (size_t)camera->param_count);
    }
    assert_int_equal(fclose(file), 0);
    file = create(scene_folder, model_folder, "images.bin");
    put_u64(file, model->image_count);
    for (size_t i = 0; i < model->image_count; i++) {
        const struct colmap_test_image *image = &model->images[i];
        put_u32(file, image->id);
        put_reals(file, image->rotation, 4);
        put_reals(file, image->translation, 3);
        put_u32(file, image->camera_id);
        fprintf(file, "%s%c", image->name, 0);
        put_u64(file, image->feature_count);
        for (size_t k = 0; k < image->feature_count; k++) {
            put_reals(file, image->features[k], 2);
            put_u64(file, UINT64_MAX);
        }
    }
    assert_int_equal(fclose(file), 0);
    file = create(scene_folder, model_folder, "points3D.bin");
    put_u64(file, model->point_count);
    for (size_t i = 0; i < model->point_count; i++) {
        const struct colmap_test_point *point = &model->points[i];
        put_u64(file, point->id);
        put_reals(file, point->position, 3);
        put(file, point->rgb, 3);
        put_reals(file, &point->error, 1);
        put_u64(file, point->track_count);
        put(file, point->tracks, point->track_count * sizeof point->tracks[0]);
    }
    assert_int_equal(fclose(file), 0);
}

static void print_reals(FILE *file, const double *values, int count) {
    for (int i = 0; i < count; i++) fprintf(file, " %.17g", values[i]);
}

void colmap_write_text(const char *scene_folder, const char *model_folder, const struct colmap_test_model *model) {
    FILE *file = create(scene_folder, model_folder, "cameras.txt");
    fprintf(file, "# Camera list\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n");
    for (size_t i = 0; i < model->camera_count; i++) {
        const struct colmap_test_camera *camera = &model->cameras[i];
        fprintf(file, "%u %s %llu %llu", camera->id, camera->model_name, (unsigned long long)camera->width_px,
                (unsigned long long)camera->height_px);
        print_reals(file, camera->params, camera->param_count);
        fprintf(file, "\n");
    }
    assert_int_equal(fclose(file), 0);
    file = create(scene_folder, model_folder, "images.txt");
    fprintf(file, "# Image list with two lines of data per image\n");
    for (size_t i = 0; i < model->image_count; i++) {
        const struct colmap_test_image *image = &model->images[i];
        fprintf(file, "%u", image->id);
        print_reals(file, image->rotation, 4);
        print_reals(file, image->translation, 3);
        fprintf(file, " %u %s\n", image->camera_id, image->name);
        for (size_t k = 0; k < image->feature_count; k++) {
            print_reals(file, image->features[k], 2);
            fprintf(file, " -1");
        }
        fprintf(file, "\n");
    }
    assert_int_equal(fclose(file), 0);
    file = create(scene_folder, model_folder, "points3D.txt");
    for (size_t i = 0; i < model->point_count; i++) {
        const struct colmap_test_point *point = &model->points[i];
        fprintf(file, "%llu", (unsigned long long)point->id);
        print_reals(file, point->position, 3);
        fprintf(file, " %u %u %u %.17g", point->rgb[0], point->rgb[1], point->rgb[2], point->error);
        for (size_t k = 0; k < point->track_count; k++)
            fprintf(file, " %u %u", point->tracks[k][0], point->tracks[k][1]);
        fprintf(file, "\n");
    }
    assert_int_equal(fclose(file), 0);
}

struct colmap_test_model colmap_dense_model(const char *const names[DENSE_PHOTOS]) {
    struct colmap_test_model model = {
        .cameras = {{1, 1, "PINHOLE", TINY_WIDTH_PX, TINY_HEIGHT_PX, 4, {7, 7, 4, 3}}},
        .camera_count = 1,
        .image_count = DENSE_PHOTOS,
        .points = {{.id = 1, .position = {1, 0, -10}, .track_count = 2, .tracks = {{10, 0}, {11, 0}}},
                   {.id = 2, .position = {0, 1, -20}, .track_count = 3, .tracks = {{10, 1}, {11, 1}, {12, 0}}}},
        .point_count = 2,
    };
    for (uint32_t i = 0; i < DENSE_PHOTOS; i++)
        model.images[i] = (struct colmap_test_image){
            10 + i, 1, names[i], {0, 1, 0, 0}, {-(double)i, 0, 0}, .feature_count = 2, .features = {{4, 3}, {5, 2}}};
    return model;
}

void colmap_write_photos(const char *scene_folder, const char *photo_folder, const char *const names[DENSE_PHOTOS]) {
    for (uint32_t i = 0; i < DENSE_PHOTOS; i++) {
        AUTO_FREE char *name = vw_format_text("%s/%s", photo_folder, names[i]);
        tiny_photo_write(temporary_path(scene_folder, name), i);
    }
}

void colmap_write_dense(const char *scene_folder, const char *const names[DENSE_PHOTOS], const char *tsv) {
    const struct colmap_test_model model = colmap_dense_model(names);
    colmap_write_photos(scene_folder, "dense/images", names);
    colmap_write_text(scene_folder, "dense/sparse", &model);
    temporary_file(scene_folder, "splits.tsv", tsv);
}
