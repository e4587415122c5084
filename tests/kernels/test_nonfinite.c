// Decision 8 on the device: one parameter that is not finite marks the step, changes nothing else, and is hidden
// nowhere on its way, neither in training nor in validation.
#include "support/cmocka_test.h"
#include "train/fields/registry.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"

static const struct step_case setup = {
    .name = "poisoned", .seed = 101, .log2_table = 8, .levels = 4, .width = 16, .rays = 24, .samples = 32};

enum { GRID_ENTRY = -1 };
static const struct poison {
    int matrix; // index in reference_matrices, or GRID_ENTRY
    uint32_t out, in;
    float value;
} poisons[] = {
    {0, 3, 5, NAN},
    {1, 0, 2, NAN} /* the density alone */,
    {1, 7, 4, NAN},
    {2, 5, 9, NAN},
    {3, 1, 6, NAN},
    {GRID_ENTRY, 0, 0, NAN},
    {0, 3, 5, INFINITY},
    {1, 0, 2, INFINITY},
    {2, 5, 9, -INFINITY},
    {3, 1, 6, INFINITY},
    {GRID_ENTRY, 0, 0, -INFINITY},
};

static uint64_t param_index(const struct step_bench *bench, const struct poison *poison) {
    const struct vw_specialization *s = &bench->model.specialization;
    if (poison->matrix == GRID_ENTRY)
        return 2 * (uint64_t)s->first_pair[1] + 9; // a pair of level 1 that some samples touch
    return bench->model.weights.offset_bytes / 4 +
           reference_block_index(s, (uint32_t)poison->matrix, poison->out, poison->in);
}

// Takes one good step, so that the moments are not 0, and poisons the params it left.
static void poison_params(struct step_bench *bench, const struct poison *poison) {
    step_bench_step(bench, 1);
    float *params = test_read(bench->field.params);
    params[param_index(bench, poison)] = poison->value;
    memcpy(bench->params, params, bench->model.param_bytes);
    step_bench_write_params(bench);
}

// Checks that rgb and density are NaN, sample by sample, where the reference's are. (Infinity saturates to a number in
// both.)
static void check_samples(const struct step_bench *bench, const struct poison *poison, const struct vw_ray *rays,
                          const float *samples, bool training, uint64_t number) {
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    struct reference_step *reference = reference_step_create(&bench->model, rays, bench->config.rays);
    reference_step_forward(reference, params, training, number);
    uint32_t poisoned = 0;
    for (uint32_t i = 0; i < bench->config.rays * bench->config.samples; i++) {
        const struct reference_sample *sample = &reference->samples[i];
        for (int c = 0; c < 4; c++) {
            bool expected = isnan(c < 3 ? sample->rgb[c] : sample->density), found = isnan(samples[4 * i + c]);
            poisoned += expected;
            if (found != expected)
                fail_msg("%s, %g in matrix %d: sample %u component %d is %g", bench->where, poison->value,
                         poison->matrix, i, c, samples[4 * i + c]);
        }
    }
    if (isnan(poison->value)) assert_true(poisoned > 0);
}

TEST_CASES(a_poisoned_step_is_flagged_and_changes_nothing, i, VW_ARRAY_COUNT(poisons)) {
    struct step_case optimised = setup; // each optimiser, with momentum and without
    optimised.optimizer = (enum vw_optimizer)(i % 3);
    optimised.beta1 = i % 2 ? 0.9 : 0.0;
    struct step_bench *bench = step_bench_open(&optimised);
    poison_params(bench, &poisons[i]);
    struct vw_buffer *kept[] = {bench->field.params, bench->volume->grid_moment1, bench->volume->grid_moment2,
                                bench->volume->grid_visits, bench->step.weight_moments};
    static const char *const names[] = {"params", "moment1", "moment2", "visits", "weight moments"};
    void *before[VW_ARRAY_COUNT(kept)];
    for (size_t k = 0; k < VW_ARRAY_COUNT(kept); k++) before[k] = test_read(kept[k]);
    step_bench_step(bench, 2);
    for (size_t k = 0; k < VW_ARRAY_COUNT(kept); k++) {
        void *after = test_read(kept[k]);
        check_same_bits(bench->where, names[k], after, before[k], vw_buffer_size_bytes(kept[k]));
    }
    struct vw_step_state *flags = test_read(bench->field.step_state);
    uint32_t *scalars = test_read(bench->scalars);
    if (!flags->skipped || !scalars[2])
        fail_msg("%s: %g in matrix %d did not flag the step", bench->where, poisons[i].value, poisons[i].matrix);
    uint64_t *words = test_read(bench->volume->d_grid);
    for (uint64_t j = 0; j < vw_buffer_size_bytes(bench->volume->d_grid) / 8; j++) assert_int_equal(words[j], 0);
    struct vw_ray *rays = test_read(bench->step.ray_buffer);
    float *samples = test_read(bench->volume->samples);
    check_samples(bench, &poisons[i], rays, samples, true, 2);
}

