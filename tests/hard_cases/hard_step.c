#include "hard_cases/hard_step.h"
#include "support/cmocka_test.h"

#include <float.h>

#include "base/memory.h"
#include "gpu/compute.h"

// The bounds of tests/gradients and tests/kernels, where their reasons are given: positions are good to 2e-7 box edges,
// which fine levels magnify; the device's exp2 and log2 enter the bias correction.
static const double WEIGHT_TOLERANCE = 0x1p-7;   // share of the matrix's largest: two bfloats, each good to 2^-8
static const double SKY_TOLERANCE = 1e-4;        // share of the largest gradient
static const double VISIBILITY_TOLERANCE = 5e-4; // likewise
static const double GRID_TOLERANCE = 2e-3; // share of the level's largest, or of 4096 quanta: 8 may round the other way
static const double LEAST_GRADIENT =
    1e-30; // below, products are denormal floats on their way, which the device takes for 0
static const double LEAST_GRID_QUANTA = 4096.0;
static const double COLOUR_TOLERANCE = 1e-5;
static const double LOSS_TOLERANCE = 1e-5; // share of the sum over rays, plus COLOUR_TOLERANCE for a loss near 0
static const double GATE_TOLERANCE = 1e-3; // share of a hidden unit's value, when that is above 1
static const double STEP_TOLERANCE = 2e-4; // share of the move and of 2^-8 of the param: rounding is well below that
static const double MOMENT_TOLERANCE = 1e-6;
static const double LEAST_MOMENT = 1e-30; // likewise

struct hard_state hard_state_read(struct step_bench *bench) {
    vw_float4 *scalars = step_bench_read(bench, bench->scalars);
    struct vw_step_state *flags = step_bench_read(bench, bench->field.step_state);
    struct hard_state state = {.grid = grid_read(bench),
                               .weight_moments = step_bench_read(bench, bench->step.weight_moments),
                               .scalars = scalars[0],
                               .skipped = flags->skipped != 0};
    return state;
}

void hard_write_pixels(struct step_bench *bench) {
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

static void compare_losses(struct hard_finding *finding, struct step_bench *bench,
                           const struct reference_step *reference) {
    float *losses = step_bench_read(bench, bench->step.ray_loss);
    vw_float4 *scalars = step_bench_read(bench, bench->scalars);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++)
        hard_compare(finding, "loss of a ray", ray, losses[ray], reference->losses[ray], 1.0, COLOUR_TOLERANCE);
    hard_compare(finding, "loss", 0, (double)scalars->x + scalars->y, reference->loss,
                 reference->loss + COLOUR_TOLERANCE / LOSS_TOLERANCE, LOSS_TOLERANCE);
    hard_equal(finding, "flag", 0, scalars->z, 0.0);
}

static void compare_weight_gradients(struct hard_finding *finding, const struct step_bench *bench,
                                     struct reference_step *reference, const float *d_weights) {
    const struct vw_specialization *s = &bench->model.specialization;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, &reference->d_weights, matrices);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++) {
        uint32_t count = matrices[m].out * matrices[m].in;
        double scale = fmax(largest(matrices[m].values, count), LEAST_GRADIENT);
        for (uint32_t i = 0; i < count; i++)
            hard_compare(finding, "weight gradient", i,
                         d_weights[reference_block_index(s, m, i / matrices[m].in, i % matrices[m].in)],
                         matrices[m].values[i], scale, WEIGHT_TOLERANCE);
    }
}

static void compare_sky_gradients(struct hard_finding *finding, const struct step_bench *bench,
                                  const struct reference_step *reference, const float *d_weights) {
    const float *d_sky = d_weights + 4 * (size_t)bench->model.weight_columns;
    double scale = fmax(largest(reference->d_sky[0], 3 * VW_SKY_COLUMNS), LEAST_GRADIENT);
    for (uint32_t i = 0; i < 3 * VW_SKY_COLUMNS && bench->model.ranges[VW_SLOT_SKY].size_bytes; i++)
        hard_compare(finding, "sky gradient", i, d_sky[i / 3 * 4 + i % 3], reference->d_sky[i / 3][i % 3], scale,
                     SKY_TOLERANCE);
}

