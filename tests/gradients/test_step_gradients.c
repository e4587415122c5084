// A whole step on the device against the reference's whole step: loss, colours and all gradients from the rays on, and
// the params that gradient descent makes of them. The kernel tests look at one pass each; here an error may hide
// nowhere between them.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "reference/reference.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"

// Positions are good to 2e-7 box edges, so that in the finest of 16 levels, 2,000 cells wide, an encoding is good to
// 4e-4 of its entries; coarser levels are better. These bounds are about ten times what was seen over the cases.
static const double WEIGHT_TOLERANCE = 0x1p-7; // share of the matrix's largest: two bfloats, each good to 2^-8
static const double PHOTO_TOLERANCE = 5e-4;    // share of the largest one of gain, bias or sky
static const double GRID_TOLERANCE = 2e-3;     // share of the level's largest gradient
static const double FLIPPED_QUANTA = 8.0;      // contributions near half a quantum may round either way
static const double LOSS_TOLERANCE = 1e-5;     // relative
static const double COLOUR_TOLERANCE = 5e-5;
static const double GATE_TOLERANCE = 1e-3; // values before a ReLU that are nearer to 0 may fall to either side
static const double SLOPE_STEP = 1e-6;
// Kinks within the step, the third derivative, the rounding of the grid's gradient to quanta (2e-3), and that of the
// constant input of the colour network to a bfloat (3e-3).
static const double SLOPE_TOLERANCE = 5e-3;
static const uint64_t STEP = 259; // past the warm-up of occupancy

static bool ordinary(const struct step_case *setup) {
    return setup->weight_scale <= 1.0f;
} // others amplify rounding beyond use here

static void check_weight_gradients(const struct step_bench *bench, const struct reference_step *reference,
                                   const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_weights gradient = reference->d_weights;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, &gradient, matrices);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
        double tolerance = WEIGHT_TOLERANCE * largest(matrices[m].values, matrices[m].out * matrices[m].in);
        for (uint32_t out = 0; out < matrices[m].out; out++)
            for (uint32_t in = 0; in < matrices[m].in; in++)
                check_value(bench->where, matrices[m].name, out * matrices[m].in + in,
                            d_weights[reference_block_index(s, m, out, in)],
                            matrices[m].values[out * matrices[m].in + in], tolerance);
    }
}

static void check_sky_gradient(const struct step_bench *bench, const struct reference_step *reference,
                               const float *d_weights) {
    if (!bench->model.ranges[VW_SLOT_SKY].size_bytes) return;
    const float *d_sky = d_weights + 4 * (size_t)bench->model.weight_columns;
    double tolerance = PHOTO_TOLERANCE * largest(reference->d_sky[0], 3 * VW_SKY_COLUMNS);
    assert_true(tolerance > 0.0);
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS; i++)
        check_value(bench->where, "sky", i, d_sky[i / 3 * 4 + i % 3], reference->d_sky[i / 3][i % 3], tolerance);
}

// Returns the grid's gradient as the device rounds it: in whole quanta, contribution by contribution.
static double *fixed_point_gradient(const struct step_bench *bench, const struct reference_step *reference) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint64_t features = 2 * (uint64_t)bench->model.pair_count;
    int64_t *quanta = test_allocate(features, sizeof *quanta);
    double *gradient = test_allocate(features, sizeof *gradient);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        reference_grid_scatter_fixed(s, reference->samples[i].position, reference->d_samples[i].encoding, quanta);
    for (uint64_t i = 0; i < features; i++) gradient[i] = (double)quanta[i] * s->gradient_quantum;
    return gradient;
}