// Checks that a ray that meets a NaN shows it, also when the NaN is in the density alone.
static void check_colours(const struct step_bench *bench, const struct poison *poison, const struct vw_ray *rays,
                          const float *samples, const vw_float4 *colours) {
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        bool poisoned = false;
        for (uint32_t i = 0; i < 4 * bench->config.samples; i++)
            poisoned |= isnan(samples[4 * (size_t)ray * bench->config.samples + i]);
        bool shown = isnan(colours[ray].x) || isnan(colours[ray].y) || isnan(colours[ray].z);
        if (shown != poisoned)
            fail_msg("%s, %g in matrix %d: ray %u is %s, its samples %s (stride %g)", bench->where, poison->value,
                     poison->matrix, ray, shown ? "NaN" : "a number", poisoned ? "are not" : "are",
                     rays[ray].direction_stride.w);
    }
}

TEST_CASES(validation_shows_a_poisoned_field, i, VW_ARRAY_COUNT(poisons)) {
    struct step_bench *bench = step_bench_open(&setup);
    poison_params(bench, &poisons[i]);
    struct vw_evaluator *evaluator = step_bench_evaluate(bench);
    struct vw_ray *rays = test_read(evaluator->rays);
    float *samples = test_read(vw_volume_evaluation_of(evaluator)->samples);
    vw_float4 *colours = test_read(evaluator->colours);
    check_samples(bench, &poisons[i], rays, samples, false, 0);
    check_colours(bench, &poisons[i], rays, samples, colours);
}

// A NaN among the sky's coefficients flags the step, which changes nothing, and shows in every ray that is validated.
TEST(a_poisoned_sky_is_flagged_and_shown) {
    struct step_case with_sky = setup;
    with_sky.effects = "sky";
    struct step_bench *bench = step_bench_open(&with_sky);
    struct vw_evaluator *evaluator = step_bench_evaluator(bench);
    step_bench_step(bench, 1);
    float *params = test_read(bench->field.params);
    params[bench->model.ranges[VW_SLOT_SKY].offset_bytes / sizeof *params + 4 * 5 + 1] = NAN;
    test_write(bench->field.params, params);
    void *moments = test_read(bench->step.weight_moments);
    assert_int_equal(vw_evaluator_set_pixels(evaluator, bench->pixels, bench->config.rays), VW_OK);
    vw_submission_begin(bench->submission);
    vw_step_record_passes(&bench->step, bench->submission, 2, 0, 0);
    vw_evaluator_record(evaluator, bench->submission);
    test_submit(bench->submission);
    float *params_after = test_read(bench->field.params);
    void *moments_after = test_read(bench->step.weight_moments);
    vw_float4 *scalars = test_read(bench->scalars), *colours = test_read(evaluator->colours);
    check_same_bits(bench->where, "params", params_after, params, bench->model.param_bytes);
    check_same_bits(bench->where, "weight moments", moments_after, moments,
                    vw_buffer_size_bytes(bench->step.weight_moments));
    assert_true(scalars->z == 1.0f);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++)
        assert_true(isnan(colours[ray].y) && isfinite(colours[ray].x));
}

// ---- Single passes --------------------------------------------------------------------------------------------------

static bool is_marked(struct step_bench *bench) {
    struct vw_step_state *flags = test_read(bench->field.step_state);
    bool marked = flags->nonfinite != 0;
    return marked;
}