static void compare_visibility_gradients(struct hard_finding *finding, const struct step_bench *bench,
                                         const struct reference_step *reference, const float *d_weights) {
    const float *d_network = d_weights + 4 * (size_t)bench->model.specialization.visibility_column;
    const struct vw_specialization *s = &bench->model.specialization;
    const double *expected = s->effect_uncertainty ? reference->d_uncertainty : reference->d_visibility;
    uint32_t count = s->effect_uncertainty ? REFERENCE_UNCERTAINTY : s->effect_visibility ? REFERENCE_VISIBILITY : 0;
    double scale = fmax(largest(expected, count), LEAST_GRADIENT);
    for (uint32_t i = 0; i < count; i++)
        hard_compare(finding, "gradient by weights of rays", i, d_network[i], expected[i], scale, VISIBILITY_TOLERANCE);
}

static void compare_grid_gradients(struct hard_finding *finding, const struct step_bench *bench,
                                   const struct reference_step *reference, const int64_t *quanta) {
    const struct vw_specialization *s = &bench->model.specialization;
    size_t features = 2 * (size_t)bench->model.pair_count;
    int64_t *expected = test_allocate(features, sizeof *expected);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        reference_grid_scatter_fixed(s, reference->samples[i].position, reference->d_samples[i].encoding, expected);
    for (uint32_t level = 0; level < s->levels; level++) {
        size_t first = 2 * (size_t)s->first_pair[level],
               end = level + 1 < s->levels ? 2 * (size_t)s->first_pair[level + 1] : features;
        double scale = fmax(largest(reference->d_grid + first, end - first) / s->gradient_quantum, LEAST_GRID_QUANTA);
        for (size_t i = first; i < end; i++)
            hard_compare(finding, "grid gradient", i, (double)quanta[i], (double)expected[i], scale, GRID_TOLERANCE);
    }
}

static void refuse_kinks(struct hard_finding *finding, const struct step_bench *bench,
                         const struct reference_step *reference) {
    for (uint32_t ray = 0; ray < reference->ray_count && bench->config.loss == VW_LOSS_L1; ray++)
        for (int c = 0; c < 3; c++)
            hard_require(finding,
                         reference->rays[ray].weight == 0.0 || reference->errors[ray][c] == 0.0 ||
                             fabs(reference->errors[ray][c]) > 1e-5,
                         "no ray stands at the kink of the loss (else choose another seed)");
}

// Runs the reference's step from the device's rays and params, with the device's decisions at ReLUs.
static struct reference_step *run_reference(struct hard_finding *finding, struct step_bench *bench, uint64_t number) {
    vw_uint4 *relu = step_bench_read_active(bench);
    float *params = step_bench_read(bench, bench->field.params);
    struct reference_params *reference_params = reference_params_create(&bench->model, params);
    struct reference_step *reference = step_bench_reference(bench);
    double sizes = 1.0;
    reference->view = bench->view;
    reference_step_forward(reference, reference_params, true, number);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        sizes = fmax(sizes, fmax(largest(reference->samples[i].before1, bench->config.width),
                                 largest(reference->samples[i].before2, bench->config.width)));
    hard_equal(finding, "units on the wrong side of 0", 0,
               (double)reference_adopt_gates(reference, relu, GATE_TOLERANCE * sizes), 0.0);
    refuse_kinks(finding, bench, reference);
    reference_step_backward(reference, reference_params);
    return reference;
}

struct hard_gradients hard_take_gradients(struct step_bench *bench, uint64_t number) {
    step_bench_gradients(bench, number);
    uint64_t *words = step_bench_read(bench, vw_volume_step_of(&bench->step)->d_grid);
    struct hard_gradients gradients = {step_bench_read(bench, bench->step.d_weights),
                                       test_allocate(2 * (size_t)bench->model.pair_count, sizeof *gradients.quanta)};
    reference_unpack_grid(&bench->model, words, gradients.quanta);
    memset(words, 0, vw_buffer_size_bytes(vw_volume_step_of(&bench->step)->d_grid));
    step_bench_write(bench, vw_volume_step_of(&bench->step)->d_grid, words);
    return gradients;
}

