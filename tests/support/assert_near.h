// Comparison of doubles (cmocka 1.1.5 has it only for floats). Include after <cmocka.h>.
#ifndef VIEWWORTH_ASSERT_NEAR_H
#define VIEWWORTH_ASSERT_NEAR_H

#include <math.h>

#define assert_near(value, expected, tolerance) assert_near_at(value, expected, tolerance, #value, __FILE__, __LINE__)

static inline void assert_near_at(double value, double expected, double tolerance, const char *what, const char *file,
                                  int line) {
    if (fabs(value - expected) <= tolerance) return; // false for NaN
    print_error("%s is %.12g, not %.12g to within %g\n", what, value, expected, tolerance);
    _fail(file, line);
}

#endif
