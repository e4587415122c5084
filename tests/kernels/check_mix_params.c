// mix_params: the params on the line through two of their states, in one window and in many.
#include "support/cmocka_test.h"

#include <math.h>
#include <stdlib.h>

#include "kernels/check.h"
#include "train/probes/first_order.h"
#include "gpu/compute.h"
#include "base/memory.h"

// Differences, what is gone of them, and sums round; what lies below FLOAT_LEAST may be flushed before and behind each
// of the three.
static double mix_error(double before, double after, double reach) {
    double gone = fabs(reach * (after - before));
    return FLOAT_ROUNDING * (2.0 * gone + fabs(before) + gone) + 4.0 * FLOAT_LEAST;
}

static void check_reach(struct step_bench *bench, const struct first_order *mix, const float *before,
                        const float *after, float reach) {
    size_t count = bench->model.param_bytes / sizeof *before;
    step_bench_write(bench, mix->before, before);
    step_bench_write(bench, mix->after, after);
    vw_batch_begin(bench->batch);
    first_order_record_mix(mix, bench->batch, reach);
    step_bench_submit(bench);
    float *params = step_bench_read(bench, bench->field.params);
    for (size_t i = 0; i < count; i++)
        check_value(bench->where, "param", i, params[i], reference_mix(before[i], after[i], reach),
                    mix_error(before[i], after[i], reach));
    free(params);
}

void check_mix_params(struct step_bench *bench, enum input_kind kind) {
    static const float reaches[] = {0.0625f, -0.0625f, 1.0f, -3.0f};
    const uint64_t binding_bytes[] = {1 << 27, bench->model.param_bytes / 3 +
                                                   255}; // the second is rounded down: four windows, or three
    size_t count = bench->model.param_bytes / sizeof(float);
    float *before = vw_allocate(count, sizeof *before), *after = vw_allocate(count, sizeof *after);
    struct test_random random = {.seed = bench->config.seed};
    input_fill(kind, &random, before, count);
    input_fill(kind, &random, after, count);
    for (size_t b = 0; b < VW_ARRAY_COUNT(binding_bytes); b++) {
        struct first_order *mix = NULL;
        if (first_order_create(&bench->field, binding_bytes[b], &mix))
            fail_msg("%s: %s", bench->where, vw_error_message());
        for (size_t r = b; r < VW_ARRAY_COUNT(reaches); r += 2) check_reach(bench, mix, before, after, reaches[r]);
        first_order_destroy(&mix);
    }
    step_bench_write_params(bench);
    free(before);
    free(after);
}
