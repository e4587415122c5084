// The camera model: conventions, the two lenses and their inverses. test_colmap.c holds every lens against COLMAP's
// formulas.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "scene/builder.h"
#include "viewworth/scene.h"

static const struct vw_camera plain = {
    .width_px = 640, .height_px = 480, .focal_x_px = 500, .focal_y_px = 510, .centre_x_px = 320, .centre_y_px = 240};

static struct vw_camera distorted(double k1, double k2, double p1, double p2) {
    struct vw_camera camera = plain;
    camera.k1 = k1, camera.k2 = k2, camera.p1 = p1, camera.p2 = p2;
    return camera;
}

TEST(axes_point_right_up_and_back) {
    double direction[3], x_px, y_px;
    assert_true(vw_camera_unproject(&plain, 320, 240, direction)); // the principal point looks along -z
    assert_true(direction[0] == 0 && direction[1] == 0 && direction[2] == -1);
    assert_true(vw_camera_unproject(&plain, 820, 240, direction)); // right in the image is +x
    assert_true(direction[0] == 1 && direction[1] == 0);
    assert_true(vw_camera_unproject(&plain, 320, 240 + 510, direction)); // down in the image is -y
    assert_true(direction[0] == 0 && direction[1] == -1);
    assert_true(vw_camera_project(&plain, (const double[]){2, 4, -4}, &x_px, &y_px)); // length does not matter
    assert_true(x_px == 320 + 250 && y_px == 240 - 510);
    assert_false(vw_camera_project(&plain, (const double[]){0, 0, 1}, &x_px, &y_px));
    assert_false(vw_camera_project(&plain, (const double[]){1, 0, 0}, &x_px, &y_px));
    assert_false(vw_camera_project(&plain, (const double[]){0, 0, NAN}, &x_px, &y_px));
}

// The polynomial of scene.h, written out for one point.
TEST(distortion_is_the_documented_polynomial) {
    struct vw_camera camera = distorted(0.1, -0.2, 0.01, 0.02);
    double x = 0.3, y = 0.4, r2 = 0.25, x_px, y_px;
    double radial = 1 + 0.1 * r2 - 0.2 * r2 * r2;
    double x_distorted = x * radial + 2 * 0.01 * x * y + 0.02 * (r2 + 2 * x * x);
    double y_distorted = y * radial + 0.01 * (r2 + 2 * y * y) + 2 * 0.02 * x * y;
    assert_true(vw_camera_project(&camera, (const double[]){x, -y, -1}, &x_px, &y_px));
    assert_near(x_px, 500 * x_distorted + 320, 1e-9);
    assert_near(y_px, 510 * y_distorted + 240, 1e-9);
}

// Checks that every pixel coordinate at which a direction inside the fold is seen leads back to that direction.
static void check_round_trip(const struct vw_camera *camera) {
    int seen = 0;
    for (int row = -12; row <= 12; row++) {
        for (int column = -12; column <= 12; column++) {
            const double direction[3] = {column * 0.05, row * 0.05, -1};
            double r2 = direction[0] * direction[0] + direction[1] * direction[1];
            if (1 + 3 * camera->k1 * r2 + 5 * camera->k2 * r2 * r2 < 0.15) continue; // beyond or close to the fold
            double x_px, y_px, back_x_px, back_y_px, back[3];
            assert_true(vw_camera_project(camera, direction, &x_px, &y_px));
            if (!vw_camera_unproject(camera, x_px, y_px, back))
                fail_msg("no inverse at (%g, %g) px for k1 %g k2 %g p1 %g p2 %g", x_px, y_px, camera->k1, camera->k2,
                         camera->p1, camera->p2);
            assert_near(back[0], direction[0], 1e-7);
            assert_near(back[1], direction[1], 1e-7);
            assert_true(vw_camera_project(camera, back, &back_x_px, &back_y_px));
            assert_true(hypot(back_x_px - x_px, back_y_px - y_px) < 1e-6); // the contract asks 0.01 px
            seen++;
        }
    }
    assert_true(seen > 50);
}

TEST(distorted_points_round_trip) {
    static const double radial[] = {-0.55, -0.3, -0.1, 0, 0.1, 0.4, 1};
    static const double higher[] = {-0.3, -0.08, 0, 0.1, 0.5};
    static const double tangential[] = {-0.02, 0, 0.02};
    for (size_t a = 0; a < VW_ARRAY_COUNT(radial); a++)
        for (size_t b = 0; b < VW_ARRAY_COUNT(higher); b++)
            for (size_t c = 0; c < VW_ARRAY_COUNT(tangential); c++)
                for (size_t d = 0; d < VW_ARRAY_COUNT(tangential); d++) {
                    struct vw_camera camera = distorted(radial[a], higher[b], tangential[c], tangential[d]);
                    check_round_trip(&camera);
                }
}

