// A whole step on the device against the reference's whole step: loss, colours and all gradients from the rays on, and
// the params that gradient descent makes of them. The kernel tests look at one pass each; here an error may hide
// nowhere between them.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"
#include "support/gpu_fixture.h"

static const double PHOTO_TOLERANCE = 1e-4; // gain and bias: colours are good to COLOUR_TOLERANCE, the fit is stiff
static const double WEIGHT_TOLERANCE = 0x1p-7;
static const double COLOUR_TOLERANCE = 5e-5; // an encoding in the finest of 16 levels is good to 4e-4 of its entries
static const double SLOPE_STEP = 1e-6;
// Kinks within the step, the third derivative, the rounding of the grid's gradient to quanta (2e-3), and that of the
// constant input of the colour network to a bfloat (3e-3).
static const double SLOPE_TOLERANCE = 5e-3;
static const uint64_t STEP = 259;

static bool ordinary(const struct step_case *setup) {
    return setup->weight_scale <= 1.0f;
} // others amplify rounding beyond use here

// Checks what fit_photo will find of every ray.
static void check_rendered(struct step_bench *bench, const struct reference_step *reference) {
    if (!bench->step.effect_buffers[VW_SLOT_RENDERED]) return;
    vw_float4 *rendered = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_RENDERED]);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++) {
        for (int c = 0; c < 3; c++)
            check_value(bench->where, "rendered in the step", ray, (&rendered[ray].x)[c], reference->colours[ray][c],
                        COLOUR_TOLERANCE);
        double weight = reference->rays[ray].weight * reference->visible[ray]; // 1 without such an effect
        check_value(bench->where, "weight in the step", ray, rendered[ray].w, weight, COLOUR_TOLERANCE);
    }
}

TEST_CASES(gradients_match_the_reference, i, step_case_count) {
    if (!ordinary(&step_cases[i])) return;
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    const struct vw_specialization *s = &bench->model.specialization;
    struct hard_finding finding = {.where = bench->where};
    const struct hard_gradients gradients = hard_take_gradients(bench, STEP);
    struct reference_step *reference = hard_check_gradients(&finding, bench, STEP, &gradients);
    check_rendered(bench, reference);
    for (uint32_t level = 0; level < s->levels; level++) {
        size_t first = 2 * (size_t)s->first_pair[level],
               end = 2 * (size_t)(level + 1 < s->levels ? s->first_pair[level + 1] : bench->model.pair_count);
        assert_true(largest(reference->d_grid + first, end - first) > 0.0);
    }
    if (s->effect_sky) assert_true(largest(reference->d_sky[0], 3 * VW_SKY_COLUMNS) > 0.0);
    if (s->effect_visibility) assert_true(largest(reference->d_visibility, REFERENCE_VISIBILITY) > 0.0);
    if (s->effect_uncertainty) assert_true(largest(reference->d_uncertainty, REFERENCE_UNCERTAINTY) > 0.0);
}

// ---- The slope of the loss ------------------------------------------------------------------------------------------

struct sloping { // a step of the reference, and the params that move
    struct reference_step *reference;
    struct reference_params *params;
};

static double loss_of(void *of) {
    const struct sloping *step = of;
    reference_step_forward(step->reference, step->params, true, STEP);
    return step->reference->loss;
}

static void check_range(const struct slope_check *check, const char *range, double *values, const float *gradient,
                        size_t count) {
    assert_true(check_slope(check, range, values, gradient, count) > 0.0);
}

// Checks the slopes by the photo's code and by the code weights by the device's gradients of the weights of the colour
// network's input 0.
static void check_code_slopes(struct step_bench *bench, const struct slope_check *check,
                              struct reference_params *params, const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_photo *photo = params->photos ? &params->photos[bench->view] : NULL;
    if (!s->effect_appearance_code) return;
    uint32_t width = 4 * s->width4, weights = width * REFERENCE_CODE;
    double d_shift[REFERENCE_WIDTH_MAX], exact[REFERENCE_CODE * (REFERENCE_WIDTH_MAX + 1)];
    float d_code[REFERENCE_CODE * (REFERENCE_WIDTH_MAX + 1)]; // the code weights come first, then the code
    for (uint32_t i = 0; i < width; i++) d_shift[i] = d_weights[reference_block_index(s, 2, i, 0)];
    reference_mix_code_gradient(width, params->code_weights, photo->code, d_shift, exact, exact + weights);
    for (uint32_t i = 0; i < weights + REFERENCE_CODE; i++) d_code[i] = (float)exact[i];
    check_range(check, "code weights", params->code_weights, d_code, weights);
    check_range(check, "code", photo->code, d_code + weights, REFERENCE_CODE);
}

static void check_slopes(struct step_bench *bench, const struct slope_check *check, struct reference_params *params) {
    const struct vw_specialization *s = &bench->model.specialization;
    size_t features = 2 * (size_t)bench->model.pair_count;
    float *d_weights = step_bench_read(bench, bench->step.d_weights),
          *gradient = test_allocate(features + REFERENCE_WIDTH_MAX * REFERENCE_ENCODING_MAX, sizeof *gradient);
    uint64_t *words = step_bench_read(bench, vw_volume_step_of(&bench->step)->d_grid);
    int64_t *quanta = test_allocate(features, sizeof *quanta);
    struct reference_matrix values[REFERENCE_MATRICES];
    reference_matrices(s, &params->weights, values);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
        for (uint32_t i = 0; i < values[m].out * values[m].in; i++)
            gradient[i] = d_weights[reference_block_index(s, m, i / values[m].in, i % values[m].in)];
        check_range(check, values[m].name, values[m].values, gradient, values[m].out * values[m].in);
    }
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS && s->effect_sky; i++)
        gradient[i] = d_weights[4 * (bench->model.weight_columns + i / 3) + i % 3];
    if (s->effect_sky) check_range(check, "sky", params->sky[0], gradient, 3 * VW_SKY_COLUMNS);
    if (s->effect_visibility)
        check_range(check, "visibility", params->visibility, d_weights + 4 * (size_t)s->visibility_column,
                    REFERENCE_VISIBILITY);
    if (s->effect_uncertainty)
        check_range(check, "uncertainty", params->uncertainty, d_weights + 4 * (size_t)s->visibility_column,
                    REFERENCE_UNCERTAINTY);
    reference_unpack_grid(&bench->model, words, quanta);
    for (size_t i = 0; i < features; i++) gradient[i] = (float)((double)quanta[i] * s->gradient_quantum);
    check_range(check, "grid", params->grid, gradient, features);
    check_code_slopes(bench, check, params, d_weights);
}

