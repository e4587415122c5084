#include "reference.h"

#include <math.h>

// Returns the light that passes the first `count` samples.
static double passed(const struct reference_point *points, uint32_t count) {
    double tau = 0.0;
    for (uint32_t i = 0; i < count; i++) tau += points[i].density * points[i].length;
    return exp(-tau);
}

double reference_composite(const struct reference_point *points, uint32_t count, const double background[3],
                           double colour[3]) {
    double left = passed(points, count);
    for (int c = 0; c < 3; c++) colour[c] = left * background[c];
    for (uint32_t i = 0; i < count; i++) {
        double weight = -expm1(-points[i].density * points[i].length) * passed(points, i);
        for (int c = 0; c < 3; c++) colour[c] += weight * points[i].rgb[c];
    }
    return left;
}

// Goes from the last sample to the first. Light that reaches the camera from sample i on is T_i (opacity_i rgb_i + (1 -
// opacity_i) beyond_i), with T_i what passes the samples before and beyond_i what is seen from behind sample i: so
// beyond_i follows from beyond_(i+1).
void reference_composite_gradient(const struct reference_point *points, uint32_t count, const double background[3],
                                  const double d_colour[3], struct reference_d_point *d_points) {
    double beyond[3] = {background[0], background[1], background[2]};
    for (uint32_t i = count; i-- > 0;) {
        double tau = points[i].density * points[i].length, reached = passed(points, i);
        d_points[i].raw = 0.0;
        for (int c = 0; c < 3; c++) {
            d_points[i].rgb[c] = d_colour[c] * reached * -expm1(-tau);
            d_points[i].raw +=
                d_colour[c] * reached * exp(-tau) * (points[i].rgb[c] - beyond[c]) * tau; // d tau / d raw = tau
            beyond[c] = -expm1(-tau) * points[i].rgb[c] + exp(-tau) * beyond[c];
        }
    }
}