TEST(pixels_beyond_the_fold_have_no_inverse) {
    struct vw_camera camera = distorted(-0.5, 0, 0, 0); // r (1 - r2 / 2) never exceeds 0.5443
    double direction[3];
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 0.54, 240, direction));
    assert_near(direction[0] * (1 - 0.5 * direction[0] * direction[0]), 0.54, 1e-9);
    assert_true(direction[0] < sqrt(2.0 / 3)); // the root inside the fold, not the one beyond
    assert_false(vw_camera_unproject(&camera, 320 + 500 * 0.55, 240, direction));
    camera = distorted(-1, 0.4, 0, 0); // rises to 0.4243, falls, and rises again: 1 is reached only beyond the fold
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 0.42, 240, direction));
    assert_false(vw_camera_unproject(&camera, 320 + 500 * 1.0, 240, direction));
}

// ---- The rational polynomial and the fisheye ------------------------------------------------------------------------

static void check_there_and_back(const struct vw_camera *camera, const double direction[3]) {
    double x_px, y_px, back[3];
    assert_true(vw_camera_project(camera, direction, &x_px, &y_px));
    if (!vw_camera_unproject(camera, x_px, y_px, back))
        fail_msg("no inverse at (%g, %g) px for k1 %g", x_px, y_px, camera->k1);
    double size = hypot(1, hypot(direction[0], direction[1])); // an error in the angle grows with its square
    assert_near(back[0], direction[0], 1e-9 * size * size);
    assert_near(back[1], direction[1], 1e-9 * size * size);
}

TEST(rational_lenses_round_trip) {
    static const double lenses[][6] = {// k1 to k6: rising all the way to 45 degrees
                                       {0.1, 0.2, 0.3, 0, 0, 0},
                                       {-0.2, 0.1, -0.02, 0, 0, 0},
                                       {12.5, 20.1, 1.9, 12.8, 24.3, 7.1},
                                       {0, 0, 0, 0.3, 0, 0},
                                       {0.5, 0.1, 0, 0.7, 0.2, 0.05}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        struct vw_camera camera = plain;
        const double *k = lenses[i];
        camera.k1 = k[0], camera.k2 = k[1], camera.k3 = k[2], camera.k4 = k[3], camera.k5 = k[4], camera.k6 = k[5];
        for (int tangential = 0; tangential < 2; tangential++, camera.p1 = 0.003, camera.p2 = -0.002)
            for (int row = -7; row <= 7; row++)
                for (int column = -7; column <= 7; column++)
                    check_there_and_back(&camera, (const double[]){column * 0.1, row * 0.1, -1});
    }
}

// The image folds over where the radius r N / D stops growing or D vanishes.
TEST(rational_lenses_fold_where_the_radius_stops_growing) {
    struct vw_camera camera = plain;
    double direction[3];
    camera.k3 = -1; // r - r^7: grows to r = 7^(-1/6) = 0.7230, where it is 0.6197
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 0.6196, 240, direction));
    assert_true(direction[0] < 0.7231);
    assert_false(vw_camera_unproject(&camera, 320 + 500 * 0.6198, 240, direction));
    camera = plain;
    camera.k4 = 1; // r / (1 + r^2): grows to 1/2 at r = 1
    assert_true(vw_camera_unproject(&camera, 320, 240 + 510 * 0.49, direction));
    assert_near(-direction[1] / (1 + direction[1] * direction[1]), 0.49, 1e-11);
    assert_true(-direction[1] < 1);
    assert_false(vw_camera_unproject(&camera, 320, 240 + 510 * 0.51, direction));
    camera.k4 = -0.25; // r / (1 - r^2 / 4): every radius is reached before the pole at r = 2
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 1000.0, 240, direction));
    assert_true(direction[0] < 2 && direction[0] > 1.99);
}

