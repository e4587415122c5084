// Projection through an OpenCV pinhole and its inverse. Inside this file directions are (x, y) = (X/Z, Y/Z) in the OpenCV camera frame.
#include <math.h>

#include "viewworth/scene.h"

static const int NEWTON_STEPS_MAX = 50;
static const int HALVINGS_MAX = 30;
static const double RESIDUAL_MAX = 1e-11; // in units of the focal length: 1e-7 px at 10,000 px

// The distorted position of (x, y) and its derivatives.
struct distorted {
    double x, y;
    double dx_dx, dx_dy, dy_dx, dy_dy;
};

static struct distorted distort(const struct vw_camera *camera, double x, double y) {
    double r2 = x * x + y * y;
    double radial = 1 + r2 * (camera->k1 + r2 * camera->k2);
    double d_radial = 2 * (camera->k1 + 2 * r2 * camera->k2); // d radial / dx = d_radial * x
    double p1 = camera->p1, p2 = camera->p2;
    return (struct distorted){
        .x = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
        .y = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        .dx_dx = radial + x * x * d_radial + 2 * p1 * y + 6 * p2 * x,
        .dx_dy = x * y * d_radial + 2 * p1 * x + 2 * p2 * y,
        .dy_dx = x * y * d_radial + 2 * p1 * x + 2 * p2 * y,
        .dy_dy = radial + y * y * d_radial + 6 * p1 * y + 2 * p2 * x,
    };
}

// The squared radius at which the radial distortion stops growing and the image folds over: the least positive root of
// 1 + 3 k1 r2 + 5 k2 r2^2; infinite when there is none.
static double fold_radius2(const struct vw_camera *camera) {
    double a = 5 * camera->k2, b = 3 * camera->k1;
    double discriminant = b * b - 4 * a;
    if (discriminant < 0) return INFINITY;
    double q = -0.5 * (b + copysign(sqrt(discriminant), b)); // the two roots are q / a and 1 / q, without cancellation
    double first = a != 0 ? q / a : -1, second = q != 0 ? 1 / q : -1;
    double least = INFINITY;
    if (first > 0) least = first;
    if (second > 0 && second < least) least = second;
    return least;
}

// A guess at the undistorted position, and how far its distorted position lies from the target.
struct guess {
    double x, y;
    struct distorted at;
    double error;
};

static struct guess guess_at(const struct vw_camera *camera, double x, double y, const double target[2]) {
    struct guess guess = {.x = x, .y = y, .at = distort(camera, x, y)};
    guess.error = hypot(guess.at.x - target[0], guess.at.y - target[1]);
    return guess;
}

static double determinant(const struct distorted *at) { return at->dx_dx * at->dy_dy - at->dx_dy * at->dy_dx; }

// One Newton step, halved until it comes closer without crossing the fold; false when no such step exists.
static bool improve(const struct vw_camera *camera, double fold2, const double target[2], struct guess *guess) {
    const struct distorted *at = &guess->at;
    double right_x = target[0] - at->x, right_y = target[1] - at->y;
    double step_x = (right_x * at->dy_dy - right_y * at->dx_dy) / determinant(at);
    double step_y = (right_y * at->dx_dx - right_x * at->dy_dx) / determinant(at);
    for (int halving = 0; halving < HALVINGS_MAX; halving++, step_x *= 0.5, step_y *= 0.5) {
        struct guess next = guess_at(camera, guess->x + step_x, guess->y + step_y, target);
        if (!(next.error < guess->error) || next.x * next.x + next.y * next.y >= fold2) continue;
        *guess = next;
        return true;
    }
    return false;
}

// Newton's method from the distorted position, pulled inside the fold; runs until double precision comes no closer.
static bool undistort(const struct vw_camera *camera, double *x, double *y) {
    const double target[2] = {*x, *y};
    double length = hypot(*x, *y), fold2 = fold_radius2(camera);
    double start = length > 0 ? fmin(1, 0.9 * sqrt(fold2) / length) : 1;
    struct guess guess = guess_at(camera, *x * start, *y * start, target);
    for (int step = 0; step < NEWTON_STEPS_MAX && guess.error > 0; step++)
        if (!improve(camera, fold2, target, &guess)) break;
    *x = guess.x;
    *y = guess.y;
    return guess.error <= RESIDUAL_MAX * fmax(1, length) && determinant(&guess.at) > 0;
}

bool vw_camera_unproject(const struct vw_camera *camera, double x_px, double y_px, double direction_camera[3]) {
    double x = (x_px - camera->centre_x_px) / camera->focal_x_px;
    double y = (y_px - camera->centre_y_px) / camera->focal_y_px;
    bool distorted = camera->k1 != 0 || camera->k2 != 0 || camera->p1 != 0 || camera->p2 != 0;
    if (distorted && !undistort(camera, &x, &y)) return false;
    direction_camera[0] = x;
    direction_camera[1] = -y;
    direction_camera[2] = -1;
    return true;
}

bool vw_camera_project(const struct vw_camera *camera, const double direction_camera[3], double *x_px, double *y_px) {
    if (!(direction_camera[2] < 0)) return false;
    double x = direction_camera[0] / -direction_camera[2];
    double y = -direction_camera[1] / -direction_camera[2];
    struct distorted at = distort(camera, x, y);
    *x_px = camera->focal_x_px * at.x + camera->centre_x_px;
    *y_px = camera->focal_y_px * at.y + camera->centre_y_px;
    return true;
}