static void check_grid_gradients(const struct step_bench *bench, const struct reference_step *reference,
                                 const uint64_t *words) {
    const struct vw_specialization *s = &bench->model.specialization;
    int64_t *quanta = test_allocate(2 * (size_t)bench->model.pair_count, sizeof *quanta);
    double *expected = fixed_point_gradient(bench, reference);
    reference_unpack_grid(&bench->model, words, quanta);
    for (uint32_t level = 0; level < s->levels; level++) {
        size_t first = 2 * (size_t)s->first_pair[level],
               end = 2 * (size_t)(level + 1 < s->levels ? s->first_pair[level + 1] : bench->model.pair_count);
        double scale = largest(reference->d_grid + first, end - first);
        assert_true(scale > 0.0);
        for (size_t i = first; i < end; i++)
            check_value(bench->where, s->wide_gradient ? "d_grid, wide" : "d_grid, narrow", i,
                        (double)quanta[i] * s->gradient_quantum, expected[i],
                        GRID_TOLERANCE * scale + FLIPPED_QUANTA * s->gradient_quantum);
    }
}

static void refuse_kinks(const struct step_bench *bench, const struct reference_step *reference) {
    for (uint32_t ray = 0; ray < reference->ray_count; ray++)
        for (int c = 0; c < 3; c++)
            if (bench->config.loss == VW_LOSS_L1 && reference->rays[ray].weight > 0.0 &&
                fabs(reference->errors[ray][c]) < COLOUR_TOLERANCE && reference->errors[ray][c] != 0.0)
                fail_msg("%s: ray %u stands at the kink of the loss; choose another seed", bench->where, ray);
}

// Runs the reference's step from the device's rays, with the device's decisions at ReLUs.
static struct reference_step *run_reference(struct step_bench *bench, const struct reference_params *params,
                                            uint64_t number) {
    vw_uint4 *relu = step_bench_read_active(bench);
    struct reference_step *reference = step_bench_reference(bench);
    reference_step_forward(reference, params, true, number);
    uint64_t wrong = reference_adopt_gates(reference, relu, GATE_TOLERANCE);
    if (wrong) fail_msg("%s: %llu hidden units are on the wrong side of 0", bench->where, (unsigned long long)wrong);
    refuse_kinks(bench, reference);
    reference_step_backward(reference, params);
    return reference;
}

// Checks what update_appearance will find: it is stored per ray, and summed here.
static void check_photo_gradient(struct step_bench *bench, const struct reference_step *reference) {
    if (!bench->step.effect_buffers[VW_SLOT_D_APPEARANCE]) return;
    struct vw_appearance *rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_APPEARANCE]);
    double gain[3] = {0}, bias[3] = {0},
           scale = fmax(largest(reference->d_photo.gain, 3), largest(reference->d_photo.bias, 3));
    assert_true(scale > 0.0);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++)
        for (int c = 0; c < 3; c++) {
            gain[c] += (&rays[ray].gain.x)[c];
            bias[c] += (&rays[ray].bias.x)[c];
        }
    for (uint64_t c = 0; c < 3; c++) {
        check_value(bench->where, "d_gain", c, gain[c], reference->d_photo.gain[c], PHOTO_TOLERANCE * scale);
        check_value(bench->where, "d_bias", c, bias[c], reference->d_photo.bias[c], PHOTO_TOLERANCE * scale);
    }
}

// Checks the gradient of the network, and by the sums in its first layer, whose biases have an input of 1, that of the
// photo's code.
static void check_visibility_gradient(const struct step_bench *bench, const struct reference_step *reference,
                                      const float *d_weights) {
    if (!vw_visibility_network(&bench->model).size_bytes) return;
    const float *d_network = d_weights + 4 * (size_t)bench->model.specialization.visibility_column;
    double tolerance = PHOTO_TOLERANCE * largest(reference->d_visibility, REFERENCE_VISIBILITY);
    assert_true(tolerance > 0.0);
    for (uint32_t i = 0; i < REFERENCE_VISIBILITY; i++)
        check_value(bench->where, "visibility", i, d_network[i], reference->d_visibility[i], tolerance);
}

TEST_CASES(gradients_match_the_reference, i, step_case_count) {
    if (!ordinary(&step_cases[i])) return;
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    step_bench_gradients(bench, STEP);
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    struct reference_step *reference = run_reference(bench, params, STEP);
    float *d_weights = step_bench_read(bench, bench->step.d_weights);
    uint64_t *words = step_bench_read(bench, bench->step.d_grid);
    vw_float4 *scalars = step_bench_read(bench, bench->scalars);
    check_value(bench->where, "loss", 0, (double)scalars->x + scalars->y, reference->loss,
                LOSS_TOLERANCE * reference->loss);
    check_weight_gradients(bench, reference, d_weights);
    check_sky_gradient(bench, reference, d_weights);
    check_visibility_gradient(bench, reference, d_weights);
    check_grid_gradients(bench, reference, words);
    check_photo_gradient(bench, reference);
}

