#include "reference/splats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double LOW_PASS = 0.1; // px^2, as Yu et al. have it
static const double ALPHA_MOST = (double)0.99f, ALPHA_LEAST = 1.0 / 255.0, LEFT_LEAST = 1e-4, NEAR = (double)0.02f;

struct reference_splat_view reference_splat_view_of(const struct vw_gpu_camera *camera,
                                                    const struct vw_splat_view *view,
                                                    const struct vw_splat_specialization *s, uint32_t degree) {
    return (struct reference_splat_view){
        .axes = {{camera->right.x, camera->right.y, camera->right.z},
                 {-camera->up.x, -camera->up.y, -camera->up.z},
                 {-camera->back.x, -camera->back.y, -camera->back.z}},
        .eye = {camera->reference.x + (double)camera->reference.w * camera->back.x,
                camera->reference.y + (double)camera->reference.w * camera->back.y,
                camera->reference.z + (double)camera->reference.w * camera->back.z},
        .focal = {camera->right.w, camera->up.w},
        .middle = {camera->back.w, camera->more.x},
        .slopes = {{view->slopes.x, view->slopes.y}, {view->slopes.z, view->slopes.w}},
        .reach = view->reach,
        .distorts = s->run.effect_distortion != DISTORTION_NONE,
        .fisheye = camera->more.w != 0.0f,
        .k = {camera->distortion.x, camera->distortion.y, camera->higher.x, camera->higher.y, camera->higher.z,
              camera->higher.w},
        .p = {camera->distortion.z, camera->distortion.w},
        .degree = degree,
    };
}

static void covariance_of(const double *splat, double covariance[3][3]) {
    double q[4], norm = 0.0, m[3][3];
    for (int i = 0; i < 4; i++) norm += splat[8 + i] * splat[8 + i];
    for (int i = 0; i < 4; i++) q[i] = splat[8 + i] / sqrt(norm);
    for (int axis = 0; axis < 3; axis++) { // column: v + 2 w (u x v) + 2 u x (u x v), by the quaternion (w, u)
        double v[3] = {axis == 0, axis == 1, axis == 2}, once[3], twice[3];
        for (int i = 0; i < 3; i++) once[i] = q[1 + (i + 1) % 3] * v[(i + 2) % 3] - q[1 + (i + 2) % 3] * v[(i + 1) % 3];
        for (int i = 0; i < 3; i++)
            twice[i] = q[1 + (i + 1) % 3] * once[(i + 2) % 3] - q[1 + (i + 2) % 3] * once[(i + 1) % 3];
        for (int i = 0; i < 3; i++)
            m[i][axis] = (v[i] + 2.0 * q[0] * once[i] + 2.0 * twice[i]) * sqrt(exp(2.0 * splat[4 + axis]) + splat[7]);
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) covariance[i][j] = m[i][0] * m[j][0] + m[i][1] * m[j][1] + m[i][2] * m[j][2];
}

static double harmonic(uint32_t k, const double d[3]) {
    double x = d[0], y = d[1], z = d[2];
    const double values[] = {
        1.0 / 2.0 * sqrt(1.0 / M_PI),
        -sqrt(3.0 / (4.0 * M_PI)) * y,
        sqrt(3.0 / (4.0 * M_PI)) * z,
        -sqrt(3.0 / (4.0 * M_PI)) * x,
        1.0 / 2.0 * sqrt(15.0 / M_PI) * x * y,
        -1.0 / 2.0 * sqrt(15.0 / M_PI) * y * z,
        1.0 / 4.0 * sqrt(5.0 / M_PI) * (2.0 * z * z - x * x - y * y),
        -1.0 / 2.0 * sqrt(15.0 / M_PI) * x * z,
        1.0 / 4.0 * sqrt(15.0 / M_PI) * (x * x - y * y),
        -1.0 / 4.0 * sqrt(35.0 / (2.0 * M_PI)) * y * (3.0 * x * x - y * y),
        1.0 / 2.0 * sqrt(105.0 / M_PI) * x * y * z,
        -1.0 / 4.0 * sqrt(21.0 / (2.0 * M_PI)) * y * (4.0 * z * z - x * x - y * y),
        1.0 / 4.0 * sqrt(7.0 / M_PI) * z * (2.0 * z * z - 3.0 * x * x - 3.0 * y * y),
        -1.0 / 4.0 * sqrt(21.0 / (2.0 * M_PI)) * x * (4.0 * z * z - x * x - y * y),
        1.0 / 4.0 * sqrt(105.0 / M_PI) * z * (x * x - y * y),
        -1.0 / 4.0 * sqrt(35.0 / (2.0 * M_PI)) * x * (x * x - 3.0 * y * y),
    };
    return values[k];
}

