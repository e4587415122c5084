// A whole step on the device against the reference's whole step, for every case of step_cases.c and so for every effect
// that its params hold: loss, colours, all gradients from the rays on, what each optimiser makes of the params, and
// what validation renders. The kernel tests look at one pass each; here an error may hide nowhere between them. The
// gradients are also held against differences of the reference's loss, without the reference's own gradient.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"
#include "support/gpu_fixture.h"

static const double COLOUR_TOLERANCE = 5e-5; // an encoding in the finest of 16 levels is good to 4e-4 of its entries
static const double SLOPE_STEP = 1e-6;
// Kinks within the step, the third derivative, the rounding of the grid's gradient to quanta (2e-3), and that of the
// constant input of the colour network to a bfloat (3e-3).
static const double SLOPE_TOLERANCE = 5e-3;
static const uint64_t STEP = 259;

// Checks what fit_photo will find of every ray.
static void check_rendered(struct step_bench *bench, const struct reference_step *reference) {
    if (!bench->step.effect_buffers[VW_SLOT_RENDERED]) return;
    vw_float4 *rendered = test_read(bench->step.effect_buffers[VW_SLOT_RENDERED]);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++) {
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "rendered in the step", ray, (&rendered[ray].x)[c], reference->colours[ray][c],
                        COLOUR_TOLERANCE);
        double weight = reference->rays[ray].weight * reference->visible[ray]; // 1 without such an effect
        check_value(bench->where, "weight in the step", ray, rendered[ray].w, weight, COLOUR_TOLERANCE);
    }
}

struct sloping { // a step of the reference, and the params that move
    struct reference_step *reference;
    struct reference_params *params;
};

static double loss_of(void *of) {
    const struct sloping *step = of;
    reference_step_forward(step->reference, step->params, true, STEP);
    return step->reference->loss;
}

static void check_slopes(struct step_bench *bench, const struct hard_gradients *gradients) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct sloping step = {step_bench_reference(bench), reference_params_create(&bench->model, bench->params)};
    const struct slope_check check = {bench->where, loss_of,         &step,
                                      SLOPE_STEP,   SLOPE_TOLERANCE, 1e-30}; // a sky may be hidden
    struct step_range ranges[STEP_RANGES_MAX];
    size_t features = 2 * (size_t)bench->layout->pair_count;
    float *d_grid = test_allocate(features, sizeof *d_grid);
    uint32_t count = step_bench_ranges(bench, step.reference, step.params, gradients->weights, ranges);
    for (uint32_t r = 0; r < count; r++)
        assert_true(check_slope(&check, ranges[r].name, ranges[r].values, ranges[r].gradient, ranges[r].count) > 0.0);
    for (size_t i = 0; i < features; i++) d_grid[i] = (float)((double)gradients->quanta[i] * s->gradient_quantum);
    assert_true(check_slope(&check, "grid", step.params->grid, d_grid, features) > 0.0);
}

// The quick tests take the slopes of every second case.
TEST_CASES(steps_match_the_reference, i, step_case_count) {
    if (step_cases[i].weight_scale > 1.0f) return; // others amplify rounding beyond use here
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    struct hard_finding finding = {.where = bench->where};
    hard_check_rendering(&finding, bench);
    if (i % 2 || test_is_full()) {
        const struct hard_gradients gradients = hard_take_gradients(bench, STEP);
        check_slopes(bench, &gradients);
    }
    check_rendered(bench, hard_check_step(&finding, bench, STEP));
}

TEST_GROUP(NULL, test_gpu_close)