// ---- The slope of the loss ------------------------------------------------------------------------------------------

// Returns the reference's loss of the step when `count` values have moved by `distance` times their direction.
static double moved_loss(struct reference_step *reference, const struct reference_params *params, double *values,
                         const double *direction, size_t count, double distance) {
    for (size_t i = 0; i < count; i++) values[i] += distance * direction[i];
    reference_step_forward(reference, params, true, STEP);
    for (size_t i = 0; i < count; i++) values[i] -= distance * direction[i];
    return reference->loss;
}

// Checks that moving each value of a range up where the device says that the loss rises, and down where it says that it
// falls, raises the reference's loss by the sum of all magnitudes.
static void check_slope(const struct step_bench *bench, struct reference_step *reference,
                        const struct reference_params *params, const char *range, double *values,
                        const double *gradient, size_t count) {
    double *direction = test_allocate(count, sizeof *direction), magnitudes = 0.0;
    for (size_t i = 0; i < count; i++) direction[i] = gradient[i] > 0.0 ? 1.0 : gradient[i] < 0.0 ? -1.0 : 0.0;
    for (size_t i = 0; i < count; i++) magnitudes += fabs(gradient[i]);
    double higher = moved_loss(reference, params, values, direction, count, SLOPE_STEP),
           lower = moved_loss(reference, params, values, direction, count, -SLOPE_STEP);
    assert_true(magnitudes > 0.0);
    check_value(bench->where, range, 0, magnitudes, (higher - lower) / (2.0 * SLOPE_STEP),
                SLOPE_TOLERANCE * magnitudes);
}

// Checks the photo's slopes by the device's gradients: by those of what is seen of each ray, and by those of the
// weights of the colour network's input 0.
static void check_photo_slopes(struct step_bench *bench, struct reference_step *reference,
                               struct reference_params *params, const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_photo *photo = params->photos ? &params->photos[bench->view] : NULL;
    if (s->effect_appearance) {
        struct vw_appearance *rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_D_APPEARANCE]);
        double gain[3] = {0}, bias[3] = {0};
        for (uint32_t ray = 0; ray < bench->step.padded_rays; ray++)
            for (int c = 0; c < 3; c++) {
                gain[c] += (&rays[ray].gain.x)[c];
                bias[c] += (&rays[ray].bias.x)[c];
            }
        check_slope(bench, reference, params, "gain", photo->gain, gain, 3);
        check_slope(bench, reference, params, "bias", photo->bias, bias, 3);
    }
    if (!s->effect_appearance_code) return;
    double d_shift[REFERENCE_WIDTH_MAX], d_code[REFERENCE_CODE], d_code_weights[REFERENCE_WIDTH_MAX * REFERENCE_CODE];
    for (uint32_t i = 0; i < 4 * s->width4; i++) d_shift[i] = d_weights[reference_block_index(s, 2, i, 0)];
    reference_mix_code_gradient(4 * s->width4, params->code_weights, photo->code, d_shift, d_code_weights, d_code);
    check_slope(bench, reference, params, "code weights", params->code_weights, d_code_weights,
                4 * s->width4 * REFERENCE_CODE);
    check_slope(bench, reference, params, "code", photo->code, d_code, REFERENCE_CODE);
}

