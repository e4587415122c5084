// Paths of free cameras against closed forms, and hostile files of them.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "scene/camera_path.h"
#include "support/synthetic_scene.h"
#include "support/temporary_folder.h"

// Makes eight cameras about the z axis that look at (1, 1, 1) from some way above or below.
static struct vw_scene *ring(void) {
    return synthetic_scene(&(struct synthetic_scene_params){
        .train_views = 6, .val_views = 2, .width_px = 16, .height_px = 12, .world_offset = 1, .k1 = 0.1});
}

static struct vw_camera_path make(const struct vw_scene *scene, const char *name, uint32_t count) {
    struct vw_camera_path path = {0};
    assert_true(vw_camera_path_is(name));
    ASSERT_OK(vw_camera_path_make(scene, name, 0, count, &path));
    assert_int_equal(path.count, count);
    return path;
}

static double dot(const struct vw_view *a, int column_a, const struct vw_view *b, int column_b) {
    double sum = 0;
    for (int i = 0; i < 3; i++) sum += a->camera_to_world[i][column_a] * b->camera_to_world[i][column_b];
    return sum;
}

static void assert_rotation(const struct vw_view *frame) {
    for (int a = VW_POSE_RIGHT; a <= VW_POSE_BACK; a++)
        for (int b = a; b <= VW_POSE_BACK; b++) assert_near(dot(frame, a, frame, b), a == b, 1e-12);
    for (int i = 0; i < 3; i++) // right-handed
        assert_near(
            frame->camera_to_world[i][VW_POSE_BACK],
            frame->camera_to_world[(i + 1) % 3][VW_POSE_RIGHT] * frame->camera_to_world[(i + 2) % 3][VW_POSE_UP] -
                frame->camera_to_world[(i + 2) % 3][VW_POSE_RIGHT] * frame->camera_to_world[(i + 1) % 3][VW_POSE_UP],
            1e-12);
}

static void assert_looks_at(const struct vw_view *frame, const double target[3]) {
    double offset[3], distance = 0;
    for (int i = 0; i < 3; i++) offset[i] = frame->camera_to_world[i][VW_POSE_POSITION] - target[i];
    for (int i = 0; i < 3; i++) distance += offset[i] * offset[i];
    for (int i = 0; i < 3; i++) assert_near(frame->camera_to_world[i][VW_POSE_BACK], offset[i] / sqrt(distance), 1e-9);
}

TEST(an_orbit_is_a_circle_that_looks_at_the_centre) {
    const double centre[3] = {1, 1, 1};
    struct vw_scene *scene = ring();
    struct vw_camera_path path = make(scene, "orbit", 12);
    const double(*first)[4] = path.frames[0].camera_to_world;
    double radius = hypot(first[0][VW_POSE_POSITION] - 1, first[1][VW_POSE_POSITION] - 1);
    // |back| before it is a unit vector: 1, or with height 0.4 for the four cameras at odd eighths of a turn
    assert_near(radius, 0.5 * (3 + 3 / hypot(1, 0.4)), 1e-9);
    for (uint32_t f = 0; f < 12; f++) {
        const double(*pose)[4] = path.frames[f].camera_to_world;
        double angle = 2 * M_PI * f / 12;
        assert_rotation(&path.frames[f]);
        assert_looks_at(&path.frames[f], centre);
        assert_near(pose[0][VW_POSE_POSITION], 1 + radius * cos(angle), 1e-9); // view 0 is at angle 0
        assert_near(pose[1][VW_POSE_POSITION], 1 + radius * sin(angle), 1e-9);
        assert_near(pose[2][VW_POSE_POSITION], 1, 1e-9);
        assert_near(pose[2][VW_POSE_UP], 1, 1e-9);
        assert_near(pose[2][VW_POSE_RIGHT], 0, 1e-9);
    }
    assert_int_equal(path.frames[3].camera.width_px, 16);
    assert_true(path.frames[3].camera.focal_x_px == scene->views[0].camera.focal_x_px);
    assert_true(path.frames[3].camera.k1 == 0);
    vw_camera_path_free(&path);
}

// Makes five cameras in a plane that all look along -z.
static struct vw_scene *wall(void) {
    static const double at[5][2] = {{0, 0}, {1, 0}, {-1, 0}, {0, 0.5}, {0, -0.5}};
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 1, .width_px = 8, .height_px = 6});
    for (uint32_t v = 0; v < 5; v++)
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 4; j++)
                scene->views[v].camera_to_world[i][j] = j == VW_POSE_POSITION ? (i < 2 ? at[v][i] : 4) : i == j;
    return scene; // the box is about the origin
}

