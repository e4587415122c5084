// Recipes without a device: what is refused, cameras, splits, defects and their truth.

#include "support/recipe_fixture.h"

#define DEFECTS(list) "\"defects\": [" list "]"
#define NO_DEFECTS DEFECTS("")
#define ORBIT_OF(provider)                                                                                             \
    "{\"path\": \"orbit\", \"centre\": [0, 0, 0], \"radius\": 3, \"count\": 8, \"field_of_view_deg\": 50, "            \
    "\"provider\": \"" provider "\"}"

static const struct vw_scene_params headers = {.headers_only = true};

TEST(bad_recipes_are_refused) {
    const struct {
        const char *from, *to, *message;
    } cases[] = {
        {"\"seed\": 3", "\"seed\": 3, \"sede\": 4", "recipe.json: sede: unknown key"},
        {"\"seed\": 3", "\"seed\": -1", "recipe.json: seed: "},
        {"\"seed\": 3", "\"seed\" 3", "recipe.json:1:"},
        {"\"seed\": 3", "\"seed\": 3, \"seed\": 4", "recipe.json:1:"},
        {"\"viewworth_recipe\": 1", "\"viewworth_recipe\": 2", "viewworth_recipe: "},
        {"\"width_px\": 32", "\"width_px\": 4097", "image.width_px: "},
        {"\"width_px\": 32", "\"width_px\": 32.5", "image.width_px: "},
        {"\"width_px\": 32, ", "", "image.width_px: is missing"},
        {"\"width_px\": 32, \"height_px\": 24", "\"width_px\": 4096, \"height_px\": 4096",
         "image: all photos together"},
        {"\"samples_per_pixel\": 1", "\"samples_per_pixel\": 5", "image.samples_per_pixel: must be a square"},
        {"\"half_extent\": 1", "\"half_extent\": 0", "box.half_extent: 0 is out of range"},
        {"\"half_extent\": 1", "\"half_extent\": \"1\"", "box.half_extent: expected a number"},
        {"\"background\": [0, 0, 0]", "\"background\": [0, 0]", "background: expected an array of 3 numbers"},
        {"\"background\": [0, 0, 0]", "\"background\": \"night\"", "background: is not allowed"},
        {"\"background\": [0, 0, 0]", "\"sun\": {\"direction\": [0, 0, 0], \"intensity\": 1}",
         "sun.direction: has no length"},
        {"\"seed\": 3", "\"seed\": 3, \"exposure\": {\"gain\": 3}", "exposure.gain: 3 is out of range"},
        {"\"seed\": 3", "\"seed\": 3, \"exposure\": {\"strength\": 1}", "exposure.strength: unknown key"},
        {"\"kind\": \"sphere\"", "\"kind\": \"cone\"",
         "shapes[0].kind: is not allowed; use one of: sphere box plane cylinder"},
        {"\"kind\": \"sphere\", ", "", "shapes[0].kind: is missing"},
        {"\"radius\": 0.5, ", "", "shapes[0].radius: is missing"},
        {"\"radius\": 0.5, ", "\"radius\": 0.5, \"height\": 1, ", "shapes[0].height: unknown key"},
        {"[0.5, 0.5, 0.5]", "[0.5, 1.5, 0.5]", "shapes[0].texture.colour: 1.5 is out of range"},
        {"\"plain\"", "\"checker\"", "shapes[0].texture.second_colour: is missing"},
        {RECIPE_SPHERE, "7", "shapes[0]"},
        {"\"path\": \"orbit\", ", "", "cameras[0].path: is missing"},
        {"\"count\": 24", "\"count\": 4097", "cameras[0].count: "},
        {"\"field_of_view_deg\": 50", "\"field_of_view_deg\": 180",
         "cameras[0].field_of_view_deg: 180 is out of range"},
        {"\"field_of_view_deg\": 50", "\"field_of_view_deg\": 50, \"distortion\": {\"k1\": -1}",
         "cameras[0].distortion: "},
        {"\"field_of_view_deg\": 50", "\"field_of_view_deg\": 50, \"split\": \"train\"",
         "cameras: there is no validation view"},
        {"\"radius\": 3", "\"radius\": 3, \"look_at\": [2.8190778623577, 0, 0]",
         "cameras[0].look_at: camera 0 looks straight"},
        {"\"radius\": 3", "\"radius\": 3, \"provider\": \"an\u00a0na\"",
         "cameras: the provider's name has the character"},
        {"\"cameras\": [", "\"cameras\": [" ORBIT_OF("Anna") ", " ORBIT_OF("anna") ", ",
         "provider \"anna\" looks like \"Anna\" of the scene"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"rain\"}"), "defects[0].kind: is not allowed"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"views\": [1]}"), "defects[0].strength: is missing"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"strength\": 2}"), "defects[0]: give exactly one of"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"strength\": 2, \"views\": [8]}"),
         "defects[0].views: view 8 is val"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"strength\": 2, \"views\": [24]}"),
         "defects[0].views: item 0 is not a view"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"strength\": 2, \"views\": [1, 1]}"),
         "defects[0].views: view 1 is corrupted already"},
        {NO_DEFECTS, DEFECTS("{\"kind\": \"blur\", \"strength\": 2, \"bias\": 1, \"share\": 1}"),
         "defects[0].bias: unknown key"},
        {NO_DEFECTS,
         DEFECTS("{\"kind\": \"blur\", \"strength\": 2, \"share\": 0.6}, {\"kind\": \"noise\", \"strength\": 1, "
                 "\"share\": 0.6}"),
         "defects[1].share: no clean train view is left"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        AUTO_FREE char *text = replaced(recipe_text, cases[i].from, cases[i].to);
        struct vw_scene *scene = NULL;
        ASSERT_CASE_FAILS(cases[i].to, open_text(text, headers, &scene), VW_ERROR_INPUT, cases[i].message);
        assert_null(scene);
    }
}