// One NaN in the last sample's rows, of the gradients and of the activations, is enough to mark the step.
TEST(a_weight_gradient_that_is_not_finite_marks_the_step) {
    struct step_bench *bench = step_bench_open(&step_cases[0]);
    struct test_random random = {.seed = bench->config.seed};
    size_t count;
    struct step_rows row = step_bench_rows(bench);
    const uint32_t poisoned[] = {row.encoding, row.hidden2 + 1, row.d_geo, row.d_logit};
    float *rows = step_bench_new_rows(bench, &count);
    input_fill(INPUT_ORDINARY, &random, rows, count);
    weight_gradients_run(bench, rows);
    assert_false(is_marked(bench));
    for (size_t i = 0; i < VW_ARRAY_COUNT(poisoned); i++) {
        float *value = step_bench_row(bench, rows, poisoned[i], bench->padded_samples - 1) + i % 3, kept = *value;
        *value = NAN;
        test_write(bench->field.step_state, &(struct vw_step_state){0});
        weight_gradients_run(bench, rows);
        if (!is_marked(bench)) fail_msg("%s: NaN in row %u did not mark the step", bench->where, poisoned[i]);
        *value = kept;
    }
}

// Rounding would carry out of a NaN whose bits are all ones, which some devices make, and leave 0.
TEST(rounding_to_a_bfloat_keeps_what_is_not_finite) {
    static const uint32_t poison[] = {0x7FFFFFFFu, 0xFFFFFFFFu, 0x7F800000u, 0xFF800000u};
    struct step_bench *bench = step_bench_open(&step_cases[0]);
    float *d_samples = test_read(bench->volume->d_samples);
    for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) memcpy(&d_samples[4 * i + 3], &poison[i], sizeof poison[i]);
    test_write(bench->volume->d_samples,
               d_samples); // gradients of the raw density: stored as they come
    step_bench_dispatch(bench, bench->volume->gradient.field.passes[HASH_BACKWARD], NULL, 0, bench->padded_samples);
    float *rows = step_bench_read_rows(bench);
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(poison); i++)
        assert_false(isfinite(step_bench_row(bench, rows, step_bench_rows(bench).d_geo, i)[0]));
}

// It marks the step whatever other passes find, and adds nothing: the sums are those of the gradient without it.
TEST(a_grid_gradient_that_is_not_finite_marks_the_step) {
    static const float poison[] = {NAN, INFINITY, -INFINITY};
    for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) {
        struct step_bench *bench = step_bench_open(&step_cases[i]);
        float *rows = scatter_rows(bench, INPUT_ORDINARY),
              *gradient = step_bench_row(bench, rows, step_bench_rows(bench).d_encoding, 9) + i;
        struct vw_step_state flags;
        *gradient = poison[i];
        scatter_run(bench, rows, &flags);
        uint64_t *words = test_read(bench->volume->d_grid);
        assert_true(flags.nonfinite != 0);
        *gradient = 0.0f;
        scatter_check(bench, rows, words, flags.clamped);
        test_release(bench);
    }
}

// It marks the step without another pass, from whichever ray it comes; in one channel of one ray alone.
TEST(a_sky_gradient_that_is_not_finite_marks_the_step) {
    static const float poison[] = {0.0f, NAN, INFINITY, -INFINITY};
    struct step_case with_sky = setup;
    with_sky.effects = "sky";
    struct step_bench *bench = step_bench_open(&with_sky);
    uint32_t rays = bench->step.padded_rays;
    vw_float4 *d_logits = test_allocate(rays, sizeof *d_logits);
    step_bench_gradients(bench, 1);
    for (uint32_t ray = 0; ray < rays; ray += rays - 1) {
        for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) {
            struct vw_push_reduce push = {.count = rays};
            d_logits[ray].z = poison[i];
            test_write(bench->step.effect_buffers[VW_SLOT_D_SKY], d_logits);
            test_write(bench->field.step_state, &(struct vw_step_state){0});
            step_bench_dispatch(bench, step_bench_effect_pass(bench, "gradient_sky"), &push, sizeof push,
                                64 * VW_SKY_COLUMNS);
            assert_int_equal(is_marked(bench), poison[i] != 0.0f);
        }
        d_logits[ray].z = 0.0f;
    }
}

