// Reading COLMAP models: what every field becomes, binary and text, folders, and the lens of every camera model.
#include "support/cmocka_test.h"

#include <unistd.h>

#include "scene/builder.h"
#include "scene/formats/colmap.h"
#include "support/colmap_files.h"
#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

static struct vw_scene *open_colmap(const char *folder) {
    return tiny_scene_open(SCENE_PARAMS(.path = folder, .format = "colmap"));
}

// Rotates a vector by a unit quaternion: v + 2 u x (u x v + w v).
static void rotate(const double q[4], const double v[3], double rotated[3]) {
    double inner[3];
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        inner[i] = q[1 + j] * v[k] - q[1 + k] * v[j] + q[0] * v[i];
    }
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        rotated[i] = v[i] + 2 * (q[1 + j] * inner[k] - q[1 + k] * inner[j]);
    }
}

// Checks that COLMAP's formula and the view's matrix bring a world position to the same place in the camera's axes.
static void check_pose(const struct colmap_test_image *image, const struct vw_view *view) {
    const double world[3] = {0.3, -1.7, 2.9};
    double expected[3], found[3] = {0};
    rotate(image->rotation, world, expected);
    for (int i = 0; i < 3; i++) expected[i] += image->translation[i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) found[i] += view->camera_to_world[j][i] * (world[j] - view->camera_to_world[j][3]);
    assert_near(found[0], expected[0], 1e-12);
    assert_near(found[1], -expected[1], 1e-12); // y up
    assert_near(found[2], -expected[2], 1e-12); // looking along -z
}

static void check_test_scene(const struct vw_scene *scene, const struct colmap_test_model *model) {
    static const char *const names[] = {"images/a.png", "images/b.png", "images/sub/c d.png"};
    assert_string_equal(scene->format, "colmap");
    assert_int_equal(scene->view_count, 3);
    for (uint32_t v = 0; v < 3; v++) {
        assert_string_equal(scene->views[v].name, names[v]);
        check_pose(&model->images[v], &scene->views[v]);
        assert_int_equal(scene->views[v].camera.width_px, TINY_WIDTH_PX);
        assert_int_equal(scene->views[v].camera.height_px, TINY_HEIGHT_PX);
    }
    const struct vw_camera *opencv = &scene->views[0].camera, *radial = &scene->views[1].camera;
    assert_true(opencv->lens == VW_LENS_POLYNOMIAL && opencv->focal_x_px == 9.5 && opencv->focal_y_px == 9.25);
    assert_true(opencv->centre_x_px == 4.125 && opencv->centre_y_px == 2.875);
    assert_true(opencv->k1 == -0.125 && opencv->k2 == 0.0625 && opencv->p1 == 0.01 && opencv->p2 == -0.02 &&
                opencv->k3 == 0);
    // Its camera is for photos twice as large.
    assert_true(radial->focal_x_px == 10.25 && radial->focal_y_px == 10.25 && radial->centre_x_px == 4.125 &&
                radial->centre_y_px == 2.875);
    assert_true(radial->k1 == -0.03125 && radial->k2 == 0);
    check_note(scene, "1 photo: intrinsics scaled");
}

static void check_points(const struct vw_scene *scene) {
    assert_int_equal(scene->point_count, 2);
    assert_int_equal(scene->track_count, 4);
    const struct vw_point *first = &scene->points[0], *second = &scene->points[1];
    assert_true(first->position_world[0] == 0.25 && first->position_world[1] == -0.5 &&
                first->position_world[2] == 1.25);
    assert_true(first->rgb[0] == 10.0f / 255 && first->rgb[1] == 200.0f / 255 && first->rgb[2] == 1);
    assert_true(first->first_track == 0 && first->track_count == 2 && second->first_track == 2 &&
                second->track_count == 2);
    static const struct vw_track expected[] = {{0, 3.25f, 4.75f}, {1, 5.25f, 1.125f}, {1, 1.5f, 5.5f}, {0, 7, 0.5f}};
    for (int t = 0; t < 4; t++) {
        assert_int_equal(scene->tracks[t].view, expected[t].view);
        assert_true(scene->tracks[t].x_px == expected[t].x_px && scene->tracks[t].y_px == expected[t].y_px);
    }
}