TEST(pixels_need_a_device) {
    struct vw_scene *scene = NULL;
    assert_int_equal(open_text(recipe_text, (struct vw_scene_params){0}, &scene), VW_ERROR_USAGE);
    assert_null(scene);
}

TEST(views_are_named_and_posed) {
    struct vw_scene *scene =
        open_changed(headers, "\"count\": 24", "\"count\": 24, \"provider\": \"anna\"", NULL, NULL);
    assert_int_equal(scene->view_count, 24);
    assert_string_equal(scene->views[17].name, "view_017");
    assert_string_equal(scene->views[17].provider, "anna");
    assert_string_equal(scene->box_source, "recipe");
    for (uint32_t v = 0; v < 24; v++) {
        enum vw_split expected = v % 8 == 0 ? VW_SPLIT_VAL : v % 8 == 4 ? VW_SPLIT_TEST : VW_SPLIT_TRAIN;
        assert_int_equal(scene->views[v].split, expected);
        assert_null(scene->views[v].image.pixels);
    }
    // The first camera stands at 20 degrees above the x axis, upright, and looks at the centre.
    const double c = cos(20 * M_PI / 180), s = sin(20 * M_PI / 180);
    const double expected[3][4] = {{0, -s, c, 3 * c}, {1, 0, 0, 0}, {0, c, s, 3 * s}};
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 4; j++) assert_near(scene->views[0].camera_to_world[i][j], expected[i][j], 1e-12);
    const struct vw_camera *camera = &scene->views[0].camera;
    assert_near(camera->focal_x_px, 16 / tan(25 * M_PI / 180), 1e-9);
    assert_true(camera->focal_y_px == camera->focal_x_px && camera->centre_x_px == 16 && camera->centre_y_px == 12);
}

TEST(a_path_may_name_its_split) {
    const char *two_paths =
        "\"split\": \"val\", \"count\": 3, \"field_of_view_deg\": 50}, {\"path\": \"orbit\", \"centre\": [0, 0, 0], "
        "\"radius\": 2, \"split\": \"train\", \"count\": 21";
    struct vw_scene *scene = open_changed(headers, "\"count\": 24", two_paths, NULL, NULL);
    assert_int_equal(scene->split_count[VW_SPLIT_VAL], 3);
    assert_int_equal(scene->split_count[VW_SPLIT_TRAIN], 21);
    assert_int_equal(scene->views[2].split, VW_SPLIT_VAL);
}

TEST(downscale_divides_the_camera) {
    struct vw_scene *scene =
        open_changed((struct vw_scene_params){.headers_only = true, .downscale = 5}, NULL, NULL, NULL, NULL);
    const struct vw_camera *camera = &scene->views[0].camera;
    assert_true(camera->width_px == 6 && camera->height_px == 4);
    assert_near(camera->focal_x_px, 3 / tan(25 * M_PI / 180), 1e-9);
}