static void check_slopes(struct step_bench *bench, struct reference_step *reference, struct reference_params *params) {
    const struct vw_specialization *s = &bench->model.specialization;
    size_t features = 2 * (size_t)bench->model.pair_count;
    float *d_weights = step_bench_read(bench, bench->step.d_weights);
    uint64_t *words = step_bench_read(bench, bench->step.d_grid);
    int64_t *quanta = test_allocate(features, sizeof *quanta);
    double *gradient = test_allocate(features + REFERENCE_WIDTH_MAX * REFERENCE_ENCODING_MAX, sizeof *gradient);
    struct reference_matrix values[REFERENCE_MATRICES];
    reference_matrices(s, &params->weights, values);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
        for (uint32_t i = 0; i < values[m].out * values[m].in; i++)
            gradient[i] = d_weights[reference_block_index(s, m, i / values[m].in, i % values[m].in)];
        check_slope(bench, reference, params, values[m].name, values[m].values, gradient, values[m].out * values[m].in);
    }
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS && bench->model.ranges[VW_SLOT_SKY].size_bytes; i++)
        gradient[i] = d_weights[4 * (bench->model.weight_columns + i / 3) + i % 3];
    if (bench->model.ranges[VW_SLOT_SKY].size_bytes)
        check_slope(bench, reference, params, "sky", params->sky[0], gradient, 3 * VW_SKY_COLUMNS);
    for (uint32_t i = 0; i < REFERENCE_VISIBILITY && s->effect_visibility; i++)
        gradient[i] = d_weights[4 * s->visibility_column + i];
    if (s->effect_visibility)
        check_slope(bench, reference, params, "visibility", params->visibility, gradient, REFERENCE_VISIBILITY);
    reference_unpack_grid(&bench->model, words, quanta);
    for (size_t i = 0; i < features; i++) gradient[i] = (double)quanta[i] * s->gradient_quantum;
    check_slope(bench, reference, params, "grid", params->grid, gradient, features);
    check_photo_slopes(bench, reference, params, d_weights);
}

// From the device's gradients to the differences of the reference's loss, without the reference's own gradient between
// them. The quick tests take every second case.
TEST_CASES(the_loss_changes_as_the_gradients_say, i, step_case_count) {
    if (!ordinary(&step_cases[i]) || (i % 2 == 0 && !test_is_full())) return;
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    step_bench_gradients(bench, STEP);
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    struct reference_step *reference = step_bench_reference(bench);
    check_slopes(bench, reference, params);
}

// ---- Descent and rendering ------------------------------------------------------------------------------------------

// Checks that the step's photo and the code weights moved by their own rates; other photos stay.
static void check_photos_moved(const struct step_bench *bench, uint64_t number, const struct reference_step *reference,
                               const struct reference_params *before, const float *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    for (uint32_t view = 0; view < reference_photo_count(&bench->model); view++) {
        struct reference_photo device = reference_photo_of(&bench->model, after, view), expected = before->photos[view];
        double mean = view == bench->view ? 1.0 / bench->config.rays : 0.0,
               ridge = view == bench->view ? reference_photo_ridge : 0.0,
               rate = s->learning_rate * reference_photo_rate(number);
        for (uint64_t c = 0; c < 3 && s->effect_appearance; c++) {
            double gain = expected.gain[c] - rate * (mean * reference->d_photo.gain[c] + ridge * expected.gain[c]),
                   bias = expected.bias[c] - rate * (mean * reference->d_photo.bias[c] + ridge * expected.bias[c]);
            check_value(bench->where, "gain moved", c, device.gain[c], gain, 1e-5 * (1.0 + fabs(gain)));
            check_value(bench->where, "bias moved", c, device.bias[c], bias, 1e-5 * (1.0 + fabs(bias)));
        }
        double largest_move = rate * mean * largest(reference->d_photo.code, REFERENCE_CODE);
        for (uint64_t k = 0; k < REFERENCE_CODE && s->effect_appearance_code; k++)
            check_value(bench->where, "code moved", k, device.code[k],
                        expected.code[k] - rate * (mean * reference->d_photo.code[k] + ridge * expected.code[k]),
                        WEIGHT_TOLERANCE * largest_move +
                            1e-5 * fmax(1.0, fabs(device.code[k]))); // relative where a long step has taken it far
    }
    uint64_t code_weights = bench->model.ranges[VW_SLOT_CODE_WEIGHTS].size_bytes / sizeof *after;
    double rate = s->learning_rate / bench->config.rays,
           largest_move = code_weights ? rate * largest(reference->d_code_weights, code_weights) : 0.0;
    for (uint32_t i = 0; i < code_weights; i++)
        check_value(bench->where, "code weights moved", i,
                    after[bench->model.ranges[VW_SLOT_CODE_WEIGHTS].offset_bytes / sizeof *after + i],
                    before->code_weights[i] - rate * reference->d_code_weights[i],
                    WEIGHT_TOLERANCE * largest_move + 1e-5);
}

