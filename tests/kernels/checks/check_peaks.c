// copy_memory and multiply_registers: a peak that did less work than it is said to would flatter the device.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

enum { INVOCATIONS = 640, CHAINS = 8 };
static const float FACTOR = 0.75f;

// Runs a pass from `from` to what is returned.
static float *run(struct step_bench *bench, const struct vw_shader *shader, const float *from,
                  const struct vw_push_peak *push) {
    const uint64_t size_bytes = INVOCATIONS * sizeof(vw_float4);
    struct vw_buffer *source = test_buffer(bench->gpu, "from", size_bytes),
                     *target = test_buffer(bench->gpu, "to", size_bytes);
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_PEAK_FROM, .buffer = source},
                                          {.slot = VW_SLOT_PEAK_TO, .buffer = target}};
    const struct vw_pass_params params = {
        .shader = shader, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    const struct vw_pass *pass = test_pass(bench->gpu, params);
    step_bench_write(bench, source, from);
    step_bench_dispatch(bench, pass, push, push ? sizeof *push : 0, INVOCATIONS);
    return step_bench_read(bench, target);
}

void check_copy_memory(struct step_bench *bench, enum input_kind kind) {
    float from[4 * INVOCATIONS];
    struct test_random random = {.seed = bench->config.seed};
    input_fill(kind, &random, from, VW_ARRAY_COUNT(from));
    float *to = run(bench, &vw_shader_copy_memory, from, NULL);
    check_same_bits(bench->where, "copy", to, from, sizeof from);
}

void check_multiply_registers(struct step_bench *bench, enum input_kind kind) {
    static const float nothing[4 * INVOCATIONS];
    struct test_random random = {.seed = bench->config.seed};
    const struct vw_push_peak push = {.start = input_draw(kind, &random), .factor = FACTOR};
    float *to = run(bench, &vw_shader_multiply_registers, nothing, &push);
    double sum = 0.0, limit = fabs((double)push.start) / (1.0 - FACTOR);
    for (int chain = 0; chain < CHAINS; chain++) {
        double value = chain + (double)push.start;
        for (uint32_t i = 0; i < VW_PEAK_TRIPS * VW_PEAK_REPEATS; i++) value = value * FACTOR + push.start;
        sum += value;
    }
    // A chain forgets its roundings as it forgets its beginning.
    double tolerance = CHAINS * (2.0 / (1.0 - FACTOR) + CHAINS) * (FLOAT_ROUNDING * limit + FLOAT_LEAST);
    for (size_t i = 0; i < VW_ARRAY_COUNT(nothing); i++)
        check_value(bench->where, "sum of the chains", i, to[i], sum, tolerance);
}
