// Reading transforms.json: every key, every refusal.
#include "support/cmocka_test.h"

#include <sys/stat.h>
#include <unistd.h>

#include "support/temporary_folder.h"
#include "support/tiny_scene.h"

// Returns the camera of the first view of a scene with these keys.
static struct vw_camera camera_of(const char *folder, const char *keys, const char *frame_keys) {
    tiny_scene_write(folder, &(struct tiny_scene){.count = 3, .keys = keys, .frame_keys = frame_keys});
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = folder, .headers_only = true));
    struct vw_camera camera = scene->views[0].camera;
    return camera;
}

static void check_camera(const struct vw_camera *camera, double focal_x, double focal_y, double centre_x,
                         double centre_y) {
    assert_int_equal(camera->width_px, TINY_WIDTH_PX);
    assert_int_equal(camera->height_px, TINY_HEIGHT_PX);
    assert_near(camera->focal_x_px, focal_x, 1e-12);
    assert_near(camera->focal_y_px, focal_y, 1e-12);
    assert_near(camera->centre_x_px, centre_x, 1e-12);
    assert_near(camera->centre_y_px, centre_y, 1e-12);
}

FOLDER_TEST(every_focal_key_is_read) {
    const struct {
        const char *keys;
        double focal_x, focal_y, centre_x, centre_y;
    } cases[] = {
        {"\"camera_angle_x\": 1,", 4 / tan(0.5), 4 / tan(0.5), 4, 3},
        {"\"camera_angle_x\": 1, \"camera_angle_y\": 0.5,", 4 / tan(0.5), 3 / tan(0.25), 4, 3},
        {"\"x_fov\": 90,", 4, 4, 4, 3},
        {"\"x_fov\": 90, \"y_fov\": 60,", 4, 3 * sqrt(3), 4, 3},
        {"\"fl_x\": 7.5, \"camera_angle_x\": 1, \"x_fov\": 90,", 7.5, 7.5, 4, 3}, // a focal length wins
        {"\"fl_x\": 7, \"fl_y\": 8, \"cx\": 3.5, \"cy\": 2.25, \"w\": 8.0, \"h\": 6,", 7, 8, 3.5, 2.25},
        {"\"fl_y\": 9,", 9, 9, 4, 3},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_camera camera = camera_of(*state, cases[i].keys, NULL);
        check_camera(&camera, cases[i].focal_x, cases[i].focal_y, cases[i].centre_x, cases[i].centre_y);
    }
}

FOLDER_TEST(distortion_keys_are_read) {
    struct vw_camera camera = camera_of(*state,
                                        "\"fl_x\": 7, \"k1\": 0.1, \"k2\": -0.2, \"p1\": 0.01, \"p2\": -0.02, "
                                        "\"k3\": 0, \"k4\": 0.0, \"is_fisheye\": false, \"camera_model\": \"OPENCV\",",
                                        NULL);
    assert_true(camera.k1 == 0.1 && camera.k2 == -0.2 && camera.p1 == 0.01 && camera.p2 == -0.02);
}

FOLDER_TEST(lenses_follow_the_keys) {
    struct vw_camera camera = camera_of(*state, "\"fl_x\": 7, \"k1\": 0.1, \"k2\": 0.2, \"k3\": 0.3,", NULL);
    assert_int_equal(camera.lens, VW_LENS_POLYNOMIAL);
    assert_true(camera.k3 == 0.3);
    camera = camera_of(
        *state, "\"fl_x\": 7, \"camera_model\": \"FULL_OPENCV\", \"k3\": 0.3, \"k4\": 0.4, \"k5\": 0.5, \"k6\": 0.6,",
        NULL);
    assert_true(camera.lens == VW_LENS_POLYNOMIAL && camera.k3 == 0.3 && camera.k4 == 0.4 && camera.k5 == 0.5 &&
                camera.k6 == 0.6);
    camera = camera_of(*state, "\"fl_x\": 7, \"camera_model\": \"OPENCV_FISHEYE\", \"k1\": 0.1, \"k4\": 0.4,", NULL);
    assert_true(camera.lens == VW_LENS_FISHEYE && camera.k1 == 0.1 && camera.k4 == 0.4);
    camera = camera_of(*state, "\"fl_x\": 7, \"is_fisheye\": true, \"k4\": 0.4,", NULL);
    assert_true(camera.lens == VW_LENS_FISHEYE && camera.k4 == 0.4);
    camera = camera_of(*state, "\"fl_x\": 7, \"is_fisheye\": true,", "\"camera_model\": \"OPENCV\","); // the frame wins
    assert_int_equal(camera.lens, VW_LENS_POLYNOMIAL);
}

