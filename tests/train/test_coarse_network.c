// The coarse network of importance samples (--coarse-network own): it learns as a field of the even samples alone does,
// bit for bit, and the field as with the places that it shows. test_fields.c has whole trainings.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/step_bench.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"

enum { STEPS = 4 };

// ---- Steps ----------------------------------------------------------------------------------------------------------

static struct step_case coarse_case(void) {
    return (struct step_case){.name = "coarse",
                              .seed = 601,
                              .field = VW_FIELD_MLP,
                              .mlp_depth = 6,
                              .width = 24,
                              .frequencies = 3,
                              .rays = 60,
                              .samples = 8,
                              .importance_samples = 12,
                              .own_coarse = true,
                              .loss = VW_LOSS_L2};
}

// Returns the case without importance samples: a field of the even ones alone.
static struct step_case even_case(struct step_case setup) {
    setup.importance_samples = 0;
    setup.own_coarse = false;
    return setup;
}

static float *first_of(float *params, const struct vw_param_range *range) {
    return params + range->offset_bytes / sizeof *params;
}

static void copy_range(const struct step_bench *from, const struct vw_param_range *source, struct step_bench *to,
                       const struct vw_param_range *target) {
    assert_int_equal(source->size_bytes, target->size_bytes);
    memcpy(first_of(to->params, target), first_of(from->params, source), source->size_bytes);
}

// Copies to the field `even` the params of the coarse network of `own`, and those of sky, photos and visibility.
static void take_over(const struct step_bench *own, struct step_bench *even) {
    const struct vw_param_range network = vw_visibility_network(&own->model),
                                even_network = vw_visibility_network(&even->model);
    copy_range(own, &own->layout->coarse, even, &even->model.weights);
    copy_range(own, &own->model.ranges[VW_SLOT_SKY], even, &even->model.ranges[VW_SLOT_SKY]);
    copy_range(own, &own->model.ranges[VW_SLOT_APPEARANCE], even, &even->model.ranges[VW_SLOT_APPEARANCE]);
    copy_range(own, &network, even, &even_network);
    copy_range(own, &own->model.ranges[VW_SLOT_VISIBILITY_CODES], even, &even->model.ranges[VW_SLOT_VISIBILITY_CODES]);
    step_bench_write_params(even);
}

// Its gradient is that of a field of the even samples, beside every effect: neither codes nor transients are in it.
TEST(its_gradient_is_that_of_a_field_of_even_samples) {
    static const char *const effects[][2] = {{NULL, NULL}, // with the coarse network, and without
                                             {"sky,appearance,appearance_code,visibility", "sky,appearance,visibility"},
                                             {"sky,appearance,transient", "sky,appearance"},
                                             {"appearance_encoder", NULL}};
    for (int i = 0; i < 4; i++) {
        struct step_case setup = coarse_case(), plain = even_case(setup);
        setup.effects = effects[i][0];
        plain.effects = effects[i][1];
        struct step_bench *own = step_bench_open(&setup), *even = step_bench_open(&plain);
        take_over(own, even);
        test_write(even->pixel_buffer, own->pixels); // from one photo in both
        step_bench_gradients(own, 3);
        step_bench_gradients(even, 3);
        float *d_own = test_read(own->step.d_weights), *d_even = test_read(even->step.d_weights);
        check_same_bits(own->where, "gradient of the coarse network", d_own + 4 * (size_t)own->layout->coarse_column,
                        d_even, own->layout->coarse.size_bytes);
        test_release(own);
        test_release(even);
    }
}

// Also through the optimiser, step after step.
TEST(it_learns_as_a_field_of_even_samples) {
    const struct step_case setup = coarse_case(), plain = even_case(setup);
    struct step_bench *own = step_bench_open(&setup), *even = step_bench_open(&plain);
    take_over(own, even);
    for (uint64_t number = 1; number <= STEPS; number++) {
        step_bench_step(own, number);
        step_bench_step(even, number);
    }
    float *params = test_read(own->field.params), *expected = test_read(even->field.params);
    float *coarse = first_of(params, &own->layout->coarse);
    check_same_bits(own->where, "coarse network", coarse, expected, own->layout->coarse.size_bytes);
    assert_memory_not_equal(coarse, first_of(own->params, &own->layout->coarse), own->layout->coarse.size_bytes);
}