TEST(a_spiral_turns_about_the_mean_camera) {
    const double target[3] = {0, 0, 0};
    struct vw_scene *scene = wall();
    struct vw_camera_path path = make(scene, "spiral", 16);
    for (uint32_t f = 0; f < 16; f++) {
        const double(*pose)[4] = path.frames[f].camera_to_world;
        double angle = 4 * M_PI * f / 16; // two turns, as wide as the 90 % quantiles of 0, 0, 0, 1, 1 and so on
        assert_rotation(&path.frames[f]);
        assert_looks_at(&path.frames[f], target);
        assert_near(pose[0][VW_POSE_POSITION], cos(angle), 1e-9);
        assert_near(pose[1][VW_POSE_POSITION], -0.5 * sin(angle), 1e-9);
        assert_near(pose[2][VW_POSE_POSITION], 4, 1e-9);
    }
    vw_camera_path_free(&path);
}

TEST(a_path_through_the_cameras_passes_through_them_in_order) {
    struct vw_scene *scene = ring();
    for (uint32_t v = 0; v < 8; v++) { // named 7, 8, ..., 14: "10" follows "9"
        free(scene->views[v].name);
        scene->views[v].name = vw_format_text("%u", 14 - v);
    }
    struct vw_camera_path path = make(scene, "cameras", 15); // every other frame is a camera
    for (uint32_t f = 0; f < 15; f++) assert_rotation(&path.frames[f]);
    for (uint32_t f = 0; f < 15; f += 2)
        assert_memory_equal(path.frames[f].camera_to_world, scene->views[7 - f / 2].camera_to_world,
                            sizeof path.frames[f].camera_to_world);
    const struct vw_view *from = &scene->views[5], *to = &scene->views[4], *between = &path.frames[5];
    for (int axis = VW_POSE_RIGHT; axis <= VW_POSE_BACK; axis++) // half of the way: as far from both
        assert_near(dot(between, axis, from, axis), dot(between, axis, to, axis), 1e-12);
    for (int i = 0; i < 3; i++) { // Catmull-Rom at 1/2: (-1, 9, 9, -1) / 16
        double p[4];
        for (uint32_t k = 0; k < 4; k++) p[k] = scene->views[6 - k].camera_to_world[i][VW_POSE_POSITION];
        assert_near(between->camera_to_world[i][VW_POSE_POSITION], (9 * (p[1] + p[2]) - p[0] - p[3]) / 16, 1e-12);
    }
    vw_camera_path_free(&path);
}

TEST(turns_take_the_shortest_arc) {
    struct vw_scene *scene = wall();
    const double turn[5] = {0, 170, 190, 340, 0}; // degrees about z
    for (uint32_t v = 0; v < 5; v++) {
        double s = sin(turn[v] * M_PI / 180), c = cos(turn[v] * M_PI / 180);
        double m[3][3] = {{c, -s, 0}, {s, c, 0}, {0, 0, 1}};
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) scene->views[v].camera_to_world[i][j] = m[i][j];
    }
    const double middle[4] = {85, 180, 265, 350};
    struct vw_camera_path path = make(scene, "cameras", 9);
    for (uint32_t f = 1; f < 9; f += 2) {
        assert_near(path.frames[f].camera_to_world[0][VW_POSE_RIGHT], cos(middle[f / 2] * M_PI / 180), 1e-9);
        assert_near(path.frames[f].camera_to_world[1][VW_POSE_RIGHT], sin(middle[f / 2] * M_PI / 180), 1e-9);
        assert_rotation(&path.frames[f]);
    }
    vw_camera_path_free(&path);
}

TEST(cameras_that_tell_no_path_are_refused) {
    struct vw_camera_path path = {0};
    struct vw_scene *scene = ring();
    ASSERT_FAILS(vw_camera_path_make(scene, "spiral", 0, 5, &path), VW_ERROR_USAGE, "do not face one way");
    struct vw_scene *above = wall();
    for (uint32_t v = 0; v < 5; v++) // all at one place above the box, looking down with another up
        for (int i = 0; i < 3; i++)
            above->views[v].camera_to_world[i][VW_POSE_POSITION] = 4 * above->views[v].camera_to_world[i][VW_POSE_UP];
    ASSERT_FAILS(vw_camera_path_make(above, "orbit", 0, 5, &path), VW_ERROR_USAGE, "above what they look at");
    assert_null(path.frames);
}

