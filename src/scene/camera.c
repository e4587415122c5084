// Projection by the two lens models of scene.h, and its inverse; rotations. In this file, positions are (x, y) = (X/Z,
// Y/Z) in the OpenCV camera frame, and distorted positions are in units of the focal lengths.
#include <math.h>

#include "scene/builder.h"
#include "viewworth/scene.h"

static const int NEWTON_STEPS_MAX = 50;
static const int HALVINGS_MAX = 30;
static const double RESIDUAL_MAX = 1e-11; // in units of the focal length: 1e-7 px at 10,000 px
static const double RADIUS2_MAX = 1e4;    // the square of the tangent of 89.4 degrees: no pinhole sees further out
static const double FISHEYE_ANGLE_MAX =
    1.55; // radians; camera.glsl has the same: directions (x, y, -1) end at a right angle
enum { BISECTIONS_MAX = 100, DEGREE_MAX = 6 };

// ---- The fold: where the distorted radius stops growing with the true one, beyond which there is no inverse ----

static double polynomial(const double *coefficients, int degree, double x) {
    double value = coefficients[degree];
    while (degree-- > 0) value = value * x + coefficients[degree];
    return value;
}

static double bisect(const double *coefficients, int degree, double left, double right) {
    bool sign = polynomial(coefficients, degree, left) > 0;
    for (int i = 0; i < BISECTIONS_MAX; i++) {
        double middle = 0.5 * (left + right);
        if ((polynomial(coefficients, degree, middle) > 0) == sign) left = middle;
        else right = middle;
    }
    return left;
}

// Finds where a polynomial changes its sign in (0, limit), ascending: between two roots of its derivative it does so at
// most once.
static int find_roots(const double *coefficients, int degree, double limit, double roots[DEGREE_MAX]) {
    if (degree == 0) return 0;
    double derivative[DEGREE_MAX] = {0}, turns[DEGREE_MAX + 1], left = 0;
    for (int i = 0; i < degree; i++) derivative[i] = (i + 1) * coefficients[i + 1];
    int turn_count = find_roots(derivative, degree - 1, limit, turns), count = 0;
    turns[turn_count++] = limit;
    for (int i = 0; i < turn_count; left = turns[i++])
        if ((polynomial(coefficients, degree, left) > 0) != (polynomial(coefficients, degree, turns[i]) > 0))
            roots[count++] = bisect(coefficients, degree, left, turns[i]);
    return count;
}

// Returns the least root in (0, limit); `fallback` if there is none.
static double least_root(const double *coefficients, int degree, double limit, double fallback) {
    double roots[DEGREE_MAX];
    while (degree > 0 && coefficients[degree] == 0) degree--;
    return find_roots(coefficients, degree, limit, roots) ? roots[0] : fallback;
}

// Returns the squared radius where the slope of the distorted radius first vanishes or its denominator does; infinite
// when neither happens. With N and D, numerator and denominator of the radial factor, as polynomials in s = r2, the
// slope of the distorted radius r N / D is (N D + 2 s (N' D - N D')) / D^2.
static double fold_radius2(const struct vw_camera *camera) {
    const double top[4] = {1, camera->k1, camera->k2, camera->k3}, bottom[4] = {1, camera->k4, camera->k5, camera->k6};
    double slope[DEGREE_MAX + 1] = {0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) slope[i + j] += (1 + 2 * (i - j)) * top[i] * bottom[j];
    return fmin(least_root(slope, DEGREE_MAX, RADIUS2_MAX, INFINITY), least_root(bottom, 3, RADIUS2_MAX, INFINITY));
}

// ---- The polynomial lens ----

// The distorted position of (x, y) and its derivatives.
struct distorted {
    double x, y;
    double dx_dx, dx_dy, dy_dx, dy_dy;
};

