#include "fuzz/fuzz.h"

#include <jansson.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "report/documents.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "viewworth/scene.h"

static const char STALE[] = "no message yet";
enum { PHOTO_COUNT = 8, SIZES_BYTES = 4, HASHED_BYTES_MAX = 1 << 12 };
static char *folder; // kept from input to input: making photos costs more than reading a scene

static struct vw_scene *scene;
#define CHECK(condition) fuzz_check(condition, #condition)

void fuzz_check(bool condition, const char *what) {
    if (condition) return;
    fprintf(stderr, "not so: %s (last message: %s)\n", what, vw_error_message());
    abort();
}

// ---- Files ----------------------------------------------------------------------------------------------------------

void fuzz_remove_folder(void) {
    vw_scene_close(&scene);
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

static void check_scene(const struct vw_scene *opened) {
    uint32_t split_sum = 0;
    for (int i = 0; i < 4; i++) split_sum += opened->split_count[i];
    CHECK(opened->view_count > 0 && split_sum == opened->view_count);
    for (uint32_t v = 0; v < opened->view_count; v++) check_view(&opened->views[v]);
    CHECK(opened->box.half_extent_world > 0 && isfinite(opened->box.half_extent_world));
    for (int i = 0; i < 3; i++) CHECK(isfinite(opened->box.centre_world[i]));
    for (uint32_t p = 0; p < opened->point_count; p++)
        CHECK((uint64_t)opened->points[p].first_track + opened->points[p].track_count <= opened->track_count);
    for (uint32_t t = 0; t < opened->track_count; t++) CHECK(opened->tracks[t].view < opened->view_count);
    for (uint32_t i = 0; i < opened->note_count; i++) CHECK(!strpbrk(opened->notes[i], "\r\n"));
}

void fuzz_open(const char *path, const char *format) {
    struct vw_scene *opened = NULL;
    fuzz_forget_message();
    enum vw_status status = vw_scene_open(SCENE_PARAMS(.path = path, .format = format, .headers_only = true), &opened);
    fuzz_check_message(status);
    CHECK(!status == (opened != NULL));
    if (opened) check_scene(opened);
    vw_scene_close(&opened);
}

// ---- Files of ours --------------------------------------------------------------------------------------------------

const char *fuzz_write_hashed(const char *name, const uint8_t *data, size_t size_bytes) {
    uint8_t bytes[HASHED_BYTES_MAX + VW_HASH_BYTES];
    bool rehashes = size_bytes > 0 && data[0] == 'h';
    size_t kept_bytes = size_bytes > HASHED_BYTES_MAX ? HASHED_BYTES_MAX : size_bytes;
    if (kept_bytes > 0) memcpy(bytes, data + 1, --kept_bytes);
    if (rehashes) vw_sha256(bytes, kept_bytes, bytes + kept_bytes);
    return fuzz_write(name, bytes, kept_bytes + (rehashes ? VW_HASH_BYTES : 0));
}

void fuzz_check_hashed(const struct vw_hashed_file *file, uint64_t payload_bytes) {
    uint8_t sum = 0;
    CHECK(file->payload_bytes == payload_bytes);
    CHECK(file->description && strlen(file->description) < HASHED_BYTES_MAX);
    for (uint64_t i = 0; i < payload_bytes; i++) sum ^= file->payload[i]; // which is all there
    *(volatile uint8_t *)&sum = sum;
}

struct vw_scene *fuzz_scene(void) {
    static const char head[] = "{\"fl_x\": 8, \"frames\": [";
    char text[2048];
    if (scene) return scene;
    int used = snprintf(text, sizeof text, "%s", head);
    for (int i = 0; i < PHOTO_COUNT; i++)
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"file_path\": \"images/%02d.png\", \"transform_matrix\": "
                         "[[1,0,0,%d],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}",
                         i ? ", " : "", i, i);
    snprintf(text + used, sizeof text - (size_t)used, "]}");
    const char *path = fuzz_write("transforms.json", (const uint8_t *)text, strlen(text));
    CHECK(!vw_scene_open(SCENE_PARAMS(.path = path, .headers_only = true), &scene));
    return scene;
}

void fuzz_check_report(const char *name, const uint8_t *data, size_t size_bytes) {
    static const uint8_t picture[] = "\x89PNG\r\n\x1a\n";
    struct vw_report_documents documents = {0};
    char path[64];
    snprintf(path, sizeof path, "out/%s", name);
    CHECK(!vw_folder_create(temporary_path(fuzz_folder(), "out/renders")));
    fuzz_write("out/renders/a.png", picture, sizeof picture);
    const char *written = fuzz_write(path, data, size_bytes);
    fuzz_forget_message();
    enum vw_status status = vw_report_documents_read(&documents, temporary_path(fuzz_folder(), "out"), NULL);
    fuzz_check_message(status);
    if (!status) {
        CHECK(documents.count == 1);
        char *json = json_dumps(documents.list[0].content, JSON_ENCODE_ANY);
        CHECK(json); // the page contains it
        free(json);
    }
    vw_report_documents_free(&documents);
    CHECK(!remove(written)); // the next input may be another table
}
