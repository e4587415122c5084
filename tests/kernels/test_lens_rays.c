// generate_rays on the lenses and the depth ranges that COLMAP scenes bring, against vw_camera_project() in double.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "detect/decide.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "support/gpu_fixture.h"
#include "train/effects/registry.h"
#include "train/pixels.h"
#include "viewworth/gpu.h"

static const double REPROJECTION_PX = 0.01;  // the bound that pinholes and OPENCV lenses keep
enum { SIDE = 25, RAYS = 640, SAMPLES = 8 }; // 25 x 25 positions, padded to a whole number of workgroups

struct lens {
    const char *name;
    struct vw_camera camera;
    uint32_t distortion; // the value of EFFECT_DISTORTION that it needs
};

#define BODY                                                                                                           \
    .width_px = 1920, .height_px = 1080, .focal_x_px = 1400, .focal_y_px = 1420, .centre_x_px = 951.5,                 \
    .centre_y_px = 548.25
#define WIDE                                                                                                           \
    .width_px = 1920, .height_px = 1080, .focal_x_px = 760, .focal_y_px = 750, .centre_x_px = 951.5,                   \
    .centre_y_px = 548.25, .lens = VW_LENS_FISHEYE
static const struct lens lenses[] = {
    {"pinhole", {BODY}, DISTORTION_NONE},
    {"opencv", {BODY, .k1 = -0.3, .k2 = 0.12, .p1 = 0.002, .p2 = -0.003}, DISTORTION_BASIC},
    {"barrel", {BODY, .k1 = -0.15}, DISTORTION_BASIC},
    {"pincushion, tangential", {BODY, .k1 = 0.25, .k2 = -0.08, .p1 = -0.01, .p2 = 0.008}, DISTORTION_BASIC},
    {"tangential alone", {BODY, .p1 = 0.02, .p2 = 0.02}, DISTORTION_BASIC},
    {"strong pincushion", {BODY, .k1 = 2.0, .k2 = 2.0}, DISTORTION_BASIC},
    {"strongest pincushion", {BODY, .k1 = 8.0, .k2 = 20.0}, DISTORTION_BASIC},
    {"k3", {BODY, .k1 = -0.3, .k2 = 0.12, .k3 = -0.03, .p1 = 0.002, .p2 = -0.003}, DISTORTION_ANY_LENS},
    {"full opencv",
     {BODY, .k1 = 0.4, .k2 = -0.05, .k3 = 0.02, .k4 = 0.5, .k5 = 0.06, .k6 = -0.01, .p1 = 0.003, .p2 = -0.004},
     DISTORTION_ANY_LENS},
    {"large rational",
     {BODY, .k1 = 12.5, .k2 = 20.1, .k3 = 1.9, .k4 = 12.8, .k5 = 24.3, .k6 = 7.1},
     DISTORTION_ANY_LENS},
    {"plain fisheye", {WIDE}, DISTORTION_ANY_LENS},
    {"fisheye", {WIDE, .k1 = -0.03, .k2 = 0.02, .k3 = -0.005, .k4 = 0.001}, DISTORTION_ANY_LENS},
    {"narrow fisheye",
     {BODY, .lens = VW_LENS_FISHEYE, .k1 = 0.2, .k2 = 0.1, .k3 = 0.05, .k4 = 0.02},
     DISTORTION_ANY_LENS},
};

// Returns the view of a camera `distance` box edges from the box's centre that looks at it; its z axis (backwards) is
// `back`.
static struct vw_view view_of(const struct vw_camera *camera, double distance, const struct vw_box *box) {
    static const double back[3] = {0.6, -0.48, 0.64}, right[3] = {0.8, 0.36, -0.48};
    struct vw_view view = {.camera = *camera};
    for (int i = 0; i < 3; i++) {
        view.camera_to_world[i][0] = right[i];
        view.camera_to_world[i][1] = back[(i + 1) % 3] * right[(i + 2) % 3] - back[(i + 2) % 3] * right[(i + 1) % 3];
        view.camera_to_world[i][2] = back[i];
        view.camera_to_world[i][3] = box->centre_world[i] + distance * 2 * box->half_extent_world * back[i];
    }
    return view;
}