static struct distorted distort(const struct vw_camera *camera, double x, double y) {
    double r2 = x * x + y * y;
    double bottom = 1 + r2 * (camera->k4 + r2 * (camera->k5 + r2 * camera->k6));
    double radial = (1 + r2 * (camera->k1 + r2 * (camera->k2 + r2 * camera->k3))) / bottom;
    double d_top = camera->k1 + r2 * (2 * camera->k2 + r2 * 3 * camera->k3);
    double d_bottom = camera->k4 + r2 * (2 * camera->k5 + r2 * 3 * camera->k6);
    double d_radial = 2 * (d_top - radial * d_bottom) / bottom; // d radial / dx = d_radial * x
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

// An estimate of the undistorted position, and the distance of its distorted position from the target.
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

// Takes one Newton step, halved until it reduces the distance without crossing the fold; false if there is no such
// step.
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

// Iterates Newton's method, started at the distorted position moved inside the fold, until the distance no longer
// falls.
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

// ---- The fisheye lens: a matter of angles alone ----

static double distort_angle(const struct vw_camera *camera, double theta, double *slope) {
    double t2 = theta * theta;
    *slope = 1 + t2 * (3 * camera->k1 + t2 * (5 * camera->k2 + t2 * (7 * camera->k3 + t2 * 9 * camera->k4)));
    return theta * (1 + t2 * (camera->k1 + t2 * (camera->k2 + t2 * (camera->k3 + t2 * camera->k4))));
}

// Returns the angle up to which the distorted angle increases with the true one.
static double fold_angle(const struct vw_camera *camera) {
    const double slopes[5] = {1, 3 * camera->k1, 5 * camera->k2, 7 * camera->k3,
                              9 * camera->k4}; // coefficients in the square of the angle
    const double limit = FISHEYE_ANGLE_MAX * FISHEYE_ANGLE_MAX;
    return sqrt(least_root(slopes, 4, limit, limit));
}

// Finds the true angle of a distorted angle by Newton's method within shrinking bounds. Below the fold there is at most
// one solution.
static bool undistort_angle(const struct vw_camera *camera, double target, double *theta) {
    double low = 0, high = fold_angle(camera), slope;
    if (!(target < distort_angle(camera, high, &slope))) return false;
    double guess = fmin(target, 0.5 * high);
    for (int step = 0; step < BISECTIONS_MAX; step++) {
        double error = distort_angle(camera, guess, &slope) - target, next = guess - error / slope;
        if (next == guess) break; // double precision is reached
        if (error > 0) high = guess;
        else low = guess;
        guess = next > low && next < high ? next : 0.5 * (low + high);
    }
    *theta = guess;
    return fabs(distort_angle(camera, guess, &slope) - target) <= RESIDUAL_MAX;
}

static bool undistort_fisheye(const struct vw_camera *camera, double *x, double *y) {
    double length = hypot(*x, *y), theta;
    if (length == 0) return true;
    if (!undistort_angle(camera, length, &theta)) return false;
    double segment = tan(theta) / length;
    *x *= segment;
    *y *= segment;
    return true;
}

static void distort_fisheye(const struct vw_camera *camera, double *x, double *y) {
    double radius = hypot(*x, *y), slope;
    double shrink = radius > 0 ? distort_angle(camera, atan(radius), &slope) / radius : 1;
    *x *= shrink;
    *y *= shrink;
}

// ---- Both ----

bool vw_camera_same(const struct vw_camera *a, const struct vw_camera *b) {
    return a->width_px == b->width_px && a->height_px == b->height_px && a->focal_x_px == b->focal_x_px &&
           a->focal_y_px == b->focal_y_px && a->centre_x_px == b->centre_x_px && a->centre_y_px == b->centre_y_px &&
           a->lens == b->lens && a->k1 == b->k1 && a->k2 == b->k2 && a->k3 == b->k3 && a->k4 == b->k4 &&
           a->k5 == b->k5 && a->k6 == b->k6 && a->p1 == b->p1 && a->p2 == b->p2;
}

bool vw_camera_is_distorted(const struct vw_camera *camera) {
    return camera->lens == VW_LENS_FISHEYE || camera->k1 != 0 || camera->k2 != 0 || camera->k3 != 0 ||
           camera->k4 != 0 || camera->k5 != 0 || camera->k6 != 0 || camera->p1 != 0 || camera->p2 != 0;
}

double vw_camera_fold(const struct vw_camera *camera) {
    return camera->lens == VW_LENS_FISHEYE ? tan(fold_angle(camera)) : sqrt(fold_radius2(camera));
}

double vw_camera_reach(const struct vw_camera *camera) {
    double slope;
    if (camera->lens == VW_LENS_FISHEYE) return distort_angle(camera, fold_angle(camera), &slope);
    double radius = vw_camera_fold(camera);
    if (isinf(radius)) return INFINITY;
    const struct vw_camera radial = {
        .k1 = camera->k1, .k2 = camera->k2, .k3 = camera->k3, .k4 = camera->k4, .k5 = camera->k5, .k6 = camera->k6};
    return distort(&radial, radius, 0).x;
}

bool vw_camera_unproject(const struct vw_camera *camera, double x_px, double y_px, double direction_camera[3]) {
    double x = (x_px - camera->centre_x_px) / camera->focal_x_px;
    double y = (y_px - camera->centre_y_px) / camera->focal_y_px;
    bool fisheye = camera->lens == VW_LENS_FISHEYE;
    if (vw_camera_is_distorted(camera) && !(fisheye ? undistort_fisheye(camera, &x, &y) : undistort(camera, &x, &y)))
        return false;
    direction_camera[0] = x;
    direction_camera[1] = -y;
    direction_camera[2] = -1;
    return true;
}

bool vw_camera_project(const struct vw_camera *camera, const double direction_camera[3], double *x_px, double *y_px) {
    if (!(direction_camera[2] < 0)) return false;
    double x = direction_camera[0] / -direction_camera[2];
    double y = -direction_camera[1] / -direction_camera[2];
    if (camera->lens == VW_LENS_FISHEYE) {
        distort_fisheye(camera, &x, &y);
    } else {
        struct distorted at = distort(camera, x, y);
        x = at.x;
        y = at.y;
    }
    *x_px = camera->focal_x_px * x + camera->centre_x_px;
    *y_px = camera->focal_y_px * y + camera->centre_y_px;
    return true;
}

void vw_camera_resize(uint32_t width_px, uint32_t height_px, struct vw_camera *camera) {
    double scale_x = (double)width_px / camera->width_px, scale_y = (double)height_px / camera->height_px;
    camera->focal_x_px *= scale_x;
    camera->centre_x_px *= scale_x;
    camera->focal_y_px *= scale_y;
    camera->centre_y_px *= scale_y;
    camera->width_px = width_px;
    camera->height_px = height_px;
}

enum vw_status vw_camera_check(const char *where, const char *fields, const struct vw_camera *camera) {
    if (fmin(camera->focal_x_px, camera->focal_y_px) >= VW_FOCAL_LEAST_PX &&
        fmax(camera->focal_x_px, camera->focal_y_px) <= VW_FOCAL_MOST_PX)
        return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: %s make focal lengths of %g and %g pixels in the photo; they must be from %g to %g; correct "
                   "them",
                   where, fields, camera->focal_x_px, camera->focal_y_px, VW_FOCAL_LEAST_PX, VW_FOCAL_MOST_PX);
}

