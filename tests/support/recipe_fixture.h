// Small recipes for tests.
#ifndef VIEWWORTH_TESTS_SUPPORT_RECIPE_FIXTURE_H
#define VIEWWORTH_TESTS_SUPPORT_RECIPE_FIXTURE_H

#include "support/temporary_folder.h"
#include "support/tiny_scene.h"
#include "viewworth/scene.h"

#define RECIPE_GREY "{\"kind\": \"plain\", \"colour\": [0.5, 0.5, 0.5]}"
#define RECIPE_SPHERE                                                                                                  \
    "{\"kind\": \"sphere\", \"centre\": [0.2, -0.1, 0.3], \"radius\": 0.5, \"texture\": " RECIPE_GREY "}"

// 24 views of 32x24 around a grey sphere in front of black: 18 train, 3 val, 3 test.
static const char *const recipe_text = "{\"viewworth_recipe\": 1, \"seed\": 3,\n"
                                       " \"image\": {\"width_px\": 32, \"height_px\": 24, \"samples_per_pixel\": 1},\n"
                                       " \"box\": {\"centre\": [0, 0, 0], \"half_extent\": 1},\n"
                                       " \"background\": [0, 0, 0],\n"
                                       " \"shapes\": [" RECIPE_SPHERE "],\n"
                                       " \"cameras\": [{\"path\": \"orbit\", \"centre\": [0, 0, 0], \"radius\": 3, "
                                       "\"elevation_deg\": [20, 50], \"count\": 24,\n"
                                       "              \"field_of_view_deg\": 50}],\n"
                                       " \"defects\": []}\n";

// Returns a copy of `text` with the first `from` replaced by `to`, to be freed.
static char *replaced(const char *text, const char *from, const char *to) {
    const char *at = strstr(text, from);
    if (!at) fail_msg("the test's recipe does not hold \"%s\"", from);
    return vw_format_text("%.*s%s%s", (int)(at - text), text, to, at + strlen(from));
}

// Opens a recipe's text; the status of failure is returned.
static enum vw_status open_text(const char *text, struct vw_scene_params params, struct vw_scene **scene) {
    char *folder = temporary_folder_create();
    params.path = temporary_file(folder, "recipe.json", text);
    params.format = "recipe";
    enum vw_status status = vw_scene_open(&params, scene);
    temporary_folder_remove(folder);
    return status;
}

// Opens recipe_text with up to two replacements (NULL: none), and fails the test when that fails. The test owns the
// scene.
static struct vw_scene *open_changed(struct vw_scene_params params, const char *from, const char *to, const char *from2,
                                     const char *to2) {
    struct vw_scene *scene = NULL;
    AUTO_FREE char *text = from ? replaced(recipe_text, from, to) : vw_copy_text(recipe_text);
    AUTO_FREE char *text2 = from2 ? replaced(text, from2, to2) : vw_copy_text(text);
    if (open_text(text2, params, &scene)) fail_msg("%s in\n%s", vw_error_message(), text2);
    return test_own_scene(scene);
}

#endif