static void pixel_position(const struct vw_camera *camera, uint32_t ray, float *x_px, float *y_px) {
    *x_px = (float)(ray % SIDE * (camera->width_px / (double)(SIDE - 1)));
    *y_px = (float)(ray / SIDE % SIDE * (camera->height_px / (double)(SIDE - 1)));
}

// Generates the rays of one view through a grid of positions over its photo.
static void generate(const struct vw_view *view, const struct vw_box *box, uint32_t distortion,
                     struct vw_ray rays[RAYS]) {
    struct vw_specialization specialization = {.samples = SAMPLES, .strata = SAMPLES, .effect_distortion = distortion};
    uint32_t words[VW_SPECIALIZATION_COUNT];
    memcpy(words, &specialization, sizeof words);
    struct vw_gpu_camera camera = vw_pixels_camera(view, box);
    struct vw_pixel pixels[RAYS];
    for (uint32_t i = 0; i < RAYS; i++) {
        pixels[i] = (struct vw_pixel){.weight = 1};
        pixel_position(&view->camera, i, &pixels[i].x_px, &pixels[i].y_px);
    }
    const size_t before = test_owned();
    struct vw_buffer *buffers[] = {test_buffer(test_gpu(), "cameras", sizeof camera),
                                   test_buffer(test_gpu(), "pixels", sizeof pixels),
                                   test_buffer(test_gpu(), "rays", RAYS * sizeof *rays),
                                   test_buffer(test_gpu(), "state", sizeof(struct vw_step_state))};
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_CAMERAS, .buffer = buffers[0]}, {.slot = VW_SLOT_PIXELS, .buffer = buffers[1]},
        {.slot = VW_SLOT_RAYS, .buffer = buffers[2]},    {.slot = VW_SLOT_STEP_STATE, .buffer = buffers[3]},
        {.slot = VW_SLOT_POSES, .unused = true},         {.slot = VW_SLOT_APPEARANCE, .unused = true}};
    const struct vw_pass_params params = {.shader = &vw_shader_generate_rays,
                                          .specialization = words,
                                          .specialization_count = VW_SPECIALIZATION_COUNT,
                                          .bindings = bindings,
                                          .binding_count = VW_ARRAY_COUNT(bindings)};
    const struct vw_pass *pass = test_pass(test_gpu(), params);
    struct vw_submission *submission = test_submission(test_gpu());
    const struct vw_push_rays push = {.ray_count = RAYS};
    ASSERT_OK(vw_buffer_write(buffers[0], 0, &camera, sizeof camera));
    ASSERT_OK(vw_buffer_write(buffers[1], 0, pixels, sizeof pixels));
    vw_submission_begin(submission);
    vw_submission_dispatch(submission, pass, &push, sizeof push, RAYS);
    ASSERT_OK(vw_submission_submit(submission));
    ASSERT_OK(vw_submission_wait(submission));
    ASSERT_OK(vw_buffer_read(buffers[2], 0, rays, RAYS * sizeof *rays));
    test_release_to(before);
}

// Computes a point of a ray in the view's camera axes, in box edges.
static void point_in_camera(const struct vw_view *view, const struct vw_box *box, const struct vw_ray *ray,
                            double parameter, double point[3]) {
    const double origin[3] = {ray->origin_near.x, ray->origin_near.y, ray->origin_near.z};
    const double direction[3] = {ray->direction_stride.x, ray->direction_stride.y, ray->direction_stride.z};
    for (int column = 0; column < 3; column++) {
        point[column] = 0;
        for (int row = 0; row < 3; row++) {
            double position =
                (view->camera_to_world[row][3] - box->centre_world[row]) / (2 * box->half_extent_world) + 0.5;
            point[column] += view->camera_to_world[row][column] * (origin[row] + parameter * direction[row] - position);
        }
    }
}

static const struct vw_box box = {.centre_world = {10, -20, 5}, .half_extent_world = 3};