TEST(a_loss_that_is_not_finite_marks_the_step) {
    struct step_bench *bench = step_bench_open(&setup);
    struct vw_push_samples push = step_bench_push(bench, 1);
    step_bench_gradients(bench, 1);
    float *samples = test_read(bench->volume->samples);
    samples[0] = NAN; // a colour of the first ray
    for (int poisoned = 0; poisoned < 2; poisoned++) {
        test_write(bench->field.step_state, &(struct vw_step_state){0});
        step_bench_dispatch(bench, bench->volume->gradient.backward_rays, &push, sizeof push,
                            step_bench_lanes(bench, push.ray_count));
        assert_int_equal(is_marked(bench), poisoned); // seen by the passes that follow
        test_write(bench->volume->samples, samples);
    }
}

// A loss, a mark of the passes before the optimiser, or a param that would not be finite.
TEST(the_row_of_a_step_tells_what_is_not_finite) {
    struct step_bench *bench = step_bench_open(&setup);
    struct vw_push_reduce push = {.count = bench->step.padded_rays, .scalar_row = 1};
    size_t words = vw_buffer_size_bytes(bench->step.overflow) / 4;
    for (int poisoned = 0; poisoned < 4; poisoned++) {
        float *losses = test_allocate(push.count, sizeof *losses);
        uint32_t *flags = test_allocate(words, sizeof *flags);
        if (poisoned == 1) losses[push.count - 1] = NAN;
        if (poisoned == 3) flags[words - VW_OVERFLOW_STRIDE] = 1;
        test_write(bench->step.ray_loss, losses);
        test_write(bench->field.step_state, &(struct vw_step_state){.nonfinite = poisoned == 2});
        test_write(bench->step.overflow, flags);
        step_bench_dispatch(bench, bench->step.reduce_loss, &push, sizeof push, 1);
        vw_float4 *scalars = test_read(bench->scalars);
        assert_true(scalars[1].z == (poisoned ? 1.0f : 0.0f));
        assert_false(is_marked(bench)); // the next step begins anew
        assert_int_equal(step_bench_take_overflows(bench), 0);
    }
}

// Passes that do not belong to a step leave a mark for reduce_adjoint, but none for the next step.
TEST(flags_are_cleared_without_a_row) {
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_step_state marked = {.nonfinite = 1, .clamped = 5, .view = 3}, clean = {0};
    const uint32_t rows[] = {VW_NO_ROW, VW_NO_ROW, 0};
    for (int i = 0; i < 3; i++) { // the second and the third find no mark
        if (i != 1) test_write(bench->field.step_state, i ? &clean : &marked);
        vw_submission_begin(bench->submission);
        vw_step_record_loss(&bench->step, bench->submission, 0, rows[i]);
        test_submit(bench->submission);
        const struct vw_step_state *flags = test_read(bench->field.step_state);
        assert_true(flags->nonfinite == 0 && flags->clamped == 0 && flags->view == (i < 2 ? 3 : 0));
        assert_int_equal(flags->skipped, i < 2);
    }
}

TEST(an_error_that_is_not_finite_reaches_its_view_alone) {
    static const float poison[] = {NAN, INFINITY, -INFINITY};
    struct view_reduction *reduction = reduction_open(test_gpu(), false);
    reduction_fill(reduction, INPUT_ORDINARY, 91);
    for (size_t i = 0; i < VW_ARRAY_COUNT(poison); i++) {
        for (uint32_t view = 0; view < REDUCED_VIEWS; view++) {
            uint32_t ray = reduced_ranges[view].first + reduced_ranges[view].count / 2;
            vw_float4 sums[REDUCED_VIEWS], kept = reduction->colour_data[ray];
            float weight = reduction->ray_data[ray].target_weight.w;
            reduction->colour_data[ray].y = poison[i];
            reduction->ray_data[ray].target_weight.w = 1.0f;
            reduction_run(reduction, sums);
            for (uint32_t other = 0; other < REDUCED_VIEWS; other++) {
                bool finite =
                    isfinite((double)sums[other].x + sums[other].y) && isfinite((double)sums[other].z + sums[other].w);
                if (finite != (other != view))
                    fail_msg("%g in view %u: view %u is %s", poison[i], view, other, finite ? "finite" : "not finite");
            }
            reduction->colour_data[ray] = kept;
            reduction->ray_data[ray].target_weight.w = weight;
        }
    }
}

TEST_GROUP(NULL, test_gpu_close)
