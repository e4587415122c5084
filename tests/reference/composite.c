#include "reference.h"

#include <math.h>

// The light that passes samples [first, end).
static double passed(const struct reference_point *points, uint32_t first, uint32_t end, double stride) {
    double tau = 0.0;
    for (uint32_t i = first; i < end; i++) tau += points[i].density * stride;
    return exp(-tau);
}

// What is seen from just before sample `first`, looking away from the camera.
static void seen_from(const struct reference_point *points, uint32_t first, uint32_t count, double stride, const double background[3],
                      double colour[3]) {
    double left = passed(points, first, count, stride);
    for (int c = 0; c < 3; c++) colour[c] = left * background[c];
    for (uint32_t i = first; i < count; i++) {
        double weight = -expm1(-points[i].density * stride) * passed(points, first, i, stride);
        for (int c = 0; c < 3; c++) colour[c] += weight * points[i].rgb[c];
    }
}

double reference_composite(const struct reference_point *points, uint32_t count, double stride, const double background[3],
                           double colour[3]) {
    seen_from(points, 0, count, stride, background, colour);
    return passed(points, 0, count, stride);
}

// Light that reaches the camera from sample i on is T_i (opacity_i rgb_i + (1 - opacity_i) beyond_i), with T_i what passes the samples
// before.
void reference_composite_gradient(const struct reference_point *points, uint32_t count, double stride, const double background[3],
                                  const double d_colour[3], struct reference_d_point *d_points) {
    for (uint32_t i = 0; i < count; i++) {
        double beyond[3], tau = points[i].density * stride, reached = passed(points, 0, i, stride);
        seen_from(points, i + 1, count, stride, background, beyond);
        d_points[i].raw = 0.0;
        for (int c = 0; c < 3; c++) {
            d_points[i].rgb[c] = d_colour[c] * reached * -expm1(-tau);
            d_points[i].raw += d_colour[c] * reached * exp(-tau) * (points[i].rgb[c] - beyond[c]) * tau; // d tau / d raw = tau
        }
    }
}
