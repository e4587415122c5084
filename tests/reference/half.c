#include "reference.h"

#include <math.h>

static const int LEAST_EXPONENT = -14, DIGITS = 10; // normal halves: least exponent, digits after the point
static const double LARGEST = 65504.0;

double reference_half(double value) {
    if (value == 0.0 || !isfinite(value)) return value;
    int exponent = ilogb(value) < LEAST_EXPONENT ? LEAST_EXPONENT : ilogb(value);
    double unit = ldexp(1.0, exponent - DIGITS), rounded = nearbyint(value / unit) * unit;
    return fabs(rounded) > LARGEST ? copysign(INFINITY, value) : rounded;
}

double reference_half_value(uint16_t bits) {
    int exponent = bits >> 10 & 31, digits = bits & 1023;
    double size = exponent == 31  ? digits ? NAN : INFINITY
                  : exponent == 0 ? ldexp(digits, LEAST_EXPONENT - DIGITS)
                                  : ldexp(1024 + digits, exponent - 15 - DIGITS);
    return bits >> 15 ? -size : size;
}

double reference_feature(const struct vw_model *model, const void *params, uint64_t index) {
    if (model->pair_bytes == 4) return reference_half_value(((const uint16_t *)params)[index]);
    return ((const float *)params)[index];
}