TEST(a_frame_sees_as_far_as_the_views_about_it) {
    struct vw_scene *scene = wall();
    struct vw_view frame = scene->views[1];
    for (uint32_t v = 0; v < 4; v++) scene->views[v].near_world = 1 + v, scene->views[v].far_world = 10 + v;
    frame.near_world = frame.far_world = 0;
    vw_camera_path_set_depths(scene, &frame);
    assert_true(frame.near_world == 2 && frame.far_world == 11); // in the place of view 1
    frame.camera_to_world[0][VW_POSE_POSITION] = 0;              // now view 0's
    vw_camera_path_set_depths(scene, &frame);
    assert_true(frame.near_world == 1 && frame.far_world == 10);
    frame.camera_to_world[1][VW_POSE_POSITION] = 100;
    vw_camera_path_set_depths(scene, &frame);
    assert_near(frame.near_world, 2.5, 0.05); // far away all count alike
    for (uint32_t v = 0; v < 4; v++) scene->views[v].far_world = 0;
    frame.near_world = frame.far_world = 0;
    vw_camera_path_set_depths(scene, &frame);
    assert_true(frame.near_world == 0 && frame.far_world == 0);
}

// ---- From outside ---------------------------------------------------------------------------------------------------

#define POSE "1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 4"
#define NERFSTUDIO(fields, item) "{" fields "\"camera_path\": [" item "]}"
#define SIZE "\"render_width\": 200, \"render_height\": 100, "
#define ITEM "{\"camera_to_world\": [" POSE ", 0, 0, 0, 1], \"fov\": 90}"

static enum vw_status read_text(const char *folder, const char *text, struct vw_camera_path *path) {
    return vw_camera_path_read(wall(), temporary_file(folder, "path.json", text), 0, path);
}

FOLDER_TEST(a_path_of_nerfstudio_is_read) {
    struct vw_camera_path path = {0};
    ASSERT_OK(read_text(*state, NERFSTUDIO("\"camera_type\": \"perspective\", " SIZE, ITEM ", " ITEM), &path));
    assert_int_equal(path.count, 2);
    const struct vw_camera *camera = &path.frames[1].camera;
    assert_true(camera->width_px == 200 && camera->height_px == 100 && camera->centre_x_px == 100);
    assert_near(camera->focal_x_px, 50, 1e-9); // the angle is from top to bottom
    assert_near(camera->focal_y_px, 50, 1e-9);
    assert_true(path.frames[1].camera_to_world[0][VW_POSE_POSITION] == 0.5 &&
                path.frames[1].camera_to_world[2][VW_POSE_POSITION] == 4);
    vw_camera_path_free(&path);
}

FOLDER_TEST(frames_of_a_transforms_file_are_read) {
    struct vw_camera_path path = {0};
    ASSERT_OK(
        read_text(*state,
                  "{\"fl_x\": 9, \"k1\": 0.1, \"frames\": [{\"transform_matrix\": [[1,0,0,2],[0,1,0,0],[0,0,1,0]]}, "
                  "{\"w\": 32, \"h\": 20, \"fl_x\": 7, \"transform_matrix\": [[1,0,0,3],[0,1,0,0],[0,0,1,0]]}]}",
                  &path));
    assert_int_equal(path.count, 2);
    assert_true(path.frames[0].camera.width_px == 8 && path.frames[0].camera.focal_y_px == 9); // as the view
    assert_true(path.frames[1].camera.width_px == 32 && path.frames[1].camera.focal_y_px == 7);
    assert_true(path.frames[1].camera_to_world[0][VW_POSE_POSITION] == 3 && path.frames[1].camera.k1 == 0);
    vw_camera_path_free(&path);
}

FOLDER_TEST(frames_without_a_focal_length_have_that_of_the_view) {
    struct vw_camera_path path = {0};
    const struct vw_camera *own = &wall()->views[0].camera;
    ASSERT_OK(read_text(*state,
                        "{\"frames\": [{\"transform_matrix\": [[1,0,0,2],[0,1,0,0],[0,0,1,0]]}, "
                        "{\"w\": 20, \"h\": 32, \"transform_matrix\": [[1,0,0,3],[0,1,0,0],[0,0,1,0]]}]}",
                        &path));
    assert_near(path.frames[0].camera.focal_x_px, own->focal_x_px, 1e-9);
    assert_true(path.frames[0].camera.width_px == own->width_px && path.frames[1].camera.height_px == 32);
    double factor = 32 / fmax(own->width_px, own->height_px); // a portrait has it by the longer side
    assert_near(path.frames[1].camera.focal_x_px, factor * own->focal_x_px, 1e-9);
    assert_near(path.frames[1].camera.focal_y_px, factor * own->focal_y_px, 1e-9);
    vw_camera_path_free(&path);
}