// Takes steps 1 to 3 of plain gradient descent, in two chunks: each moves the params by the reference's mean gradient.
static void descend(bool photos) {
    const struct step_case descent = {.name = photos ? "gradient descent, photos of their own" : "gradient descent",
                                      .seed = 131,
                                      .rays = 40,
                                      .loss = VW_LOSS_L2,
                                      .optimizer = VW_OPTIMIZER_SGD,
                                      .learning_rate = 0.5,
                                      .levels = 4,
                                      .width = 16,
                                      .sky = true,
                                      .appearance = photos,
                                      .appearance_code = photos};
    struct step_bench *bench = step_bench_open(&descent);
    const struct vw_specialization *s = &bench->model.specialization;
    uint64_t features = 2 * (uint64_t)bench->model.pair_count;
    for (uint64_t number = 1; number <= 3; number++) {
        float *before = step_bench_read(bench, bench->field.params);
        step_bench_step(bench, number);
        struct reference_params *params = reference_params_create(&bench->model, before);
        struct reference_step *reference = run_reference(bench, params, number);
        float *after = step_bench_read(bench, bench->field.params);
        double rate = s->learning_rate / bench->config.rays, scale = rate * largest(reference->d_grid, features);
        double *expected = fixed_point_gradient(bench, reference);
        for (uint64_t i = 0; i < features; i++)
            check_value(bench->where, "grid moved", i, after[i], params->grid[i] - rate * expected[i],
                        GRID_TOLERANCE * scale + rate * FLIPPED_QUANTA * s->gradient_quantum + 0x1p-23);
        struct reference_matrix values[REFERENCE_MATRICES], gradients[REFERENCE_MATRICES];
        reference_matrices(s, &params->weights, values);
        reference_matrices(s, &reference->d_weights, gradients);
        for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
            uint32_t count = values[m].out * values[m].in;
            double tolerance = WEIGHT_TOLERANCE * rate * largest(gradients[m].values, count) + 0x1p-22;
            for (uint32_t i = 0; i < count; i++)
                check_value(bench->where, values[m].name, i,
                            after[bench->model.weights.offset_bytes / 4 +
                                  reference_block_index(s, m, i / values[m].in, i % values[m].in)],
                            values[m].values[i] - rate * gradients[m].values[i], tolerance);
        }
        for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS; i++)
            check_value(bench->where, "sky", i,
                        after[bench->model.ranges[VW_SLOT_SKY].offset_bytes / 4 + i / 3 * 4 + i % 3],
                        params->sky[i / 3][i % 3] - rate * reference->d_sky[i / 3][i % 3],
                        PHOTO_TOLERANCE * rate * largest(reference->d_sky[0], 3 * VW_SKY_COLUMNS) + 0x1p-22);
        check_photos_moved(bench, number, reference, params, after);
    }
}

TEST(gradient_descent_follows_the_reference) {
    descend(false);
    descend(true);
}

// Validation: bin-centre samples, other passes, the same field.
TEST_CASES(rendering_matches_the_reference, i, step_case_count) {
    if (!ordinary(&step_cases[i])) return;
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    struct vw_evaluator *evaluator = step_bench_evaluate(bench);
    struct vw_ray *rays = step_bench_read(bench, evaluator->rays);
    vw_float4 *colours = step_bench_read(bench, evaluator->colours);
    struct reference_params *params = reference_params_create(&bench->model, bench->params);
    struct reference_step *reference = reference_step_create(&bench->model, rays, bench->config.rays);
    reference_step_forward(reference, params, false, 0);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        const double rgb[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "rendered", ray, rgb[c], reference->colours[ray][c], COLOUR_TOLERANCE);
        check_value(bench->where, "transmittance", ray, colours[ray].w, reference->left[ray], COLOUR_TOLERANCE);
    }
}

TEST_GROUP(NULL, test_gpu_close)