struct reference_step *hard_check_gradients(struct hard_finding *finding, struct step_bench *bench, uint64_t number,
                                            const struct hard_gradients *gradients) {
    struct reference_step *reference = run_reference(finding, bench, number);
    compare_losses(finding, bench, reference);
    compare_weight_gradients(finding, bench, reference, gradients->weights);
    compare_sky_gradients(finding, bench, reference, gradients->weights);
    compare_visibility_gradients(finding, bench, reference, gradients->weights);
    compare_grid_gradients(finding, bench, reference, gradients->quanta);
    return reference;
}

// ---- Updates --------------------------------------------------------------------------------------------------------

// Params that the device moves together, or not at all: a column of weights, a pair of features.
struct group {
    const char *quantity;
    uint64_t index, visits;
    uint32_t count;
    const float *param, *moment1, *moment2;   // before; moment1 NULL without momentum
    const float *param_after, *moment2_after; // after
    double gradient[4];                       // gradient of the mean loss
};

static const double NEAR_THE_LIMIT = 1e37; // value near the largest float: beyond it, an update may be given up

static void check_group(struct hard_finding *finding, const struct vw_specialization *s, const struct group *group,
                        bool flagged) {
    size_t bytes = group->count * sizeof(float);
    bool kept =
             !memcmp(group->param, group->param_after, bytes) && !memcmp(group->moment2, group->moment2_after, bytes),
         too_far = false;
    double expected[4], scale[4], moment2[4];
    for (uint32_t i = 0; i < group->count; i++) {
        double moment1 = group->moment1 ? group->moment1[i] : 0.0;
        moment2[i] = group->moment2[i];
        double moved = reference_adam(s, group->gradient[i], group->visits, &moment1, &moment2[i]);
        expected[i] = group->param[i] - moved;
        scale[i] = fabs(moved) + 0x1p-8 * fabs(expected[i]);
        double direction = s->momentum ? moment1 : group->gradient[i],
               square = moment2[i] / (1.0 - pow(s->beta2, (double)group->visits));
        too_far |= !(fmax(fmax(fabs(expected[i]), square), s->learning_rate * fabs(direction)) < NEAR_THE_LIMIT);
    }
    if (flagged && kept && too_far) return;
    for (uint32_t i = 0; i < group->count; i++) {
        hard_compare(finding, group->quantity, group->index + i, group->param_after[i], expected[i], scale[i],
                     STEP_TOLERANCE);
        if (s->optimizer != OPTIMIZER_SGD)
            hard_compare(finding, "second moment", group->index + i, group->moment2_after[i], moment2[i],
                         fmax(moment2[i], LEAST_MOMENT), MOMENT_TOLERANCE);
    }
}

static void check_weights(struct hard_finding *finding, const struct step_bench *bench, uint64_t number,
                          const struct hard_gradients *gradients, const struct hard_state *before,
                          const struct hard_state *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint32_t count = 4 * bench->model.moved_columns,
             first = (uint32_t)(bench->model.weights.offset_bytes / sizeof(float));
    for (uint32_t i = 0; i < count; i += 4) {
        struct group column = {.quantity = "updated weight",
                               .index = i,
                               .visits = number,
                               .count = 4,
                               .param = before->grid.grid + first + i,
                               .param_after = after->grid.grid + first + i,
                               .moment1 = s->momentum ? before->weight_moments + i : NULL,
                               .moment2 = before->weight_moments + count + i,
                               .moment2_after = after->weight_moments + count + i};
        for (uint32_t k = 0; k < 4; k++) column.gradient[k] = (double)gradients->weights[i + k] * s->inverse_rays;
        check_group(finding, s, &column, after->scalars.z != 0.0f);
    }
}