TEST(the_ground_truth_lists_defects) {
    const char *defects = "\"defects\": [{\"kind\": \"exposure\", \"strength\": 2, \"views\": [1, 23]}, "
                          "{\"kind\": \"noise\", \"strength\": 0.2, \"share\": 0.17}, {\"kind\": \"blur\", "
                          "\"strength\": 2, \"every\": 4}, "
                          "{\"kind\": \"occluder\", \"strength\": 0.4, \"share\": 0.11}, "
                          "{\"kind\": \"wrong_pose\", \"strength\": 8, \"share\": 0.06}]";
    struct vw_scene *scene = open_changed(headers, "\"defects\": []", defects, NULL, NULL);
    assert_string_equal(scene->views[1].ground_truth, "exposure");
    assert_string_equal(scene->views[23].ground_truth, "exposure");
    assert_int_equal(count_truth(scene, "exposure"), 2);
    assert_int_equal(count_truth(scene, "noise"), 3);      // 0.17 * 18
    assert_int_equal(count_truth(scene, "blur"), 3);       // every fourth of the 13 still clean
    assert_int_equal(count_truth(scene, "occluder"), 2);   // 0.11 * 18
    assert_int_equal(count_truth(scene, "wrong_pose"), 1); // 0.06 * 18
    assert_int_equal(count_truth(scene, "clean"), 24 - 11);
    for (uint32_t v = 0; v < 24; v++)
        if (scene->views[v].split != VW_SPLIT_TRAIN) assert_string_equal(scene->views[v].ground_truth, "clean");
}

// A share falls on the same views every time, and on others with another seed.
TEST(the_seed_chooses_defective_views) {
    const char *defects = "\"defects\": [{\"kind\": \"noise\", \"strength\": 0.2, \"share\": 0.5}]";
    struct vw_scene *first = open_changed(headers, "\"defects\": []", defects, NULL, NULL);
    struct vw_scene *again = open_changed(headers, "\"defects\": []", defects, NULL, NULL);
    struct vw_scene *other = open_changed(headers, "\"defects\": []", defects, "\"seed\": 3", "\"seed\": 4");
    uint32_t different = 0;
    for (uint32_t v = 0; v < 24; v++) {
        assert_string_equal(first->views[v].ground_truth, again->views[v].ground_truth);
        different += strcmp(first->views[v].ground_truth, other->views[v].ground_truth) != 0;
    }
    assert_true(different > 0);
}

// Returns the angle of the rotation from one pose to the other.
static double angle_between(const double a[3][4], const double b[3][4]) {
    double trace = 0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) trace += a[i][j] * b[i][j];
    return acos((trace - 1) / 2) * 180 / M_PI;
}

TEST(a_wrong_pose_turns_only_its_views) {
    const char *defects = "\"defects\": [{\"kind\": \"wrong_pose\", \"strength\": 8, \"views\": [2, 5, 11]}]";
    struct vw_scene *wrong = open_changed(headers, "\"defects\": []", defects, NULL, NULL);
    struct vw_scene *right = open_changed(headers, NULL, NULL, NULL, NULL);
    for (uint32_t v = 0; v < 24; v++) {
        const struct vw_view *a = &wrong->views[v], *b = &right->views[v];
        if (strcmp(a->ground_truth, "wrong_pose")) {
            assert_memory_equal(a->camera_to_world, b->camera_to_world, sizeof a->camera_to_world);
            continue;
        }
        assert_near(angle_between(a->camera_to_world, b->camera_to_world), 8, 1e-6);
        check_turned(a, b);
    }
    assert_int_equal(count_truth(wrong, "wrong_pose"), 3);
}

// The scenes that come with viewworth can be read.
TEST(our_own_recipes_are_read) {
    const struct {
        const char *name;
        uint32_t views, corrupted;
        bool distorted, transparent;
    } scenes[] = {
        {"courtyard", 48, 12, false, false}, {"clean", 16, 0, false, false}, {"distorted", 24, 0, true, false},
        {"cutout", 24, 0, false, true},      {"sky", 24, 0, false, false},   {"unbounded", 28, 0, false, false},
        {"exposure", 30, 0, false, false},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(scenes); i++) {
        const struct vw_scene *scene = own_recipe_open(scenes[i].name, headers);
        assert_string_equal(scene->format, "recipe");
        assert_int_equal(scene->view_count, scenes[i].views);
        assert_int_equal(scene->view_count - count_truth(scene, "clean"), scenes[i].corrupted);
        assert_int_equal(scene->views[0].camera.k1 != 0, scenes[i].distorted);
        assert_int_equal(scene->has_alpha, scenes[i].transparent);
    }
}
