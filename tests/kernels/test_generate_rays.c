// generate_rays where cameras are in odd places: near and far, in the box, beside it, in worlds of any size; rays along
// axes and in faces; lenses that bend much.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

static const double LINE_TOLERANCE = 1e-6;  // box edges, as in check_rays.c
static const double REPROJECTION_PX = 0.01; // tolerance of generate_rays

static const struct step_case plain = {
    .name = "pinhole", .seed = 121, .levels = 2, .log2_table = 4, .width = 16, .rays = 300};
static const struct step_case bent = {.name = "distortion and background",
                                      .seed = 122,
                                      .levels = 2,
                                      .log2_table = 4,
                                      .width = 16,
                                      .rays = 300,
                                      .effects = "distortion,background"};

// In box coordinates; all look at `target` through a wide lens so that some rays miss.
TEST(cameras_in_and_around_the_box) {
    static const struct {
        double position[3], target[3];
        bool hits;
    } cameras[] = {
        {{0.5, 0.5, 0.5}, {1.0, 0.6, 0.4}, true},    {{0.01, 0.01, 0.01}, {1.0, 1.0, 1.0}, true},
        {{0.5, 0.5, 3.9}, {0.5, 0.5, 0.5}, true},    {{4.6, 0.5, 0.5}, {0.5, 0.5, 0.5}, true},
        {{-3.0, -3.0, -3.0}, {0.5, 0.5, 0.5}, true}, {{2.0, 0.5, 0.5}, {3.0, 0.5, 0.5}, false},
        {{0.999, 0.5, 0.5}, {2.0, 0.5, 0.5}, false}, {{30.0, 20.0, 10.0}, {60.0, 40.0, 20.0}, false},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        struct step_bench *bench = step_bench_open(&plain);
        struct vw_view *view = &bench->scene->views[0];
        view->camera.focal_x_px = view->camera.focal_y_px = 10.0;
        rays_look(view, &bench->scene->box, cameras[i].position, cameras[i].target);
        for (uint32_t k = 0; k < bench->config.rays; k++) bench->pixels[k].view = 0;
        uint32_t hits = rays_check(bench, 2.0);
        if ((hits > 0) != cameras[i].hits) fail_msg("camera %zu: %u rays hit", i, hits);
        test_release(bench);
    }
}

// The centre pixel looks exactly along an axis: two components of the direction are 0.
TEST(rays_along_axes_and_in_faces_are_finite) {
    static const double offsets[] = {0.5, 0.0, 1.0, -0.25, 1.25, 0.3};
    for (int axis = 0; axis < 6; axis++) {
        for (size_t i = 0; i < VW_ARRAY_COUNT(offsets); i++) {
            struct step_bench *bench = step_bench_open(&plain);
            struct vw_view *view = &bench->scene->views[0];
            double position[3] = {0.5, 0.5, 0.5}, target[3] = {0.5, 0.5, 0.5};
            position[axis % 3] = axis < 3 ? 2.0 : -2.0;
            position[(axis + 1) % 3] = target[(axis + 1) % 3] = offsets[i];
            rays_look(view, &bench->scene->box, position, target);
            for (uint32_t k = 0; k < bench->config.rays; k++)
                bench->pixels[k] = (struct vw_pixel){
                    .x_px = (float)view->camera.centre_x_px, .y_px = (float)view->camera.centre_y_px, .weight = 1.0f};
            struct vw_ray *rays = rays_make(bench);
            struct reference_ray ray = reference_ray_of(&rays[0]);
            assert_true(isfinite(ray.near) && isfinite(ray.stride) && ray.stride >= 0.0);
            if (offsets[i] == 0.5 || offsets[i] == 0.3)
                check_value(bench->where, "length within the box", 0, ray.stride * bench->config.samples, 1.0, 2e-6);
            if (offsets[i] < 0.0 || offsets[i] > 1.0) assert_true(ray.stride == 0.0);
            test_release(bench);
        }
    }
}