static void colour_of(const struct reference_splat_view *view, const double *splat, double rgb[3]) {
    double d[3], norm = 0.0;
    for (int i = 0; i < 3; i++) {
        d[i] = splat[i] - view->eye[i];
        norm += d[i] * d[i];
    }
    for (int i = 0; i < 3; i++) d[i] /= sqrt(norm);
    for (int c = 0; c < 3; c++) {
        rgb[c] = 0.5;
        for (uint32_t k = 0; k < (view->degree + 1) * (view->degree + 1); k++)
            rgb[c] += harmonic(k, d) * splat[4 * (SPLAT_HARMONICS + k) + (uint32_t)c];
        rgb[c] = fmax(rgb[c], 0.0);
    }
}

// Distorts x / z and y / z by the formulas of viewworth/scene.h.
static void distort(const struct reference_splat_view *view, const double at[2], double to[2]) {
    double x = at[0], y = at[1], r2 = x * x + y * y, r = sqrt(r2), t = atan(r), t2 = t * t;
    const double *k = view->k, *p = view->p;
    to[0] = x;
    to[1] = y;
    if (!view->distorts) return;
    if (view->fisheye) {
        double scale = r > 0.0 ? t * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r : 1.0;
        to[0] = scale * x;
        to[1] = scale * y;
        return;
    }
    double radial = (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]))) / (1.0 + r2 * (k[3] + r2 * (k[4] + r2 * k[5])));
    to[0] = x * radial + 2.0 * p[0] * x * y + p[1] * (r2 + 2.0 * x * x);
    to[1] = y * radial + p[0] * (r2 + 2.0 * y * y) + 2.0 * p[1] * x * y;
}

// Computes the linear map from the box to the photo at the splat; the lens by differences.
static void map_of(const struct reference_splat_view *view, const double at[3], double map[2][3]) {
    double slope[2], lens[2][2];
    for (int k = 0; k < 2; k++) slope[k] = fmin(fmax(at[k] / at[2], view->slopes[0][k]), view->slopes[1][k]);
    for (int k = 0; k < 2; k++) {
        const double h = 1e-4 * fmax(1.0, fabs(slope[k]));
        double ends[4][2];
        for (int i = 0; i < 4; i++) {
            double from[2] = {slope[0], slope[1]};
            from[k] += h * (i < 2 ? i - 2 : i - 1);
            distort(view, from, ends[i]);
        }
        for (int i = 0; i < 2; i++) // an error of fourth order
            lens[i][k] = (ends[0][i] - 8.0 * ends[1][i] + 8.0 * ends[2][i] - ends[3][i]) / (12.0 * h);
    }
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 3; i++) {
            double x = (view->axes[0][i] - slope[0] * view->axes[2][i]) / at[2];
            double y = (view->axes[1][i] - slope[1] * view->axes[2][i]) / at[2];
            map[k][i] = view->focal[k] * (lens[k][0] * x + lens[k][1] * y);
        }
}

void reference_splat_project(const struct reference_splat_view *view, const double *splat,
                             struct reference_splat_shape *shape) {
    double at[3] = {0}, map[2][3], covariance[3][3], flat[2][2] = {{0}}, place[2];
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 3; i++) at[axis] += view->axes[axis][i] * (splat[i] - view->eye[i]);
    covariance_of(splat, covariance);
    map_of(view, at, map);
    distort(view, (const double[2]){at[0] / at[2], at[1] / at[2]}, place);
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++)
            for (int i = 0; i < 3; i++)
                for (int j = 0; j < 3; j++) flat[a][b] += map[a][i] * covariance[i][j] * map[b][j];
    double xx = flat[0][0] + LOW_PASS, yy = flat[1][1] + LOW_PASS, xy = flat[0][1], det = xx * yy - xy * xy;
    *shape = (struct reference_splat_shape){
        .centre = {view->focal[0] * place[0] + view->middle[0], view->focal[1] * place[1] + view->middle[1]},
        .covariance = {xx, xy, yy},
        .conic = {yy / det, -xy / det, xx / det},
        .depth = at[2],
    };
    shape->opacity = 1.0 / (1.0 + exp(-splat[3]));
    shape->shown = hypot(at[0], at[1]) <= view->reach * at[2] && at[2] >= NEAR && shape->opacity >= ALPHA_LEAST;
    colour_of(view, splat, shape->rgb);
}

static double raw_alpha(const struct reference_splat_shape *shape, double dx, double dy) {
    double exponent = 0.5 * (shape->conic[0] * dx * dx + shape->conic[2] * dy * dy) + shape->conic[1] * dx * dy;
    return shape->opacity * exp(-exponent);
}