enum vw_status vw_camera_fit(const char *where, uint32_t width_px, uint32_t height_px, struct vw_camera *camera,
                             bool *rescaled) {
    if ((uint64_t)camera->width_px * height_px != (uint64_t)camera->height_px * width_px)
        return vw_fail(
            VW_ERROR_INPUT,
            "%s: the camera is for %u x %u pixels but the photo has %u x %u; give photos of the camera's shape", where,
            camera->width_px, camera->height_px, width_px, height_px);
    if (camera->width_px == width_px) return VW_OK;
    vw_camera_resize(width_px, height_px, camera);
    *rescaled = true;
    return vw_camera_check(where, "the fields of its camera", camera);
}

// ---- Rotations ----

double vw_determinant(const double *x, const double *y, const double *z) {
    return x[0] * (y[1] * z[2] - y[2] * z[1]) - x[1] * (y[0] * z[2] - y[2] * z[0]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
}

// Takes the quaternion from the greatest of its four numbers, which loses no digits (Shepperd).
void vw_pose_quaternion(const double pose[3][4], double quaternion[4]) {
    double squares[4] = {1 + pose[0][0] + pose[1][1] + pose[2][2]}; // four times those of the numbers
    int greatest = 0;
    for (int i = 0; i < 3; i++) squares[i + 1] = 2 + 2 * pose[i][i] - squares[0];
    for (int i = 1; i < 4; i++)
        if (squares[i] > squares[greatest]) greatest = i;
    double products[4][4] = {{0}}; // four times the products of two numbers
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        products[0][i + 1] = products[i + 1][0] = pose[k][j] - pose[j][k];
        products[j + 1][k + 1] = products[k + 1][j + 1] = pose[k][j] + pose[j][k];
    }
    for (int i = 0; i < 4; i++) products[i][i] = squares[i];
    for (int i = 0; i < 4; i++) quaternion[i] = products[greatest][i] / (2 * sqrt(squares[greatest]));
}