TEST_CASES(rays_reproject_through_every_lens, i, VW_ARRAY_COUNT(lenses)) {
    for (uint32_t distortion = lenses[i].distortion; distortion <= DISTORTION_ANY_LENS;
         distortion++) { // the richer undo it as well
        struct vw_view view = view_of(&lenses[i].camera, 0.1, &box);
        struct vw_ray rays[RAYS];
        generate(&view, &box, distortion, rays);
        for (uint32_t k = 0; k < RAYS; k++) {
            double ahead[3], x_px, y_px;
            float given_x_px, given_y_px;
            pixel_position(&view.camera, k, &given_x_px, &given_y_px);
            point_in_camera(&view, &box, &rays[k], 1, ahead);
            assert_true(vw_camera_project(&view.camera, ahead, &x_px, &y_px));
            if (!(hypot(x_px - given_x_px, y_px - given_y_px) < REPROJECTION_PX))
                fail_msg("%s, EFFECT_DISTORTION %u: (%g, %g) px comes back as (%g, %g)", lenses[i].name, distortion,
                         given_x_px, given_y_px, x_px, y_px);
        }
    }
}

// Checks the depths at which a ray's samples begin and end.
static void check_depths(const struct vw_view *view, const struct vw_ray *whole, const struct vw_ray *cut,
                         double near_edges, double far_edges, uint32_t *cut_count) {
    double first[3], last[3], from[3], to[3];
    point_in_camera(view, &box, whole, whole->origin_near.w, first);
    point_in_camera(view, &box, whole, whole->origin_near.w + SAMPLES * whole->direction_stride.w, last);
    double near = fmax(-first[2], near_edges), far = fmin(-last[2], far_edges);
    if (whole->direction_stride.w == 0 || fabs(near - far) < 1e-4)
        return; // misses the box, or may be called either way
    if (near > far) {
        assert_true(cut->direction_stride.w == 0);
        return;
    }
    point_in_camera(view, &box, cut, cut->origin_near.w, from);
    point_in_camera(view, &box, cut, cut->origin_near.w + SAMPLES * cut->direction_stride.w, to);
    assert_near(-from[2], near, 2e-6);
    assert_near(-to[2], far, 2e-6);
    *cut_count += near > -first[2] && far < -last[2];
}

TEST(samples_lie_between_near_and_far) {
    static const double distances[] = {0.1, 2, 100, 1e5};
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        struct vw_camera camera = {BODY};
        if (distances[i] > 1) camera.focal_x_px = camera.focal_y_px = 1000 * distances[i];
        struct vw_view view = view_of(&camera, distances[i], &box);
        double edge = 2 * box.half_extent_world,
               margin = fmin(0.2, 0.1 * distances[i]); // in depth, around the box's centre
        struct vw_ray whole[RAYS], cut[RAYS];
        uint32_t cut_count = 0;
        generate(&view, &box, DISTORTION_NONE, whole);
        double near_edges = fmax(distances[i] - margin, 0.1), far_edges = distances[i] + margin;
        view.near_world = near_edges * edge / 0.9; // the margins of vw_pixels_camera(): nine tenths and eleven tenths
        view.far_world = far_edges * edge / 1.1;
        generate(&view, &box, DISTORTION_NONE, cut);
        for (uint32_t k = 0; k < RAYS; k++) check_depths(&view, &whole[k], &cut[k], near_edges, far_edges, &cut_count);
        assert_true(cut_count > 100);
    }
}

// A depth range that holds the whole box changes no bit, and neither does the absence of one.
TEST(wide_ranges_change_nothing) {
    struct vw_camera camera = {BODY};
    struct vw_view view = view_of(&camera, 2, &box);
    struct vw_ray without[RAYS], with[RAYS];
    generate(&view, &box, DISTORTION_NONE, without);
    view.near_world = 0.001;
    view.far_world = 1e6;
    generate(&view, &box, DISTORTION_NONE, with);
    assert_memory_equal(without, with, sizeof with);
}

TEST_CASES(the_cheapest_sufficient_variant_is_chosen, i, VW_ARRAY_COUNT(lenses)) {
    struct vw_view views[2] = {{.camera = lenses[0].camera}, {.camera = lenses[i].camera}};
    const struct vw_scene scene = {.views = views, .view_count = 2};
    struct vw_effect_verdict verdicts[VW_EFFECT_COUNT_MAX];
    struct vw_specialization specialization = {0};
    uint32_t count;
    assert_int_equal(vw_effects_find_facts(&scene, "auto", verdicts, &count), VW_OK);
    vw_effects_specialise(verdicts, &scene, &specialization);
    assert_int_equal(specialization.effect_distortion, lenses[i].distortion);
}

TEST_GROUP(NULL, test_gpu_close)
