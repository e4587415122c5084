// Writes a large scene in the PhotoTourism layout: JPEG photos, a binary COLMAP model with points, and a NeRF-W list.
//
//     make_large_scene RECIPE FOLDER PHOTOS [WIDTH HEIGHT]    (1024 768); 28 photos are of the split test
//
// The shapes are those of the recipe; its cameras and defects are not used. Photos are ray-traced a hundred at a time,
// so that they need little memory: part k is a circle of cameras of its own. They are traced at a quarter of their size
// and enlarged, which is 16 times as fast: what a large scene takes does not depend on what its photos show.
#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/memory.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "viewworth/gpu.h"
#include "viewworth/scene.h"

enum { PART_PHOTOS = 100, TEST_PHOTOS = 28, COLMAP_PINHOLE = 1, ENLARGED = 4 };

struct making {
    const char *folder;
    struct vw_gpu *gpu;
    json_t *recipe; // owned
    FILE *cameras, *images, *points, *list;
    uint32_t photo_count, width_px, height_px;
    uint32_t written; // photos of earlier parts
    uint64_t point_count;
};

static void put_u32(FILE *file, uint32_t value) { fwrite(&value, sizeof value, 1, file); }
static void put_u64(FILE *file, uint64_t value) { fwrite(&value, sizeof value, 1, file); }
static void put_reals(FILE *file, const double *values, size_t count) { fwrite(values, sizeof *values, count, file); }

// ---- The model -----------------------------------------------------------------------------------------------------

// Finds the rotation and translation from world to camera, in the axes of OpenCV: a quaternion (w x y z) and a vector
// (Shepperd 1978, with the largest of the four parts first).
static void pose_of(const struct vw_view *view, double quaternion[4], double translation[3]) {
    double r[3][3];
    for (int i = 0; i < 3; i++) {
        double sign = i ? -1 : 1;
        translation[i] = 0;
        for (int j = 0; j < 3; j++) r[i][j] = sign * view->camera_to_world[j][i];
        for (int j = 0; j < 3; j++) translation[i] -= r[i][j] * view->camera_to_world[j][3];
    }
    const double squares[4] = {1 + r[0][0] + r[1][1] + r[2][2], 1 + r[0][0] - r[1][1] - r[2][2],
                               1 - r[0][0] + r[1][1] - r[2][2], 1 - r[0][0] - r[1][1] + r[2][2]};
    const double products[4][4] = {{squares[0], r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]},
                                   {r[2][1] - r[1][2], squares[1], r[0][1] + r[1][0], r[0][2] + r[2][0]},
                                   {r[0][2] - r[2][0], r[0][1] + r[1][0], squares[2], r[1][2] + r[2][1]},
                                   {r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], squares[3]}};
    int largest = 0;
    for (int i = 1; i < 4; i++)
        if (squares[i] > squares[largest]) largest = i;
    for (int i = 0; i < 4; i++) quaternion[i] = products[largest][i] / (2 * sqrt(squares[largest]));
}

static uint64_t feature_count(const struct vw_scene *scene, uint32_t view) {
    uint64_t count = 0;
    for (uint32_t t = 0; t < scene->track_count; t++) count += scene->tracks[t].view == view;
    return count;
}

static void write_image(struct making *making, const struct vw_scene *scene, uint32_t view, const char *name) {
    double quaternion[4], translation[3];
    pose_of(&scene->views[view], quaternion, translation);
    put_u32(making->images, making->written + view + 1);
    put_reals(making->images, quaternion, 4);
    put_reals(making->images, translation, 3);
    put_u32(making->images, 1 + making->written / PART_PHOTOS);
    fprintf(making->images, "%s%c", name, 0);
    put_u64(making->images, feature_count(scene, view));
    for (uint32_t p = 0; p < scene->point_count; p++)
        for (uint32_t t = 0; t < scene->points[p].track_count; t++) {
            const struct vw_track *track = &scene->tracks[scene->points[p].first_track + t];
            if (track->view != view) continue;
            put_reals(making->images, (double[2]){ENLARGED * track->x_px, ENLARGED * track->y_px}, 2);
            put_u64(making->images, making->point_count + p + 1);
        }
}

// Writes the points. Their tracks name an image and a feature of it: the features of a view are in the order of the
// points.
static void write_points(struct making *making, const struct vw_scene *scene, uint32_t *features) {
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        put_u64(making->points, making->point_count + p + 1);
        put_reals(making->points, point->position_world, 3);
        for (int c = 0; c < 3; c++) fputc((int)lrintf(255 * point->rgb[c]), making->points);
        put_reals(making->points, &(double){0.5}, 1);
        put_u64(making->points, point->track_count);
        for (uint32_t t = 0; t < point->track_count; t++) {
            uint32_t view = scene->tracks[point->first_track + t].view;
            put_u32(making->points, making->written + view + 1);
            put_u32(making->points, features[view]++);
        }
    }
    making->point_count += scene->point_count;
}