// Compares the device's gradients with differences of the reference's loss, without the reference's own gradient. The
// quick tests take every second case.
TEST_CASES(the_loss_changes_as_the_gradients_say, i, step_case_count) {
    if (!ordinary(&step_cases[i]) || (i % 2 == 0 && !test_is_full())) return;
    struct step_bench *bench = step_bench_open(&step_cases[i]);
    step_bench_gradients(bench, STEP);
    struct sloping step = {step_bench_reference(bench), reference_params_create(&bench->model, bench->params)};
    const struct slope_check check = {bench->where, loss_of, &step, SLOPE_STEP, SLOPE_TOLERANCE, 0.0};
    check_slopes(bench, &check, step.params);
}

// ---- Descent and rendering ------------------------------------------------------------------------------------------

// Fits the step's photo to its rays and those of earlier steps, whose sums are kept, and checks all photos' numbers.
static void check_photos_fitted(struct step_bench *bench, const struct reference_step *reference,
                                const struct reference_params *before, const float *after,
                                struct reference_photo_sums *sums) {
    if (!bench->model.specialization.effect_appearance) return;
    struct reference_photo *photo = &before->photos[bench->view];
    reference_photo_sums_fade(sums);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++) {
        const vw_float4 rgba = bench->pixels[ray < bench->config.rays ? ray : bench->config.rays - 1].rgba;
        const double shown[3] = {rgba.x, rgba.y, rgba.z};
        reference_photo_sums_add(sums, reference->rays[ray].weight, reference->colours[ray], shown,
                                 reference->rays[ray].target);
    }
    reference_fit_photo(sums, photo);
    const uint32_t count = reference_photo_count(&bench->model);
    const struct vw_photo_sums *fits = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_PHOTO_SUMS]);
    for (uint64_t c = 0; c < 3; c++) {
        check_value(bench->where, "fitted gain", c, (&fits[bench->view].gain.x)[c], photo->gain[c], PHOTO_TOLERANCE);
        check_value(bench->where, "fitted bias", c, (&fits[bench->view].bias.x)[c], photo->bias[c], PHOTO_TOLERANCE);
    }
    *photo = reference_photo_of_fits(fits, count, bench->view);
    for (uint32_t view = 0; view < count; view++) {
        struct reference_photo device = reference_photo_of(&bench->model, after, view);
        double tolerance = view == bench->view ? PHOTO_TOLERANCE : 0.0;
        for (uint64_t c = 0; c < 3; c++) {
            check_value(bench->where, "gain", c, device.gain[c], before->photos[view].gain[c], tolerance);
            check_value(bench->where, "bias", c, device.bias[c], before->photos[view].bias[c], tolerance);
        }
    }
}

// Checks that the code of the step's photo and the code weights moved by their own rates; other codes stay.
static void check_codes_moved(const struct step_bench *bench, uint64_t number, const struct reference_step *reference,
                              const struct reference_params *before, const float *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    for (uint32_t view = 0; view < reference_photo_count(&bench->model); view++) {
        struct reference_photo device = reference_photo_of(&bench->model, after, view), expected = before->photos[view];
        double mean = view == bench->view ? 1.0 / bench->config.rays : 0.0,
               ridge = view == bench->view ? reference_photo_ridge : 0.0,
               rate = s->learning_rate * reference_photo_rate(number);
        double largest_move = rate * mean * largest(reference->d_code, REFERENCE_CODE);
        for (uint64_t k = 0; k < REFERENCE_CODE && s->effect_appearance_code; k++)
            check_value(bench->where, "code moved", k, device.code[k],
                        expected.code[k] - rate * (mean * reference->d_code[k] + ridge * expected.code[k]),
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

// Takes steps 1 to 3 of plain gradient descent: each moves the params by the reference's mean gradient.
static void descend(bool photos) {
    const struct step_case descent = {.name = photos ? "gradient descent, photos of their own" : "gradient descent",
                                      .seed = 131,
                                      .rays = 40,
                                      .loss = VW_LOSS_L2,
                                      .optimizer = VW_OPTIMIZER_SGD,
                                      .learning_rate = 0.25,
                                      .levels = 4,
                                      .width = 16,
                                      .effects = photos ? "sky,appearance,appearance_code" : "sky"};
    struct step_bench *bench = step_bench_open(&descent);
    struct hard_finding finding = {.where = bench->where};
    struct reference_photo_sums sums = {0};
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].view = bench->view; // as in every real step
    hard_write_pixels(bench);
    for (uint64_t number = 1; number <= 3; number++) {
        float *before = step_bench_read(bench, bench->field.params);
        struct reference_params *params = reference_params_create(&bench->model, before);
        struct reference_step *reference = hard_check_step(&finding, bench, number);
        float *after = step_bench_read(bench, bench->field.params);
        check_codes_moved(bench, number, reference, params, after);
        check_photos_fitted(bench, reference, params, after, &sums);
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