FOLDER_TEST(frame_keys_win) {
    struct vw_camera camera =
        camera_of(*state, "\"fl_x\": 7, \"cx\": 1, \"k1\": 0.1,", "\"camera_angle_x\": 1, \"cx\": 2, \"k1\": 0.3,");
    check_camera(&camera, 4 / tan(0.5), 4 / tan(0.5), 2, 3);
    assert_true(camera.k1 == 0.3);
    camera =
        camera_of(*state, "", "\"fl_x\": 7, \"fl_y\": 8, \"w\": 8, \"h\": 6, \"camera_model\": \"SIMPLE_RADIAL\",");
    check_camera(&camera, 7, 8, 4, 3);
}

FOLDER_TEST(intrinsics_of_another_size_are_scaled) {
    tiny_scene_write(*state,
                     &(struct tiny_scene){.keys = "\"fl_x\": 70, \"cx\": 41, \"cy\": 29, \"w\": 80, \"h\": 60,"});
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    check_camera(&scene->views[5].camera, 7, 7, 4.1, 2.9);
    assert_int_equal(scene->note_count, 1);
    check_note(scene, "8 photos: intrinsics scaled");
    tiny_scene_write(*state, &(struct tiny_scene){.keys = "\"fl_x\": 70, \"w\": 80, \"h\": 61,"});
    tiny_folder_refused(*state, "transforms.json", "frame 0", "80 x 61", "8 x 6");
}

FOLDER_TEST(extensions_may_be_missing) {
    tiny_scene_write(
        *state, &(struct tiny_scene){.count = 3, .name_prefix = "././images/", .name_suffix = ""}); // Blender's way
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_string_equal(scene->views[1].name, "images/01");
    assert_int_equal(rename(temporary_path(*state, "images/01.png"), temporary_path(*state, "images/01.PNG")), 0);
    scene = tiny_scene_open(SCENE_PARAMS(.path = temporary_path(*state, "transforms.json")));
    assert_int_equal(scene->view_count, 3);
    assert_string_equal(scene->format, "transforms");
}

FOLDER_TEST(the_pose_is_read) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 2});
    temporary_file(
        *state, "transforms.json",
        "{\"fl_x\": 7, \"frames\": [{\"file_path\": \"images/00.png\", \"transform_matrix\": "
        "[[0, 0, 2, 5], [2, 0, 0, 6], [0, 2, 0, 7], [0, 0, 0, 1]]}, " // a rotation times 2
        "{\"file_path\": \"images/01.png\", \"transform_matrix\": [[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]]}]}");
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    const double expected[3][4] = {{0, 0, 1, 5}, {1, 0, 0, 6}, {0, 1, 0, 7}};
    for (int i = 0; i < 12; i++)
        assert_near(scene->views[0].camera_to_world[i / 4][i % 4], expected[i / 4][i % 4], 1e-15);
}

FOLDER_TEST(bad_poses_are_refused) {
    static const char *const matrices[][2] = {
        {"null", "missing"},
        {"[[1,0,0,0],[0,1,0,0]]", "4 rows"},
        {"[[1,0,0,0],[0,1,0,0],[0,0,1],[0,0,0,1]]", "4 rows"},
        {"[[1,0,0,\"a\"],[0,1,0,0],[0,0,1,0],[0,0,0,1]]", "4 rows"},
        {"[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,1,1]]", "last row"},
        {"[[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]", "mirrored"},
        {"[[1,0.01,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]", "not a rotation"},
        {"[[1,0,0,0],[0,1.01,0,0],[0,0,1,0],[0,0,0,1]]", "not a rotation"},
        {"[[0,0,0,0],[0,0,0,0],[0,0,0,0],[0,0,0,1]]", "not a rotation"},
        {"[[1,0,0,1e300],[0,1,0,0],[0,0,1,0],[0,0,0,1]]", "position 1e+300"},
    };
    tiny_scene_write(*state, &(struct tiny_scene){.count = 2});
    for (size_t i = 0; i < VW_ARRAY_COUNT(matrices); i++) {
        AUTO_FREE char *json =
            vw_format_text("{\"fl_x\": 7, \"frames\": [{\"file_path\": \"images/00.png\", \"transform_matrix\": "
                           "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}, "
                           "{\"file_path\": \"images/01.png\", \"transform_matrix\": %s}]}",
                           matrices[i][0]);
        temporary_file(*state, "transforms.json", json);
        tiny_folder_refused(*state, "transforms.json: frame 1 (images/01.png)", "transform_matrix", matrices[i][1]);
    }
}