static void write_camera(struct making *making, const struct vw_camera *camera) {
    put_u32(making->cameras, 1 + making->written / PART_PHOTOS);
    put_u32(making->cameras, COLMAP_PINHOLE);
    put_u64(making->cameras, ENLARGED * camera->width_px);
    put_u64(making->cameras, ENLARGED * camera->height_px);
    put_reals(making->cameras,
              (double[4]){ENLARGED * camera->focal_x_px, ENLARGED * camera->focal_y_px, ENLARGED * camera->centre_x_px,
                          ENLARGED * camera->centre_y_px},
              4);
}

// ---- Photos --------------------------------------------------------------------------------------------------------

static enum vw_status write_photo(const struct making *making, const struct vw_image *image, const char *name) {
    uint32_t width_px = ENLARGED * image->width_px, height_px = ENLARGED * image->height_px;
    size_t pixel_count = (size_t)width_px * height_px, size_bytes = 0;
    struct vw_image_encoding encoding = {
        .width_px = width_px, .height_px = height_px, .channels = 3, .eight_bit = true, .compression = "jpeg:90"};
    float *rgb = vw_allocate(pixel_count, 3 * sizeof *rgb), rgba[4];
    char *path = vw_format_text("%s/dense/images/%s", making->folder, name);
    void *file = NULL;
    enum vw_status status = rgb && path ? VW_OK : VW_ERROR_MEMORY;
    for (size_t i = 0; !status && i < pixel_count; i++) {
        vw_image_pixel(image, (uint32_t)(i % width_px) / ENLARGED, (uint32_t)(i / width_px) / ENLARGED, rgba);
        memcpy(rgb + 3 * i, rgba, 3 * sizeof *rgb);
    }
    if (!status && !vw_photo_format_of_name(name, &encoding.format)) status = VW_ERROR_USAGE;
    if (!status) status = vw_image_encode(&encoding, rgb, &file, &size_bytes);
    if (!status) status = vw_file_write(path, file, size_bytes);
    free(file);
    free(path);
    free(rgb);
    return status;
}

// Returns whether a photo tests; test photos are spread evenly over all.
static bool is_test(const struct making *making, uint32_t photo) {
    return (uint64_t)(photo + 1) * TEST_PHOTOS / making->photo_count !=
           (uint64_t)photo * TEST_PHOTOS / making->photo_count;
}

static enum vw_status write_part(struct making *making, const struct vw_scene *scene) {
    uint32_t *features = vw_allocate(scene->view_count, sizeof *features);
    enum vw_status status = features ? VW_OK : VW_ERROR_MEMORY;
    write_camera(making, &scene->views[0].camera);
    for (uint32_t v = 0; !status && v < scene->view_count; v++) {
        char name[32];
        uint32_t photo = making->written + v;
        snprintf(name, sizeof name, "%08u.jpg", photo);
        write_image(making, scene, v, name);
        fprintf(making->list, "%s\t%u\t%s\tlarge\n", name, photo + 1, is_test(making, photo) ? "test" : "train");
        status = write_photo(making, &scene->views[v].image, name);
    }
    if (!status) write_points(making, scene, features);
    free(features);
    return status;
}

// ---- Parts ---------------------------------------------------------------------------------------------------------

// Returns a circle of cameras around the recipe's box, with a height and a radius that no other part has.
static json_t *circle_of(const struct making *making, uint32_t count) {
    double part = making->written / PART_PHOTOS, half_extent = 0;
    json_t *box = json_object_get(making->recipe, "box");
    half_extent = json_number_value(json_object_get(box, "half_extent"));
    double elevation_deg = 15 + fmod(part * 0.618034, 1) * 40;
    return json_pack("[{s:s, s:O, s:f, s:[f, f], s:f, s:i, s:i}]", "path", "orbit", "centre",
                     json_object_get(box, "centre"), "radius", half_extent * (2.0 + fmod(part * 0.414214, 0.6)),
                     "elevation_deg", elevation_deg, elevation_deg + 4, "start_deg", fmod(part * 137.5, 360), "count",
                     (int)count, "field_of_view_deg", 52);
}