static void check_grid(struct hard_finding *finding, const struct step_bench *bench, uint64_t number,
                       const struct hard_gradients *gradients, const struct hard_state *before,
                       const struct hard_state *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    bool dense = s->optimizer == OPTIMIZER_DENSE_ADAM;
    for (uint64_t pair = 0; pair < bench->model.pair_count; pair++) {
        uint64_t i = 2 * pair;
        if (!dense && gradients->quanta[i] == 0 && gradients->quanta[i + 1] == 0) { // silent: not a bit may change
            hard_same_bits(finding, "silent entry", after->grid.grid + i, before->grid.grid + i, 8);
            hard_same_bits(finding, "silent moment", after->grid.moment2 + i, before->grid.moment2 + i, 8);
            continue;
        }
        struct group features = {.quantity = "updated entry",
                                 .index = i,
                                 .visits = dense ? number : (uint64_t)before->grid.visits[pair] + 1,
                                 .count = 2,
                                 .param = before->grid.grid + i,
                                 .param_after = after->grid.grid + i,
                                 .moment1 = before->grid.moment1 ? before->grid.moment1 + i : NULL,
                                 .moment2 = before->grid.moment2 + i,
                                 .moment2_after = after->grid.moment2 + i};
        for (uint32_t k = 0; k < 2; k++)
            features.gradient[k] = (double)gradients->quanta[i + k] * s->gradient_quantum * s->inverse_rays;
        check_group(finding, s, &features, after->scalars.z != 0.0f);
    }
}

void hard_check_update(struct hard_finding *finding, const struct step_bench *bench, uint64_t number,
                       const struct hard_gradients *gradients, const struct hard_state *before,
                       const struct hard_state *after) {
    for (size_t i = 0; i < bench->model.param_bytes / sizeof(float); i++)
        hard_require(finding, isfinite(after->grid.grid[i]), "every param is finite");
    if (after->skipped) {
        hard_require(finding, after->scalars.z != 0.0f, "a step that is not finite is flagged");
        hard_same_bits(finding, "params of a skipped step", after->grid.grid, before->grid.grid,
                       bench->model.param_bytes);
        return;
    }
    check_weights(finding, bench, number, gradients, before, after);
    check_grid(finding, bench, number, gradients, before, after);
}

struct reference_step *hard_check_step(struct hard_finding *finding, struct step_bench *bench, uint64_t number) {
    struct hard_gradients gradients = hard_take_gradients(bench, number);
    struct reference_step *reference = hard_check_gradients(finding, bench, number, &gradients);
    struct hard_state before = hard_state_read(bench);
    step_bench_step(bench, number);
    struct hard_state after = hard_state_read(bench);
    hard_equal(finding, "flag", 0, after.scalars.z, 0.0);
    hard_same_bits(finding, "loss of the same step again", &after.scalars, &before.scalars, 2 * sizeof(float));
    hard_check_update(finding, bench, number, &gradients, &before, &after);
    return reference;
}

void hard_check_infinite_loss(struct hard_finding *finding, struct step_bench *bench) {
    bench->pixels[3].rgba.x = 1e30f;
    hard_write_pixels(bench);
    struct hard_gradients gradients = hard_take_gradients(bench, 1);
    struct hard_state before = hard_state_read(bench);
    step_bench_step(bench, 1);
    struct hard_state after = hard_state_read(bench);
    hard_require(finding, after.skipped, "the step is skipped");
    hard_check_update(finding, bench, 1, &gradients, &before, &after);
}

// ---- Rendering ------------------------------------------------------------------------------------------------------

void hard_check_rendering(struct hard_finding *finding, struct step_bench *bench) {
    struct vw_evaluator *evaluator = step_bench_evaluate(bench);
    struct vw_ray *rays = step_bench_read(bench, evaluator->rays);
    vw_float4 *colours = step_bench_read(bench, evaluator->colours);
    float *params = step_bench_read(bench, bench->field.params);
    struct reference_params *reference_params = reference_params_create(&bench->model, params);
    struct reference_step *reference = reference_step_create(&bench->model, rays, bench->config.rays);
    reference->sample_places = step_bench_sample_places(bench, vw_volume_evaluation_of(evaluator)->places);
    reference_step_forward(reference, reference_params, false, 0);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        const double rgb[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        for (int c = 0; c < 3; c++)
            hard_compare(finding, "rendered colour", ray, rgb[c], reference->colours[ray][c], 1.0, COLOUR_TOLERANCE);
        hard_compare(finding, "light that is left", ray, colours[ray].w, reference->left[ray], 1.0, COLOUR_TOLERANCE);
    }
}
