#include "support/tiny_scene.h"
#include "support/cmocka_test.h"

#include "base/file.h"
#include "image/decoder.h"
#include "image/image.h"
#include "support/temporary_folder.h"

// Starts the decoder once for all tests of a program.
static void hold_decoder(void) {
    static bool held;
    if (!held) vw_decoder_hold();
    held = true;
}

int tiny_decoder_hold(void **state) {
    (void)state;
    hold_decoder();
    return 0;
}

void tiny_photo_write(const char *path, uint32_t index) {
    float pixels[TINY_HEIGHT_PX * TINY_WIDTH_PX * 3];
    hold_decoder();
    for (size_t i = 0; i < sizeof pixels / sizeof pixels[0]; i++) pixels[i] = (float)(index % 16) / 16;
    char *folder = vw_path_folder(path);
    assert_int_equal(vw_folder_create(folder), VW_OK);
    free(folder);
    if (vw_image_save(path, TINY_WIDTH_PX, TINY_HEIGHT_PX, 3, pixels)) fail_msg("%s", vw_error_message());
}

// Writes a camera on a ring (with some height) that looks at the centre. Its axes: z away from the centre, x level, y =
// z cross x.
static void write_frame(FILE *json, const struct tiny_scene *tiny, uint32_t index) {
    double turn = 2 * M_PI * index / 8 + 0.1, tilt = 0.3 + 0.2 * (index % 3),
           scale = tiny->scale_world ? tiny->scale_world : 1;
    double z[3] = {cos(turn) * cos(tilt), sin(turn) * cos(tilt), sin(tilt)}, x[3] = {-sin(turn), cos(turn), 0};
    fprintf(json, "%s\n    {%s \"file_path\": \"%s%02u%s", index > tiny->first ? "," : "",
            tiny->frame_keys ? tiny->frame_keys : "", tiny->name_prefix ? tiny->name_prefix : "images/", index,
            tiny->name_suffix ? tiny->name_suffix : ".png");
    fprintf(json, "\", \"transform_matrix\": [");
    for (int i = 0; i < 3; i++)
        fprintf(json, "[%.17g, %.17g, %.17g, %.17g], ", x[i],
                z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3], z[i],
                4 * z[i] * scale + tiny->offset_world[i]);
    fprintf(json, "[0, 0, 0, 1]]}");
}

const char *tiny_scene_write(const char *folder, const struct tiny_scene *tiny) {
    uint32_t count = tiny->count ? tiny->count : 8;
    const char *path = temporary_path(folder, tiny->file ? tiny->file : "transforms.json");
    FILE *json = fopen(path, "w");
    assert_non_null(json);
    fprintf(json, "{%s\n  \"frames\": [", tiny->keys ? tiny->keys : "\"camera_angle_x\": 0.7,");
    for (uint32_t i = tiny->first; i < tiny->first + count; i++) {
        char name[32];
        write_frame(json, tiny, i);
        snprintf(name, sizeof name, "images/%02u.png", i);
        tiny_photo_write(temporary_path(folder, name), i);
    }
    fprintf(json, "\n  ]\n}\n");
    assert_int_equal(fclose(json), 0);
    return path;
}

static void close_scene(void *scene) { vw_scene_close(&(struct vw_scene *){scene}); }

struct vw_scene *test_own_scene(struct vw_scene *scene) {
    return test_own(scene, close_scene);
}

struct vw_scene *tiny_scene_open(const struct vw_scene_params *params) {
    struct vw_scene *scene = NULL;
    hold_decoder();
    ASSERT_OK(vw_scene_open(params, &scene));
    return test_own_scene(scene);
}

void check_splits(const struct vw_scene *scene, const char *expected) {
    char splits[100] = "";
    uint32_t count[4] = {0};
    for (uint32_t v = 0; v < scene->view_count; v++) {
        splits[v] = "tvTx"[scene->views[v].split];
        count[scene->views[v].split]++;
    }
    assert_string_equal(splits, expected);
    assert_memory_equal(count, scene->split_count, sizeof count);
}

void check_note(const struct vw_scene *scene, const char *text) {
    bool found = false;
    for (uint32_t i = 0; i < scene->note_count; i++) found |= strstr(scene->notes[i], text) != NULL;
    if (!found) fail_msg("no note has: %s", text);
}

uint32_t count_truth(const struct vw_scene *scene, const char *ground_truth) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) count += !strcmp(scene->views[v].ground_truth, ground_truth);
    return count;
}

void check_turned(const struct vw_view *a, const struct vw_view *b) {
    double cosine = 0;
    for (int i = 0; i < 3; i++) {
        cosine += a->camera_to_world[i][2] * b->camera_to_world[i][2];
        assert_true(a->camera_to_world[i][3] == b->camera_to_world[i][3]);
    }
    assert_near(acos(cosine) * 180 / M_PI, 8, 1e-9);
}

enum vw_status tiny_scene_try(const struct vw_scene_params *params) {
    struct vw_scene *scene = NULL;
    enum vw_status status = vw_scene_open(params, &scene);
    assert_int_equal(!status, scene != NULL);
    vw_scene_close(&scene);
    return status;
}

struct vw_scene *own_recipe_open(const char *name, struct vw_scene_params params) {
    AUTO_FREE char *path = vw_format_text(VW_SOURCE_FOLDER "/scenes/%s.json", name);
    params.path = path;
    return tiny_scene_open(&params);
}