FOLDER_TEST(bad_keys_are_refused) {
    static const char *const cases[][2] = {
        {"", "focal length"},
        {"\"fl_x\": 0,", "fl_x"},
        {"\"fl_x\": 1e-300,", "fl_x"},
        {"\"fl_x\": 7, \"fl_y\": 0.0009,", "fl_y"},
        {"\"camera_angle_x\": 1e-300,", "angles"},
        {"\"x_fov\": 179.9999999999999,", "angles"},
        {"\"fl_x\": 7, \"w\": 8e-9,", "w, h"},
        {"\"fl_x\": -3,", "fl_x"},
        {"\"fl_x\": \"7\",", "fl_x"},
        {"\"camera_angle_x\": 3.2,", "camera_angle_x"},
        {"\"x_fov\": 180,", "x_fov"},
        {"\"fl_x\": 7, \"w\": 0,", "field w"},
        {"\"fl_x\": 1e10,", "fl_x"},
        {"\"fl_x\": 7, \"cy\": -1e300,", "field cy"},
        {"\"fl_x\": 7, \"k4\": -0.1,", "k4 is not supported with camera_model OPENCV"},
        {"\"fl_x\": 7, \"is_fisheye\": true, \"p1\": 0.1,", "p1"},
        {"\"fl_x\": 7, \"camera_model\": \"PINHOLE\", \"k1\": 0.1,", "k1"},
        {"\"fl_x\": 7, \"camera_model\": \"SIMPLE_RADIAL\", \"k2\": 0.1,", "k2"},
        {"\"fl_x\": 7, \"camera_model\": 3,", "camera_model"},
        {"\"fl_x\": 7, \"camera_model\": \"OPENCV\", \"is_fisheye\": true,",
         "is_fisheye contradicts camera_model OPENCV"},
        {"\"fl_x\": 7, \"camera_model\": \"THIN_PRISM_FISHEYE\",", "THIN_PRISM_FISHEYE"},
        {"\"fl_x\": 7, \"rolling_shutter\": [0, 0.1],", "rolling_shutter"},
        {"\"fl_x\": 7, \"camera_model\": \"EQUIRECTANGULAR\",", "EQUIRECTANGULAR"},
        {"\"fl_x\": 7, \"aabb_scale\": -1,", "aabb_scale"},
        {"\"fl_x\": 7, \"aabb_scale\": 2, \"scale\": 0,", "field scale"},
        {"\"fl_x\": 7, \"aabb_scale\": 2, \"offset\": [0.5, 0.5],", "offset"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .keys = cases[i][0]});
        tiny_folder_refused(*state, "transforms.json", cases[i][1]);
    }
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .frame_keys = "\"k5\": 1,"});
    tiny_folder_refused(*state, "frame 0 (images/00.png)", "k5");
}

// Smaller ones would vanish in squares.
FOLDER_TEST(the_scale_has_a_bound) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .scale_world = 1e-18});
    assert_non_null(tiny_scene_open(SCENE_PARAMS(.path = *state, .headers_only = true)));
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .scale_world = 1e-19});
    tiny_folder_refused(*state, "field transform_matrix", "scale the scene");
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3, .scale_world = 1e-200});
    tiny_folder_refused(*state, "field transform_matrix", "scale the scene");
}

FOLDER_TEST(unreadable_files_are_refused) {
    tiny_folder_refused(*state, *state, "no scene found");
    tiny_folder_refused("/no/such/scene", "/no/such/scene", "no such scene");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .format = "transforms"), VW_ERROR_INPUT, "transforms.json");
    tiny_scene_refused(SCENE_PARAMS(.path = *state, .format = "bundler"), VW_ERROR_USAGE, "bundler");
    static const struct refused_text cases[] = {
        {"{\"fl_x\": 7,\n \"frames\": [}", "transforms.json:2:13:", "JSON"},
        {"{\"fl_x\": 7,\n \"fl_y\": NaN}", "transforms.json:2:", ""},
        {"{\"fl_x\": 8, \"fl_x\": 9}", "transforms.json:1:", "duplicate"},
        {"{\"fl_x\": 1e999, \"frames\": []}", "transforms.json:1:", ""},
        {"[]", "transforms.json", "frames"},
        {"{}", "transforms.json", "frames"},
        {"{\"frames\": []}", "transforms.json", "frames"},
        {"{\"frames\": 3}", "transforms.json", "frames"},
        {"{\"fl_x\": 7, \"frames\": [{\"file_path\": 3}]}", "frame 0", "file_path"},
        {"{\"fl_x\": 7, \"frames\": [{\"file_path\": \"a\\nb\\u001b[2J\"}]}", "a?b?[2J", "control characters"},
    };
    ASSERT_TEXTS_REFUSED(*state, "transforms.json", cases, tiny_scene_try(SCENE_PARAMS(.path = path)));
}

