// The camera model: conventions, the distortion polynomial and its inverse.
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "support/assert_near.h"
#include "viewworth/memory.h"
#include "viewworth/scene.h"

static const struct vw_camera plain = {
    .width_px = 640, .height_px = 480, .focal_x_px = 500, .focal_y_px = 510, .centre_x_px = 320, .centre_y_px = 240};

static struct vw_camera distorted(double k1, double k2, double p1, double p2) {
    struct vw_camera camera = plain;
    camera.k1 = k1, camera.k2 = k2, camera.p1 = p1, camera.p2 = p2;
    return camera;
}

static void test_axes(void **state) {
    (void)state;
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
static void test_distortion(void **state) {
    (void)state;
    struct vw_camera camera = distorted(0.1, -0.2, 0.01, 0.02);
    double x = 0.3, y = 0.4, r2 = 0.25, x_px, y_px;
    double radial = 1 + 0.1 * r2 - 0.2 * r2 * r2;
    double x_distorted = x * radial + 2 * 0.01 * x * y + 0.02 * (r2 + 2 * x * x);
    double y_distorted = y * radial + 0.01 * (r2 + 2 * y * y) + 2 * 0.02 * x * y;
    assert_true(vw_camera_project(&camera, (const double[]){x, -y, -1}, &x_px, &y_px));
    assert_near(x_px, 500 * x_distorted + 320, 1e-9);
    assert_near(y_px, 510 * y_distorted + 240, 1e-9);
}

// Every point of a photo that some direction inside the fold is seen at must come back to that direction.
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
                fail_msg("no inverse at (%g, %g) px for k1 %g k2 %g p1 %g p2 %g", x_px, y_px, camera->k1, camera->k2, camera->p1,
                         camera->p2);
            assert_near(back[0], direction[0], 1e-7);
            assert_near(back[1], direction[1], 1e-7);
            assert_true(vw_camera_project(camera, back, &back_x_px, &back_y_px));
            assert_true(hypot(back_x_px - x_px, back_y_px - y_px) < 1e-6); // the contract asks 0.01 px
            seen++;
        }
    }
    assert_true(seen > 50);
}

static void test_round_trip(void **state) {
    (void)state;
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

static void test_no_inverse(void **state) {
    (void)state;
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_axes),
        cmocka_unit_test(test_distortion),
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_no_inverse),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