FOLDER_TEST(every_field_is_read_from_text_and_binary) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    const struct vw_scene *scenes[2];
    for (int binary = 0; binary < 2; binary++) {
        (binary ? colmap_write_binary : colmap_write_text)(*state, "sparse/0", &model);
        scenes[binary] = open_colmap(*state);
        check_test_scene(scenes[binary], &model);
        check_points(scenes[binary]);
    }
    assert_memory_equal(scenes[0]->hash, scenes[1]->hash, VW_HASH_BYTES);
}

// Splats begin at points, and exposures are estimated where photos show them, so that a run with others is another run.
FOLDER_TEST(the_hash_is_also_of_points_and_their_views) {
    struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    const struct vw_scene *first = open_colmap(*state);
    model.points[0].position[1] += 1e-12;
    colmap_write_binary(*state, "sparse/0", &model);
    const struct vw_scene *moved = open_colmap(*state);
    model.points[0].position[1] -= 1e-12;
    model.points[0].rgb[2] ^= 1;
    colmap_write_binary(*state, "sparse/0", &model);
    const struct vw_scene *painted = open_colmap(*state);
    model.points[0].rgb[2] ^= 1;
    model.images[0].features[model.points[0].tracks[0][1]][1] += 0.001;
    colmap_write_binary(*state, "sparse/0", &model);
    const struct vw_scene *elsewhere = open_colmap(*state);
    assert_memory_not_equal(first->hash, elsewhere->hash, VW_HASH_BYTES);
    assert_memory_not_equal(first->hash, moved->hash, VW_HASH_BYTES);
    assert_memory_not_equal(first->hash, painted->hash, VW_HASH_BYTES);
    assert_memory_not_equal(moved->hash, painted->hash, VW_HASH_BYTES);
}

FOLDER_TEST(the_binary_model_wins) {
    struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse/0", &model);
    model.image_count = 2; // its points still name both
    colmap_write_text(*state, "sparse/0", &model);
    struct vw_scene *scene = open_colmap(*state);
    assert_int_equal(scene->view_count, 3);
    assert_int_equal(unlink(temporary_path(*state, "sparse/0/images.bin")), 0); // half a model is none
    scene = open_colmap(*state);
    assert_int_equal(scene->view_count, 2);
}

// Text as people edit it: comments, blank lines, tabs, carriage returns, no newline at the end.
FOLDER_TEST(comments_and_blank_lines_are_skipped) {
    tiny_photo_write(temporary_path(*state, "images/x.png"), 1);
    tiny_photo_write(temporary_path(*state, "images/y z.png"), 2);
    temporary_file(*state, "sparse/cameras.txt", "# c\r\n\r\n1\tPINHOLE  8 6 9 9 4 3\r\n");
    temporary_file(*state, "sparse/images.txt",
                   "1 1 0 0 0 0 0 5 1 x.png\r\n\r\n# between\n\n2 1 0 0 0 1 0 5 1 ./y z.png \r\n1 2 -1 3 4 77\r\n");
    temporary_file(*state, "sparse/points3D.txt", "# none\n\n");
    struct vw_scene *scene = open_colmap(*state);
    assert_int_equal(scene->view_count, 2);
    assert_string_equal(scene->views[1].name, "images/y z.png");
    assert_true(scene->views[0].camera.focal_x_px == 9 && scene->point_count == 0);
}

