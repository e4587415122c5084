#include "kernels/checks/check.h"
#include "support/cmocka_test.h"

const char *const input_kind_names[INPUT_KINDS] = {"ordinary",      "large",    "tiny",      "zero",
                                                   "negative zero", "denormal", "saturating"};

// Draws a number of random sign and of a magnitude in [2^least, 2^most).
static float draw_between(struct test_random *random, float least, float most) {
    float magnitude = exp2f(least + (most - least) * (0.5f + 0.5f * test_random_next(random)));
    return copysignf(magnitude, test_random_next(random));
}

float input_draw(enum input_kind kind, struct test_random *random) {
    switch (kind) {
    case INPUT_LARGE: return draw_between(random, 0.0f, 10.0f);
    case INPUT_TINY: return draw_between(random, -60.0f, -20.0f);
    case INPUT_ZERO: return 0.0f;
    case INPUT_NEGATIVE_ZERO: return -0.0f;
    case INPUT_DENORMAL: return draw_between(random, -148.0f, -126.0f);
    case INPUT_SATURATING: return draw_between(random, 20.0f, 40.0f);
    default: return test_random_next(random);
    }
}

void input_fill(enum input_kind kind, struct test_random *random, float *values, size_t count) {
    for (size_t i = 0; i < count; i++) values[i] = input_draw(kind, random);
}

// Bounds the error of n products and n - 1 additions, in any order: each rounds by at most half a unit of the sum of
// all magnitudes, and each product and operand may be flushed to 0.
static double product_error(const struct reference_matrix *matrix, bool transposed, uint32_t index, const double *in,
                            const double *in_error) {
    uint32_t terms = transposed ? matrix->out : matrix->in;
    double magnitude = 0.0, passed_on = 0.0, flushed = 0.0;
    for (uint32_t i = 0; i < terms; i++) {
        double weight =
            fabs(transposed ? matrix->values[i * matrix->in + index] : matrix->values[index * matrix->in + i]);
        magnitude += weight * (fabs(in[i]) + in_error[i]);
        passed_on += weight * in_error[i];
        flushed += FLOAT_LEAST * (1.0 + weight + fabs(in[i]));
    }
    return passed_on + (terms + 1) * FLOAT_ROUNDING * magnitude + flushed;
}

void product_errors(const struct reference_matrix *matrix, bool transposed, const double *in, const double *in_error,
                    double *errors) {
    for (uint32_t i = 0; i < (transposed ? matrix->in : matrix->out); i++)
        errors[i] = product_error(matrix, transposed, i, in, in_error);
}

void check_row(const struct step_bench *bench, const float *rows, const char *what, uint32_t row, uint32_t sample,
               uint32_t count, const double *expected, const double *errors) {
    for (uint32_t i = 0; i < count; i++)
        check_value(bench->where, what, sample, step_bench_row(bench, rows, row + i / 4, sample)[i % 4], expected[i],
                    rounded_error(expected[i], errors[i]));
}

void check_between(const char *where, const char *what, uint64_t index, double device, double low, double high) {
    if (device >= low && device <= high) return;
    fail_msg("%s: %s[%llu] is %.9g on the device, by the reference between %.9g and %.9g", where, what,
             (unsigned long long)index, device, low, high);
}