// A camera 10^3 to 10^6 box edges away, with a lens as long: its rays hit the box where double says.
TEST(far_cameras_lose_no_bits) {
    static const double distances[] = {10.0, 1e3, 1e6};
    for (size_t i = 0; i < VW_ARRAY_COUNT(distances); i++) {
        struct step_bench *bench = step_bench_open(&plain);
        struct vw_view *view = &bench->scene->views[0];
        const double direction[3] = {0.6, -0.48, 0.64}, target[3] = {0.5, 0.5, 0.5};
        double position[3];
        for (int k = 0; k < 3; k++) position[k] = 0.5 + distances[i] * direction[k];
        rays_look(view, &bench->scene->box, position, target);
        view->camera.focal_x_px = view->camera.focal_y_px = 12.0 * distances[i]; // the box fills the photo
        for (uint32_t k = 0; k < bench->config.rays; k++) bench->pixels[k].view = 0;
        assert_true(rays_check(bench, 1.0) > 100);
        test_release(bench);
    }
}

// World coordinates of 10^6 metres, and boxes of a millimetre and of a kilometre: the field sees the same rays.
TEST(the_world_may_be_anywhere_and_of_any_size) {
    static const double scales[] = {1.0, 1e-3, 1e3};
    struct step_bench *bench = step_bench_open(&plain);
    for (size_t i = 0; i < VW_ARRAY_COUNT(scales); i++) {
        struct vw_scene *moved = synthetic_scene(&(struct synthetic_scene_params){.train_views = 2,
                                                                                  .val_views = 1,
                                                                                  .width_px = 24,
                                                                                  .height_px = 20,
                                                                                  .world_offset = 1e6,
                                                                                  .world_scale = scales[i]});
        struct vw_scene *kept = bench->scene;
        bench->scene = moved;
        // The double position itself is only good to 1e6 * 2^-53 metres.
        uint32_t hits = rays_check(bench, 1.0 + 1e6 * 0x1p-53 / scales[i] / LINE_TOLERANCE);
        bench->scene = kept;
        assert_true(hits > 100);
    }
}

// Distortion undone: the direction projects back to the pixel, over the whole photo and for strong lenses.
TEST(undistorted_rays_reproject_to_their_pixel) {
    static const double lenses[][4] = {{-0.15, 0.0, 0.0, 0.0}, {-0.3, 0.12, 0.002, -0.003}, {0.25, -0.08, -0.01, 0.008},
                                       {0.0, 0.0, 0.02, 0.02}, {-0.05, 0.01, 0.0, 0.0},     {0.5, -0.1, 0.0, 0.0},
                                       {2.0, 2.0, 0.0, 0.0},   {8.0, 20.0, 0.0, 0.0}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        struct step_bench *bench = step_bench_open(&bent);
        struct vw_view *view = &bench->scene->views[0];
        view->camera = (struct vw_camera){.width_px = 1920,
                                          .height_px = 1080,
                                          .focal_x_px = 1400.0,
                                          .focal_y_px = 1420.0,
                                          .centre_x_px = 951.5,
                                          .centre_y_px = 548.25,
                                          .k1 = lenses[i][0],
                                          .k2 = lenses[i][1],
                                          .p1 = lenses[i][2],
                                          .p2 = lenses[i][3]};
        for (uint32_t k = 0; k < bench->config.rays; k++) {
            bench->pixels[k].view = 0;
            bench->pixels[k].x_px = (float)(k % 20 * 101 + (k % 20 < 19 ? 0.5 : 0.0));
            bench->pixels[k].y_px = (float)(k / 20 * 77 + 0.5);
        }
        struct vw_ray *rays = rays_make(bench);
        for (uint32_t k = 0; k < bench->config.rays; k++) {
            struct reference_ray ray = reference_ray_of(&rays[k]);
            double in_camera[3] = {0}, x_px, y_px;
            for (int column = 0; column < 3; column++)
                for (int row = 0; row < 3; row++)
                    in_camera[column] += view->camera_to_world[row][column] * ray.direction[row];
            assert_true(vw_camera_project(&view->camera, in_camera, &x_px, &y_px));
            check_value(bench->where, "reprojected x_px", k, x_px, bench->pixels[k].x_px, REPROJECTION_PX);
            check_value(bench->where, "reprojected y_px", k, y_px, bench->pixels[k].y_px, REPROJECTION_PX);
        }
        test_release(bench);
    }
}

TEST_GROUP(NULL, test_gpu_close)