static enum vw_status make_part(struct making *making) {
    uint32_t left = making->photo_count - making->written, count = left < PART_PHOTOS ? left : PART_PHOTOS;
    char *path = vw_path_join(making->folder, "part.json");
    struct vw_scene *scene = NULL;
    json_object_set_new(making->recipe, "cameras", circle_of(making, count));
    if (!path || json_dump_file(making->recipe, path, 0)) {
        free(path);
        return vw_fail(VW_ERROR_IO, "%s: cannot write the recipe of a part", making->folder);
    }
    enum vw_status status = vw_scene_open(&(struct vw_scene_params){.path = path, .gpu = making->gpu}, &scene);
    if (!status) status = write_part(making, scene);
    vw_scene_close(&scene);
    remove(path);
    free(path);
    making->written += count;
    if (!status) printf("%" PRIu32 " of %" PRIu32 " photos\n", making->written, making->photo_count);
    fflush(stdout);
    return status;
}

// ---- The scene -----------------------------------------------------------------------------------------------------

static FILE *create(const char *folder, const char *name) {
    char *path = vw_path_join(folder, name);
    FILE *file = path ? fopen(path, "wb") : NULL;
    if (!file) fprintf(stderr, "make_large_scene: %s/%s: %s\n", folder, name, strerror(errno));
    free(path);
    return file;
}

static bool open_files(struct making *making) {
    static const char *const folders[] = {"dense", "dense/images", "dense/sparse"};
    mkdir(making->folder, 0777);
    for (size_t i = 0; i < VW_ARRAY_COUNT(folders); i++) {
        char *path = vw_path_join(making->folder, folders[i]);
        if (path) mkdir(path, 0777);
        free(path);
    }
    making->cameras = create(making->folder, "dense/sparse/cameras.bin");
    making->images = create(making->folder, "dense/sparse/images.bin");
    making->points = create(making->folder, "dense/sparse/points3D.bin");
    making->list = create(making->folder, "large.tsv");
    if (!making->cameras || !making->images || !making->points || !making->list) return false;
    fprintf(making->list, "filename\tid\tsplit\tdataset\n");
    put_u64(making->cameras, (making->photo_count + PART_PHOTOS - 1) / PART_PHOTOS);
    put_u64(making->images, making->photo_count);
    put_u64(making->points, 0); // known at the end
    return true;
}

static bool close_files(struct making *making) {
    FILE *const files[] = {making->cameras, making->images, making->points, making->list};
    bool whole = true;
    if (making->points && !fseek(making->points, 0, SEEK_SET)) put_u64(making->points, making->point_count);
    for (size_t i = 0; i < VW_ARRAY_COUNT(files); i++)
        if (files[i]) whole &= !ferror(files[i]) & !fclose(files[i]);
    return whole;
}

static bool read_recipe(struct making *making, const char *path) {
    json_error_t error;
    making->recipe = json_load_file(path, 0, &error);
    if (!making->recipe) fprintf(stderr, "make_large_scene: %s: %s\n", path, error.text);
    json_object_del(making->recipe, "defects");
    json_t *image = json_pack("{s:i, s:i, s:i}", "width_px", (int)making->width_px / ENLARGED, "height_px",
                              (int)making->height_px / ENLARGED, "samples_per_pixel", 1);
    return making->recipe && !json_object_set_new(making->recipe, "image", image);
}

int main(int argc, char **argv) {
    struct making making = {.folder = argc > 2 ? argv[2] : NULL,
                            .photo_count = argc > 3 ? (uint32_t)atoi(argv[3]) : 0,
                            .width_px = argc > 5 ? (uint32_t)atoi(argv[4]) : 1024,
                            .height_px = argc > 5 ? (uint32_t)atoi(argv[5]) : 768};
    if (making.photo_count < 2 * TEST_PHOTOS || !making.width_px || !making.height_px) {
        fprintf(stderr, "usage: make_large_scene RECIPE FOLDER PHOTOS [WIDTH HEIGHT]    (at least %d photos)\n",
                2 * TEST_PHOTOS);
        return 2;
    }
    if (!read_recipe(&making, argv[1]) || !open_files(&making)) return 1;
    enum vw_status status = vw_gpu_open(&(struct vw_gpu_params){0}, &making.gpu);
    while (!status && making.written < making.photo_count) status = make_part(&making);
    if (status) fprintf(stderr, "make_large_scene: %s\n", vw_error_message());
    (void)vw_gpu_close(&making.gpu);
    json_decref(making.recipe);
    bool whole = close_files(&making);
    if (!whole) fprintf(stderr, "make_large_scene: %s: cannot write all of it\n", making.folder);
    return status || !whole ? 1 : 0;
}