TEST(fisheye_lenses_map_angles) {
    struct vw_camera camera = plain;
    camera.lens = VW_LENS_FISHEYE;
    double x_px, y_px, direction[3];
    assert_true(
        vw_camera_project(&camera, (const double[]){1, 0, -1}, &x_px, &y_px)); // without coefficients: the angle itself
    assert_near(x_px, 320 + 500 * M_PI / 4, 1e-10);
    assert_near(y_px, 240, 1e-10);
    assert_true(vw_camera_unproject(&camera, 320, 240, direction));
    assert_true(direction[0] == 0 && direction[1] == 0 && direction[2] == -1);
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 1.549, 240, direction));
    assert_false(vw_camera_unproject(&camera, 320 + 500 * 1.551, 240, direction)); // close to a right angle
    static const double lenses[][4] = {{0, 0, 0, 0},
                                       {-0.03, 0.02, -0.005, 0.001},
                                       {0.2, 0.1, 0.05, 0.02},
                                       {-0.1, -0.02, 0, 0},
                                       {0.05, -0.2, 0.15, -0.03}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(lenses); i++) {
        camera.k1 = lenses[i][0], camera.k2 = lenses[i][1], camera.k3 = lenses[i][2], camera.k4 = lenses[i][3];
        for (int degree = 1; degree < 75; degree++)
            for (int turn = 0; turn < 7; turn++)
                check_there_and_back(&camera, (const double[]){tan(degree * M_PI / 180) * cos(turn),
                                                               tan(degree * M_PI / 180) * sin(turn), -1});
    }
    camera = plain;
    camera.lens = VW_LENS_FISHEYE;
    camera.k1 = -0.3; // theta - 0.3 theta^3 grows to 1.0541, where it is 0.7027
    assert_true(vw_camera_unproject(&camera, 320 + 500 * 0.7, 240, direction));
    assert_true(atan(direction[0]) < 1.0541);
    assert_false(vw_camera_unproject(&camera, 320 + 500 * 0.704, 240, direction));
}

// The reach is the radius from which the lens has no inverse.
TEST(the_reach_ends_where_the_inverse_does) {
    struct vw_camera cameras[] = {distorted(-0.5, 0, 0, 0), distorted(-1, 0.4, 0, 0), plain, plain, plain};
    cameras[2].k4 = 1;
    cameras[3].lens = cameras[4].lens = VW_LENS_FISHEYE;
    cameras[4].k1 = -0.3;
    assert_true(isinf(vw_camera_reach(&plain)));
    for (size_t i = 0; i < VW_ARRAY_COUNT(cameras); i++) {
        double reach = vw_camera_reach(&cameras[i]), direction[3];
        assert_true(vw_camera_unproject(&cameras[i], 320, 240 + 510 * (reach - 1e-6), direction));
        assert_false(vw_camera_unproject(&cameras[i], 320, 240 + 510 * (reach + 1e-6), direction));
    }
}

// A fisheye whose circle of sight is narrower than the photo: its corners are hidden, on top of what the mask hides
// already.
TEST(pixels_without_a_ray_are_masked) {
    struct vw_view view = {
        .camera = {
            .width_px = 40, .height_px = 20, .focal_x_px = 10, .focal_y_px = 10, .centre_x_px = 20, .centre_y_px = 10}};
    uint64_t hidden = 0;
    ASSERT_OK(vw_lens_mask(&view, &hidden));
    assert_true(hidden == 0 && !view.mask); // a pinhole sees everywhere
    view.camera.lens = VW_LENS_FISHEYE;
    ASSERT_OK(vw_lens_mask(&view, &hidden));
    assert_non_null(view.mask);
    uint64_t counted = 0;
    for (uint32_t i = 0; i < 800; i++) {
        double direction[3];
        bool seen = vw_camera_unproject(&view.camera, i % 40 + 0.5, i / 40 + 0.5, direction);
        assert_int_equal(view.mask[i], seen ? VW_MASK_KEEP : VW_MASK_BEYOND_LENS);
        counted += !seen;
    }
    assert_true(hidden == counted && counted > 50 && counted < 400);
    view.mask[10 * 40 + 20] = 0;
    ASSERT_OK(vw_lens_mask(&view, &hidden));
    assert_int_equal(view.mask[10 * 40 + 20], 0);
    free(view.mask);
}

TEST(only_other_lenses_and_coefficients_distort) {
    assert_false(vw_camera_is_distorted(&plain));
    struct vw_camera fisheye = plain, last = plain;
    fisheye.lens = VW_LENS_FISHEYE;
    last.k6 = 1e-9;
    assert_true(vw_camera_is_distorted(&fisheye) && vw_camera_is_distorted(&last));
}