FOLDER_TEST(hostile_paths_are_refused) {
    static const struct refused_text cases[] = {
        {"[]", "path.json: neither field camera_path nor field frames"},
        {"{\"frames\": 7}", "neither field camera_path nor field frames"},
        {"{\"frames\": [7], \"fl_x\": 5}", "frame 0: field transform_matrix is missing"},
        {"{\"fl_x\": 5, \"w\": 1e9, \"frames\": [{\"transform_matrix\": [[1,0,0,2],[0,1,0,0],[0,0,1,0]]}]}",
         "frame 0: field w must be an integer from 1 to 8192"},
        {"{\"camera_path\": []}", "path.json: render_width: is missing"},
        {NERFSTUDIO(SIZE, ""), "field camera_path is empty"},
        {NERFSTUDIO("\"camera_type\": \"equirectangular\", " SIZE, ITEM), "path.json: camera_type: is not allowed"},
        {NERFSTUDIO("\"render_width\": 99999, \"render_height\": 1, ", ITEM), "render_width: is not allowed; give"},
        {NERFSTUDIO(SIZE, ITEM ", {\"fov\": 5}"), "path.json: camera_path[1].camera_to_world: is missing"},
        {NERFSTUDIO(SIZE, "{\"camera_to_world\": [1, 2], \"fov\": 5}"), "camera_to_world: expected an array of 16"},
        {NERFSTUDIO(SIZE, "{\"camera_to_world\": [" POSE ", 0, 0, 0, 1]}"), "camera_path[0].fov: is missing"},
        {NERFSTUDIO(SIZE, "{\"camera_to_world\": [" POSE ", 0, 0, 0, 1], \"fov\": 180}"), "fov: 180 is out of range"},
        {NERFSTUDIO(SIZE, "{\"camera_to_world\": [" POSE ", 0, 0, 0, 2], \"fov\": 50}"),
         "camera_path[0]: field camera_to_world: last row is not 0 0 0 1"},
        {NERFSTUDIO(SIZE, "{\"camera_to_world\": [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1], \"fov\": 50}"),
         "camera_path[0]: field camera_to_world: its 3 x 3 part is not a rotation"},
        {NERFSTUDIO(SIZE, "7"), "camera_path[0].camera_to_world: is missing"},
    };
    const struct vw_scene *scene = wall();
    struct vw_camera_path read = {0};
    ASSERT_TEXTS_REFUSED(*state, "path.json", cases, vw_camera_path_read(scene, path, 0, &read));
    assert_null(read.frames);
}

TEST(a_pose_is_read_from_numbers) {
    struct vw_camera_path path = {0};
    struct vw_scene *scene = ring();
    ASSERT_OK(vw_camera_path_parse(scene, "--pose", "1 0 0 2 0 1 0 3  0 0 1 4", 0, &path));
    assert_true(path.count == 1 && path.frames[0].camera_to_world[1][VW_POSE_POSITION] == 3);
    assert_true(path.frames[0].camera.focal_x_px == scene->views[0].camera.focal_x_px && path.frames[0].camera.k1 == 0);
    vw_camera_path_free(&path);
    path.frames = NULL;
    ASSERT_OK(vw_camera_path_parse(scene, "--pose", POSE ", 0, 0, 0, 1", 0, &path));
    vw_camera_path_free(&path);
    path.frames = NULL;
    static const char *const refused[] = {
        "", "1 2 3", POSE " 0 0 0 1 5", POSE " x", "nan 0 0 0 0 1 0 0 0 0 1 0", POSE ", 0, 0, 0"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(refused); i++)
        ASSERT_FAILS(vw_camera_path_parse(scene, "--pose", refused[i], 0, &path), VW_ERROR_USAGE,
                     "--pose: give the 12 or 16 numbers");
    ASSERT_FAILS(vw_camera_path_parse(scene, "--pose", "2 0 0 0 0 1 0 0 0 0 1 0", 0, &path), VW_ERROR_USAGE,
                 "--pose: matrix: its 3 x 3 part is not a rotation");
    assert_null(path.frames);
}