void reference_splat_pixel(const struct reference_splat_shape *shapes, const uint32_t *order, uint32_t count, double x,
                           double y, bool held, uint8_t *fates, double colour[3], double *left) {
    *left = 1.0;
    bool ended = false;
    memset(colour, 0, 3 * sizeof colour[0]);
    for (uint32_t i = 0; i < count; i++) {
        const struct reference_splat_shape *shape = &shapes[order[i]];
        double raw = raw_alpha(shape, x - shape->centre[0], y - shape->centre[1]);
        if (!held) {
            double alpha = fmin(raw, ALPHA_MOST);
            bool drawn = shape->shown && !ended && alpha >= ALPHA_LEAST;
            if (drawn && *left * (1.0 - alpha) <= LEFT_LEAST) ended = true;
            fates[i] = !drawn || ended    ? REFERENCE_SPLAT_SKIPPED
                       : raw > ALPHA_MOST ? REFERENCE_SPLAT_CAPPED
                                          : REFERENCE_SPLAT_BLENDED;
        }
        if (fates[i] == REFERENCE_SPLAT_SKIPPED) continue;
        double alpha = fates[i] == REFERENCE_SPLAT_CAPPED ? ALPHA_MOST : raw;
        for (int c = 0; c < 3; c++) colour[c] += *left * alpha * shape->rgb[c];
        *left *= 1.0 - alpha;
    }
}

void reference_splat_pixel_back(const struct reference_splat_shape *shapes, const uint32_t *order, uint32_t count,
                                double x, double y, const uint8_t *fates, const double slope[4],
                                struct reference_splat_sums *sums) {
    double colour[3], left, after = 0.0;
    uint8_t *follow = (uint8_t *)fates;
    reference_splat_pixel(shapes, order, count, x, y, true, follow, colour, &left);
    double value = slope[3] * left; // value of all beyond splat i, with the light that is left there
    for (uint32_t i = count; i-- > 0;) {
        if (fates[i] == REFERENCE_SPLAT_SKIPPED) continue;
        const struct reference_splat_shape *shape = &shapes[order[i]];
        double dx = x - shape->centre[0], dy = y - shape->centre[1], raw = raw_alpha(shape, dx, dy);
        double alpha = fates[i] == REFERENCE_SPLAT_CAPPED ? ALPHA_MOST : raw, before = left / (1.0 - alpha);
        double own = slope[0] * shape->rgb[0] + slope[1] * shape->rgb[1] + slope[2] * shape->rgb[2];
        double q = fates[i] == REFERENCE_SPLAT_CAPPED ? 0.0 : raw * (before * own - (value + after) / (1.0 - alpha));
        const double terms[6] = {q, q * dx, q * dy, q * dx * dx, q * dx * dy, q * dy * dy};
        double *to[6] = {&sums[i].q, &sums[i].qx, &sums[i].qy, &sums[i].qxx, &sums[i].qxy, &sums[i].qyy};
        for (int k = 0; k < 6; k++) *to[k] += terms[k];
        for (int c = 0; c < 3; c++) sums[i].rgb[c] += before * alpha * slope[c];
        after += before * alpha * own;
        left = before;
    }
}

// Returns 1 - SSIM of the window about a pixel.
static double window_loss(const struct reference_splat_square *square, int x, int y) {
    enum { SIDE = VW_SPLAT_SQUARE };
    double shares[SIDE * SIDE], total = 0.0, mean[2] = {0}, variance[2] = {0}, covariance = 0.0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        int dx = abs(i % SIDE - x), dy = abs(i / SIDE - y);
        double gaussian = dx <= 5 && dy <= 5 ? exp(-(dx * dx + dy * dy) / (2.0 * 1.5 * 1.5)) : 0.0;
        total += shares[i] = square->weight[i] * gaussian;
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        mean[0] += shares[i] / total * square->seen[i];
        mean[1] += shares[i] / total * square->photo[i];
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        variance[0] += shares[i] / total * pow(square->seen[i] - mean[0], 2);
        variance[1] += shares[i] / total * pow(square->photo[i] - mean[1], 2);
        covariance += shares[i] / total * (square->seen[i] - mean[0]) * (square->photo[i] - mean[1]);
    }
    double luminance = (2.0 * mean[0] * mean[1] + 1e-4) / (mean[0] * mean[0] + mean[1] * mean[1] + 1e-4);
    return 1.0 - luminance * (2.0 * covariance + 9e-4) / (variance[0] + variance[1] + 9e-4);
}

double reference_splat_windows(const struct reference_splat_square *square,
                               double losses[VW_SPLAT_SQUARE * VW_SPLAT_SQUARE]) {
    double sum = 0.0;
    for (int i = 0; i < VW_SPLAT_SQUARE * VW_SPLAT_SQUARE; i++) {
        double weight = square->weight[i];
        losses[i] = weight > 0.0 ? weight * window_loss(square, i % VW_SPLAT_SQUARE, i / VW_SPLAT_SQUARE) : 0.0;
        sum += losses[i];
    }
    return sum;
}