FOLDER_TEST(a_model_lies_in_one_of_two_folders) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    static const char *const names[] = {"sparse", "sparse/0"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(names); i++) {
        colmap_write_binary(*state, names[i], &model);
        assert_true(vw_colmap_probe(*state));
        AUTO_FREE char *found = vw_colmap_find(*state);
        assert_string_equal(found, temporary_path(*state, names[i]));
    }
    assert_false(vw_colmap_probe(temporary_path(*state, "images")));
    AUTO_FOLDER char *dense = temporary_folder_create();
    colmap_write_binary(dense, "dense/sparse", &model);
    tiny_photo_write(temporary_path(dense, "dense/images/a.png"), 1);
    tiny_photo_write(temporary_path(dense, "dense/images/b.png"), 2);
    struct vw_scene *scene = open_colmap(dense);
    assert_int_equal(scene->view_count, 2); // the third photo is missing, which is noted
    assert_string_equal(scene->views[1].name, "dense/images/b.png");
    check_note(scene, "1 photo skipped");
    check_note(scene, "sub/c d.png");
    assert_ptr_equal(scene->missing, scene->notes[0]);
}

// Points that a single view of the scene sees are not used as evidence.
FOLDER_TEST(points_of_missing_photos_are_dropped) {
    const struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse", &model);
    assert_int_equal(unlink(temporary_path(*state, "images/b.png")), 0);
    struct vw_scene *scene = open_colmap(*state);
    assert_true(scene->view_count == 2 && scene->point_count == 0 && scene->track_count == 0);
}

// ---- Lenses: COLMAP's formulas written out, model by model, for a position u, v = X/Z, Y/Z --------------------------

static void formula(const struct colmap_test_camera *camera, double u, double v, double *x_px, double *y_px) {
    const double *p = camera->params;
    double r = hypot(u, v), r2 = r * r, r4 = r2 * r2, r6 = r4 * r2, theta = atan(r), scale = 1, du = 0, dv = 0;
    bool single = camera->model == 0 || camera->model == 2 || camera->model == 3;
    double fx = p[0], fy = single ? p[0] : p[1], cx = single ? p[1] : p[2], cy = single ? p[2] : p[3];
    if (camera->model == 2) scale = 1 + p[3] * r2;
    if (camera->model == 3) scale = 1 + p[3] * r2 + p[4] * r4;
    if (camera->model == 4) scale = 1 + p[4] * r2 + p[5] * r4;
    if (camera->model == 5)
        scale =
            theta * (1 + p[4] * pow(theta, 2) + p[5] * pow(theta, 4) + p[6] * pow(theta, 6) + p[7] * pow(theta, 8)) / r;
    if (camera->model == 6) scale = (1 + p[4] * r2 + p[5] * r4 + p[8] * r6) / (1 + p[9] * r2 + p[10] * r4 + p[11] * r6);
    if (camera->model == 4 || camera->model == 6) {
        du = 2 * p[6] * u * v + p[7] * (r2 + 2 * u * u);
        dv = 2 * p[7] * u * v + p[6] * (r2 + 2 * v * v);
    }
    *x_px = fx * (u * scale + du) + cx;
    *y_px = fy * (v * scale + dv) + cy;
}

static const struct colmap_test_camera lenses[] = {
    {1, 0, "SIMPLE_PINHOLE", 8, 6, 3, {9, 4.25, 2.75}},
    {2, 1, "PINHOLE", 8, 6, 4, {9, 8, 4.25, 2.75}},
    {3, 2, "SIMPLE_RADIAL", 8, 6, 4, {9, 4.25, 2.75, -0.15}},
    {4, 3, "RADIAL", 8, 6, 5, {9, 4.25, 2.75, -0.15, 0.05}},
    {5, 4, "OPENCV", 8, 6, 8, {9, 8, 4.25, 2.75, -0.15, 0.05, 0.01, -0.02}},
    {6, 5, "OPENCV_FISHEYE", 8, 6, 8, {9, 8, 4.25, 2.75, -0.03, 0.02, -0.005, 0.001}},
    {7, 6, "FULL_OPENCV", 8, 6, 12, {9, 8, 4.25, 2.75, 0.4, -0.05, 0.003, -0.004, 0.02, 0.5, 0.06, -0.01}},
};

