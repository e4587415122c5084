// generate_rays on the lenses and the depth ranges that COLMAP scenes bring, against vw_camera_project() in double.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "detect/decide.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"
#include "train/effects/registry.h"

static const double REPROJECTION_PX = 0.01; // the bound that pinholes and OPENCV lenses keep
enum { SIDE = 25, RAYS = SIDE * SIDE, SAMPLES = 8 };

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

static const struct vw_box box = {.centre_world = {10, -20, 5}, .half_extent_world = 3};

// Opens a bench with a pixel at each place of a grid over the photo of view 0, whose lens may be of the variant.
static struct step_bench *open_bench(uint32_t distortion) {
    const struct step_case setup = {.name = "lenses",
                                    .seed = 361,
                                    .rays = RAYS,
                                    .samples = SAMPLES,
                                    .levels = 2,
                                    .log2_table = 4,
                                    .width = 16,
                                    .distortion = distortion};
    struct step_bench *bench = step_bench_open(&setup);
    bench->scene->box = box;
    for (uint32_t i = 0; i < RAYS; i++) bench->pixels[i].view = 0;
    return bench;
}

// Makes the rays of a camera `distance` box edges from the box's centre, which looks at it.
static const struct vw_ray *rays_of(struct step_bench *bench, const struct vw_camera *camera, double distance) {
    static const double back[3] = {0.6, -0.48, 0.64}, centre[3] = {0.5, 0.5, 0.5};
    struct vw_view *view = &bench->scene->views[0];
    double position[3];
    for (int i = 0; i < 3; i++) position[i] = centre[i] + distance * back[i];
    rays_look(view, &box, position, centre);
    view->camera = *camera;
    for (uint32_t i = 0; i < RAYS; i++) {
        bench->pixels[i].x_px = (float)(i % SIDE * (camera->width_px / (double)(SIDE - 1)));
        bench->pixels[i].y_px = (float)(i / SIDE * (camera->height_px / (double)(SIDE - 1)));
    }
    return rays_make(bench);
}

// Computes a point of a ray in the view's camera axes, in box edges.
static void point_in_camera(const struct vw_view *view, const struct vw_ray *ray, double parameter, double point[3]) {
    const double origin[3] = {ray->origin_near.x, ray->origin_near.y, ray->origin_near.z};
    const double direction[3] = {ray->direction_stride.x, ray->direction_stride.y, ray->direction_stride.z};
    for (int column = 0; column < 3; column++) {
        point[column] = 0;
        for (int row = 0; row < 3; row++) {
            double position =
                (view->camera_to_world[row][3] - box.centre_world[row]) / (2 * box.half_extent_world) + 0.5;
            point[column] += view->camera_to_world[row][column] * (origin[row] + parameter * direction[row] - position);
        }
    }
}

// The richer variants undo what the simpler ones do.
TEST_CASES(rays_reproject_through_every_lens, distortion, DISTORTION_ANY_LENS + 1) {
    struct step_bench *bench = open_bench((uint32_t)distortion);
    const struct vw_view *view = &bench->scene->views[0];
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        if (lenses[i].distortion > distortion) continue;
        const struct vw_ray *rays = rays_of(bench, &lenses[i].camera, 0.1);
        for (uint32_t k = 0; k < RAYS; k++) {
            const struct vw_pixel *pixel = &bench->pixels[k];
            double ahead[3], x_px, y_px;
            point_in_camera(view, &rays[k], 1, ahead);
            assert_true(vw_camera_project(&view->camera, ahead, &x_px, &y_px));
            if (!(hypot(x_px - pixel->x_px, y_px - pixel->y_px) < REPROJECTION_PX))
                fail_msg("%s, EFFECT_DISTORTION %zu: (%g, %g) px comes back as (%g, %g)", lenses[i].name, distortion,
                         pixel->x_px, pixel->y_px, x_px, y_px);
        }
    }
}

// Checks the depths at which a ray's samples begin and end.
static void check_depths(const struct vw_view *view, const struct vw_ray *whole, const struct vw_ray *cut,
                         double near_edges, double far_edges, uint32_t *cut_count) {
    double first[3], last[3], from[3], to[3];
    point_in_camera(view, whole, whole->origin_near.w, first);
    point_in_camera(view, whole, whole->origin_near.w + SAMPLES * whole->direction_stride.w, last);
    double near = fmax(-first[2], near_edges), far = fmin(-last[2], far_edges);
    if (whole->direction_stride.w == 0 || fabs(near - far) < 1e-4)
        return; // misses the box, or may be called either way
    if (near > far) {
        assert_true(cut->direction_stride.w == 0);
        return;
    }
    point_in_camera(view, cut, cut->origin_near.w, from);
    point_in_camera(view, cut, cut->origin_near.w + SAMPLES * cut->direction_stride.w, to);
    assert_near(-from[2], near, 2e-6);
    assert_near(-to[2], far, 2e-6);
    *cut_count += near > -first[2] && far < -last[2];
}

TEST(samples_lie_between_near_and_far) {
    static const double distances[] = {0.1, 2, 100, 1e5};
    struct step_bench *bench = open_bench(DISTORTION_NONE);
    struct vw_view *view = &bench->scene->views[0];
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        struct vw_camera camera = {BODY};
        if (distances[i] > 1) camera.focal_x_px = camera.focal_y_px = 1000 * distances[i];
        double edge = 2 * box.half_extent_world,
               margin = fmin(0.2, 0.1 * distances[i]), // in depth, around the box's centre
            near_edges = fmax(distances[i] - margin, 0.1), far_edges = distances[i] + margin;
        uint32_t cut_count = 0;
        view->near_world = view->far_world = 0;
        const struct vw_ray *whole = rays_of(bench, &camera, distances[i]);
        view->near_world = 0.001; // a range that holds the whole box changes no bit
        view->far_world = 1e9;
        assert_memory_equal(rays_of(bench, &camera, distances[i]), whole, RAYS * sizeof *whole);
        view->near_world = near_edges * edge / 0.9; // the margins of vw_pixels_camera(): nine tenths and eleven tenths
        view->far_world = far_edges * edge / 1.1;
        const struct vw_ray *cut = rays_of(bench, &camera, distances[i]);
        for (uint32_t k = 0; k < RAYS; k++) check_depths(view, &whole[k], &cut[k], near_edges, far_edges, &cut_count);
        assert_true(cut_count > 100);
    }
}

TEST_CASES(the_cheapest_sufficient_variant_is_chosen, i, VW_ARRAY_COUNT(lenses)) {
    struct vw_view views[2] = {{.camera = lenses[0].camera}, {.camera = lenses[i].camera}};
    const struct vw_scene scene = {.views = views, .view_count = 2};
    struct vw_effect_decision decisions[VW_EFFECT_COUNT_MAX];
    struct vw_specialization specialization = {0};
    uint32_t count;
    assert_int_equal(vw_effects_find_facts(&scene, "auto", decisions, &count), VW_OK);
    vw_effects_specialise(decisions, &scene, &specialization);
    assert_int_equal(specialization.effect_distortion, lenses[i].distortion);
}

TEST_GROUP(NULL, test_gpu_close)
