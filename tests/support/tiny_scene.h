// Tiny scenes on disk: a ring of cameras around a point, each with a photo of 8 x 6 pixels.
#ifndef VIEWWORTH_TESTS_SUPPORT_TINY_SCENE_H
#define VIEWWORTH_TESTS_SUPPORT_TINY_SCENE_H

#include <stdint.h>

#include "viewworth/scene.h"

enum { TINY_WIDTH_PX = 8, TINY_HEIGHT_PX = 6 };

// Zero means the default.
struct tiny_scene {
    const char *file;        // "transforms.json"
    uint32_t first, count;   // photos images/<first>.png ... (two digits); default count 8
    double scale_world;      // factor of all coordinates; 1. The cameras' distance to the centre is 4
    double offset_world[3];  // added to all coordinates
    const char *keys;        // further keys of the file, each followed by a comma; default "camera_angle_x": 0.7,
    const char *frame_keys;  // further keys of every frame, each followed by a comma
    const char *name_prefix; // prefix of file_path: "images/"
    const char *name_suffix; // ".png"
};

// Writes scene file and photos into the folder; returns the scene file's path as temporary_path() does.
const char *tiny_scene_write(const char *folder, const struct tiny_scene *tiny);
// Writes a photo of one colour, which depends on `index`.
void tiny_photo_write(const char *path, uint32_t index);

// Registers a scene to be closed when the test ends, and returns it.
struct vw_scene *test_own_scene(struct vw_scene *scene);
// Checks the splits of the scene. `expected` has a letter per view: t(rain), v(al), T(est), x(excluded).
void check_splits(const struct vw_scene *scene, const char *expected);
// Fails the test unless a note of the scene has the text.
void check_note(const struct vw_scene *scene, const char *text);
// Returns how many views have that defect, or are "clean".
uint32_t count_truth(const struct vw_scene *scene, const char *ground_truth);
// Checks that two views have the same place and lines of sight that differ by 8 degrees.
void check_turned(const struct vw_view *a, const struct vw_view *b);
// Opens a scene that the test owns, or fails the test with its message; the second, a recipe that comes with viewworth.
struct vw_scene *tiny_scene_open(const struct vw_scene_params *params);
struct vw_scene *own_recipe_open(const char *name, struct vw_scene_params params);
// Sets up a group: starts the decoder once for all of its tests.
int tiny_decoder_hold(void **state);
// Params of a scene, by their fields.
#define SCENE_PARAMS(...) (&(struct vw_scene_params){__VA_ARGS__})

// Opens and closes a scene; fails the test if it returns one with a failure.
enum vw_status tiny_scene_try(const struct vw_scene_params *params);
// Fails the test unless opening is refused with this status and a message of one line that holds every text.
#define tiny_scene_refused(params, status, ...) ASSERT_FAILS(tiny_scene_try(params), status, __VA_ARGS__)
// The same of a folder that is wrong as input.
#define tiny_folder_refused(folder, ...) tiny_scene_refused(SCENE_PARAMS(.path = (folder)), VW_ERROR_INPUT, __VA_ARGS__)

#endif