static void check_lens(const struct colmap_test_camera *lens, const struct vw_camera *camera) {
    for (int row = -4; row <= 4; row++)
        for (int column = -4; column <= 4; column++) {
            double u = column * 0.15 + 0.01, v = row * 0.12 - 0.01, x_px, y_px, expected_x_px, expected_y_px, back[3];
            formula(lens, u, v, &expected_x_px, &expected_y_px);
            assert_true(vw_camera_project(camera, (const double[]){2 * u, -2 * v, -2}, &x_px, &y_px));
            assert_near(x_px, expected_x_px, 1e-12);
            assert_near(y_px, expected_y_px, 1e-12);
            if (!vw_camera_unproject(camera, expected_x_px, expected_y_px, back))
                fail_msg("%s: no inverse at %g %g", lens->model_name, u, v);
            assert_near(back[0], u, 1e-9);
            assert_near(back[1], -v, 1e-9);
        }
}

FOLDER_TEST(every_lens_is_read) {
    for (int text = 0; text < 2; text++) {
        AUTO_FOLDER char *folder = temporary_folder_create();
        struct colmap_test_model model = {.camera_count = VW_ARRAY_COUNT(lenses),
                                          .image_count = VW_ARRAY_COUNT(lenses)};
        static const char *const names[] = {"0.png", "1.png", "2.png", "3.png", "4.png", "5.png", "6.png"};
        for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
            char path[32];
            snprintf(path, sizeof path, "images/%zu.png", i);
            tiny_photo_write(temporary_path(folder, path), (uint32_t)i);
            model.cameras[i] = lenses[i];
            model.images[i] = (struct colmap_test_image){
                .id = (uint32_t)i, .camera_id = lenses[i].id, .name = names[i], .rotation = {1}};
        }
        (text ? colmap_write_text : colmap_write_binary)(folder, "sparse/0", &model);
        struct vw_scene *scene = open_colmap(folder);
        for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) check_lens(&lenses[i], &scene->views[i].camera);
    }
}

// The corners of a wide fisheye's photo show no direction: they are masked, and the note says how many.
FOLDER_TEST(fisheye_corners_are_masked) {
    struct colmap_test_model model = colmap_test_scene(*state);
    model.cameras[0] = (struct colmap_test_camera){7, 5, "OPENCV_FISHEYE", 8, 6, 8, {2.5, 2.5, 4, 3}};
    colmap_write_binary(*state, "sparse/0", &model);
    struct vw_scene *scene = open_colmap(*state);
    const uint8_t *mask = scene->views[0].mask;
    assert_non_null(mask);
    static const size_t corners[] = {0, 7, 40, 47};
    for (int i = 0; i < 4; i++) assert_int_equal(mask[corners[i]], VW_MASK_BEYOND_LENS);
    assert_true(mask[3 * 8 + 4] == VW_MASK_KEEP && mask[3] == VW_MASK_KEEP);
    assert_null(scene->views[1].mask);
    check_note(scene, "the lens model has no inverse there");
}

// World coordinates of 10^6: the positions keep what their own rounding leaves, and the box does not notice.
FOLDER_TEST(a_scene_far_from_the_origin_is_the_same) {
    struct colmap_test_model model = colmap_test_scene(*state);
    colmap_write_binary(*state, "sparse", &model);
    struct vw_scene *near = open_colmap(*state);
    for (size_t i = 0; i < model.image_count; i++) {
        double moved[3];
        rotate(model.images[i].rotation, (const double[]){1e6, -1e6, 1e6}, moved);
        for (int k = 0; k < 3; k++) model.images[i].translation[k] -= moved[k];
    }
    colmap_write_binary(*state, "sparse", &model);
    struct vw_scene *far = open_colmap(*state);
    for (uint32_t v = 0; v < near->view_count; v++)
        for (int k = 0; k < 3; k++)
            assert_near(far->views[v].camera_to_world[k][3] - (k == 1 ? -1e6 : 1e6),
                        near->views[v].camera_to_world[k][3], 4e-9);
    assert_near(far->box.half_extent_world, near->box.half_extent_world, 1e-8);
}
