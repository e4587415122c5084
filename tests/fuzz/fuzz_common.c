#include "fuzz/fuzz.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "base/file.h"
#include "base/memory.h"
#include "viewworth/scene.h"

static const char STALE[] = "no message yet";
enum { PHOTO_COUNT = 8, SIZES_BYTES = 4 };
static char *folder; // kept from input to input: making photos costs more than reading a scene

#define CHECK(condition)                                                                                               \
    do {                                                                                                               \
        if (!(condition)) stop(__LINE__, #condition);                                                                  \
    } while (0)

static void stop(int line, const char *condition) {
    fprintf(stderr, "fuzz_common.c:%d: not so: %s (last message: %s)\n", line, condition, vw_error_message());
    abort();
}

// ---- Files ----------------------------------------------------------------------------------------------------------

void fuzz_remove_folder(void) {
    if (folder) temporary_folder_remove(folder);
    folder = NULL;
}

const char *fuzz_folder(void) {
    if (folder) return folder;
    folder = temporary_folder_create();
    static bool at_exit;
    if (!at_exit) at_exit = !atexit(fuzz_remove_folder);
    for (uint32_t i = 0; i < PHOTO_COUNT; i++) {
        char name[32];
        snprintf(name, sizeof name, "images/%02u.png", i);
        tiny_photo_write(temporary_path(folder, name), i);
    }
    return folder;
}

const char *fuzz_write(const char *name, const uint8_t *data, size_t size_bytes) {
    const char *path = temporary_path(fuzz_folder(), name);
    FILE *file = fopen(path, "wb"); // vw_file_write() waits for the disk
    CHECK(file);
    CHECK(fwrite(data, 1, size_bytes, file) == size_bytes);
    CHECK(!fclose(file));
    return path;
}

static size_t take_size(const uint8_t *data, size_t left_bytes) {
    size_t size_bytes = (size_t)data[0] | (size_t)data[1] << 8;
    return size_bytes < left_bytes ? size_bytes : left_bytes;
}

void fuzz_write_model(const char *model_folder, const char *extension, const uint8_t *data, size_t size_bytes) {
    static const char *const stems[] = {"cameras", "images", "points3D"};
    static const uint8_t no_sizes[SIZES_BYTES];
    const uint8_t *sizes = size_bytes < SIZES_BYTES ? no_sizes : data;
    const uint8_t *at = size_bytes < SIZES_BYTES ? data : data + SIZES_BYTES, *end = data + size_bytes;
    CHECK(!vw_folder_create(temporary_path(fuzz_folder(), model_folder)));
    for (size_t i = 0; i < VW_ARRAY_COUNT(stems); i++) {
        size_t left_bytes = (size_t)(end - at), part_bytes = i < 2 ? take_size(sizes + 2 * i, left_bytes) : left_bytes;
        char name[64];
        snprintf(name, sizeof name, "%s/%s.%s", model_folder, stems[i], extension);
        fuzz_write(name, at, part_bytes);
        at += part_bytes;
    }
}

// ---- What a reader may do -------------------------------------------------------------------------------------------

void fuzz_forget_message(void) { vw_fail(VW_ERROR_USAGE, "%s", STALE); }

void fuzz_check_message(enum vw_status status) {
    const char *message = vw_error_message();
    if (!status) return;
    CHECK(*message && strcmp(message, STALE) != 0);
    CHECK(!strpbrk(message, "\r\n"));
}

static void check_view(const struct vw_view *view) {
    const struct vw_camera *camera = &view->camera;
    CHECK(view->name && *view->name);
    CHECK(camera->width_px > 0 && camera->height_px > 0);
    CHECK(camera->focal_x_px > 0 && isfinite(camera->focal_x_px) && camera->focal_y_px > 0 &&
          isfinite(camera->focal_y_px));
    CHECK(isfinite(camera->centre_x_px) && isfinite(camera->centre_y_px));
    for (int i = 0; i < 12; i++) CHECK(isfinite(view->camera_to_world[i / 4][i % 4]));
    CHECK(view->near_world >= 0 && view->near_world <= view->far_world && isfinite(view->far_world));
}

static void check_scene(const struct vw_scene *scene) {
    uint32_t split_sum = 0;
    for (int i = 0; i < 4; i++) split_sum += scene->split_count[i];
    CHECK(scene->view_count > 0 && split_sum == scene->view_count);
    for (uint32_t v = 0; v < scene->view_count; v++) check_view(&scene->views[v]);
    CHECK(scene->box.half_extent_world > 0 && isfinite(scene->box.half_extent_world));
    for (int i = 0; i < 3; i++) CHECK(isfinite(scene->box.centre_world[i]));
    for (uint32_t p = 0; p < scene->point_count; p++)
        CHECK((uint64_t)scene->points[p].first_track + scene->points[p].track_count <= scene->track_count);
    for (uint32_t t = 0; t < scene->track_count; t++) CHECK(scene->tracks[t].view < scene->view_count);
    for (uint32_t i = 0; i < scene->note_count; i++) CHECK(!strpbrk(scene->notes[i], "\r\n"));
}

void fuzz_open(const char *path, const char *format) {
    struct vw_scene *scene = NULL;
    fuzz_forget_message();
    enum vw_status status =
        vw_scene_open(&(struct vw_scene_params){.path = path, .format = format, .headers_only = true}, &scene);
    fuzz_check_message(status);
    CHECK(!status == (scene != NULL));
    if (scene) check_scene(scene);
    vw_scene_close(&scene);
}
