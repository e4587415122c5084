// Every cmocka test and helper includes this first: cmocka with the headers that it needs, and the assertions that it
// lacks.
#ifndef VIEWWORTH_TESTS_SUPPORT_CMOCKA_TEST_H
#define VIEWWORTH_TESTS_SUPPORT_CMOCKA_TEST_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "viewworth/status.h"

// Fails the test, with the call and its message, unless the call gives VW_OK.
#define ASSERT_OK(call)                                                                                                \
    do {                                                                                                               \
        enum vw_status status_of_call = (call);                                                                        \
        if (status_of_call) fail_msg("%s gave %d: %s", #call, (int)status_of_call, vw_error_message());                \
    } while (0)

// Comparison of doubles; cmocka 1.1.5 has it only for floats.
#define assert_near(value, expected, tolerance) assert_near_at(value, expected, tolerance, #value, __FILE__, __LINE__)

static inline void assert_near_at(double value, double expected, double tolerance, const char *what, const char *file,
                                  int line) {
    if (fabs(value - expected) <= tolerance) return; // false for NaN
    print_error("%s is %.12g, not %.12g to within %g\n", what, value, expected, tolerance);
    _fail(file, line);
}

#endif