// Nothing that a file holds may crash the reader, fill the memory or break the one line of a message.
FOLDER_TEST(hostile_files_are_refused) {
    enum { DEPTH = 100000 };
    static char deep[DEPTH + 1];
    memset(deep, '[', DEPTH);
    temporary_file(*state, "transforms.json", deep);
    tiny_folder_refused(*state, "transforms.json:1:", "depth");
    tiny_scene_write(*state, &(struct tiny_scene){.count = 2});
    assert_int_equal(truncate(temporary_path(*state, "transforms.json"), 1 << 30), 0);
    tiny_folder_refused(*state, "transforms.json", "larger than");
}

FOLDER_TEST(missing_photos_are_skipped) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 5});
    assert_int_equal(unlink(temporary_path(*state, "images/01.png")), 0);
    assert_int_equal(unlink(temporary_path(*state, "images/03.png")), 0);
    struct vw_scene *scene = tiny_scene_open(SCENE_PARAMS(.path = *state));
    assert_int_equal(scene->view_count, 3);
    assert_string_equal(scene->views[1].name, "images/02.png");
    assert_int_equal(scene->note_count, 1);
    check_note(scene, "2 photos skipped");
    check_note(scene, "images/01.png");
    assert_ptr_equal(scene->missing, scene->notes[0]);
    for (int i = 0; i < 5; i += 2) {
        char name[32];
        snprintf(name, sizeof name, "images/%02d.png", i);
        assert_int_equal(unlink(temporary_path(*state, name)), 0);
    }
    tiny_folder_refused(*state, "5 frames", "images/00.png");
}

FOLDER_TEST(photos_stay_in_the_folder) {
    static const char *const prefixes[] = {"../images/", "images/../../images/", "/images/"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(prefixes); i++) {
        tiny_scene_write(*state, &(struct tiny_scene){.count = 2, .name_prefix = prefixes[i]});
        tiny_folder_refused(*state, "frame 0", "file_path leaves the scene folder");
    }
    tiny_scene_write(*state, &(struct tiny_scene){.count = 2});
    AUTO_FOLDER char *elsewhere = temporary_folder_create();
    tiny_photo_write(temporary_path(elsewhere, "a.png"), 0);
    assert_int_equal(unlink(temporary_path(*state, "images/01.png")), 0);
    assert_int_equal(symlink(temporary_path(elsewhere, "a.png"), temporary_path(*state, "images/01.png")), 0);
    tiny_folder_refused(*state, "frame 1", "through a link");
    assert_int_equal(unlink(temporary_path(*state, "images/01.png")), 0);
    assert_int_equal(symlink("00.png", temporary_path(*state, "images/01.png")), 0); // inside is fine
    tiny_scene_open(SCENE_PARAMS(.path = *state));
}

// The scene file too: what it links to would show in messages.
FOLDER_TEST(the_scene_file_stays_in_the_folder) {
    AUTO_FOLDER char *elsewhere = temporary_folder_create();
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    assert_int_equal(rename(temporary_path(*state, "transforms.json"), temporary_path(elsewhere, "t.json")), 0);
    assert_int_equal(symlink(temporary_path(elsewhere, "t.json"), temporary_path(*state, "transforms.json")), 0);
    tiny_folder_refused(*state, "transforms.json", "through a link");
}

FOLDER_TEST(photos_that_are_no_files_are_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    const char *photo = temporary_path(*state, "images/01.png");
    assert_int_equal(unlink(photo), 0);
    assert_int_equal(mkdir(photo, 0777), 0);
    tiny_folder_refused(*state, "frame 1", "file_path", "plain file");
    assert_int_equal(rmdir(photo), 0);
    assert_int_equal(mkfifo(photo, 0666), 0); // opening one would wait forever
    tiny_folder_refused(*state, "frame 1", "file_path", "plain file");
}

FOLDER_TEST(bad_photos_are_refused) {
    tiny_scene_write(*state, &(struct tiny_scene){.count = 3});
    temporary_file(*state, "images/01.png", "not an image");
    tiny_folder_refused(*state, "transforms.json: frame 1", "images/01.png");
    temporary_file(
        *state, "transforms.json",
        "{\"fl_x\": 7, \"frames\": ["
        "{\"file_path\": \"images/00.png\", \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]},"
        "{\"file_path\": \"./images/00.png\", \"transform_matrix\": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
    tiny_folder_refused(*state, "frame 1", "images/00.png appears twice");
}