// Gradients of the field and of the coarse network at these params, and the step's loss.
struct taken {
    float *d_weights;
    vw_float4 *scalars;
};

static struct taken take(struct step_bench *bench) {
    step_bench_write_params(bench);
    step_bench_gradients(bench, 3);
    return (struct taken){test_read(bench->step.d_weights), test_read(bench->scalars)};
}

// Colours of the coarse network change its own gradient, and not a bit of the field's or of the step's loss.
TEST(the_field_sees_nothing_of_its_colours) {
    struct step_case setup = coarse_case();
    setup.effects = "sky,appearance,visibility"; // their gradients are those of the field's colours
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_model *model = &bench->model;
    uint32_t end = vw_volume_of(model)->coarse_column + vw_volume_of(model)->coarse_columns;
    struct taken before = take(bench);
    float *last_bias = first_of(bench->params, &model->weights) + 4 * (size_t)(end - 1); // biases of the logits of rgb
    last_bias[0] += 0.5f;
    struct taken after = take(bench);
    check_same_bits(bench->where, "loss", after.scalars, before.scalars, sizeof *before.scalars);
    check_same_bits(bench->where, "gradient of field and sky", after.d_weights, before.d_weights,
                    16 * (size_t)vw_volume_of(model)->coarse_column);
    check_same_bits(bench->where, "gradient of visibility", after.d_weights + 4 * (size_t)end,
                    before.d_weights + 4 * (size_t)end, 16 * (size_t)(model->moved_columns - end));
    assert_memory_not_equal(after.d_weights + 4 * (size_t)vw_volume_of(model)->coarse_column,
                            before.d_weights + 4 * (size_t)vw_volume_of(model)->coarse_column,
                            vw_volume_of(model)->coarse.size_bytes);
}

// With the same params in both networks, a step has the places, the loss and the gradient of one that shares them.
TEST(equal_networks_place_as_one) {
    struct step_case setup = coarse_case(), shared = setup;
    shared.own_coarse = false;
    struct step_bench *two = step_bench_open(&setup), *one = step_bench_open(&shared);
    copy_range(two, &two->layout->coarse, two, &two->model.weights);
    copy_range(two, &two->model.weights, one, &one->model.weights);
    struct taken of_two = take(two), of_one = take(one);
    check_same_bits(two->where, "loss", of_two.scalars, of_one.scalars, sizeof *of_one.scalars);
    check_same_bits(two->where, "gradient", of_two.d_weights, of_one.d_weights, one->model.weights.size_bytes);
}

// Both networks are drawn: not the same numbers.
TEST(both_networks_are_drawn) {
    const struct step_case setup = coarse_case();
    struct step_bench *bench = step_bench_open(&setup);
    const struct vw_model *model = &bench->model;
    float *params = test_allocate(1, model->param_bytes);
    ASSERT_OK(vw_model_initialise(model, NULL, 5, params));
    const float *field = first_of(params, &model->weights), *coarse = first_of(params, &vw_volume_of(model)->coarse);
    uint32_t equal = 0, drawn = 0;
    for (uint64_t i = 0; i < vw_volume_of(model)->coarse.size_bytes / sizeof *params; i++) {
        drawn += field[i] != 0.0f;
        equal += field[i] != 0.0f && field[i] == coarse[i];
        assert_true((field[i] == 0.0f) == (coarse[i] == 0.0f)); // biases and padding
    }
    assert_true(drawn > 1000 && equal < 5);
}

// The first params of the coarse network, or of the field.
TEST(one_that_is_not_finite_marks_the_step) {
    const struct step_case setup = coarse_case();
    static const float wrong[] = {INFINITY, NAN, 3e38f};
    for (size_t i = 0; i < 2 * VW_ARRAY_COUNT(wrong); i++) {
        struct step_bench *bench = step_bench_open(&setup);
        float *first = first_of(bench->params, i % 2 ? &bench->model.weights : &bench->layout->coarse);
        for (uint32_t k = 0; k < 64; k++) first[k] = wrong[i / 2];
        step_bench_check_skipped(bench, 3);
        test_release(bench);
    }
}

TEST_GROUP(NULL, test_gpu_close)
