#include "hard_cases/hard_step.h"
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"

// The bounds of tests/gradients and tests/kernels, where their reasons are given: positions are good to 2e-7 box edges,
// which fine levels magnify; the device's exp2 and log2 enter the bias correction.
static const double GRID_TOLERANCE = 2e-3; // share of the level's largest, or of 4096 quanta: 8 may round the other way
static const double LEAST_GRADIENT =
    1e-30; // below, products are denormal floats on their way, which the device takes for 0
static const double LEAST_GRID_QUANTA = 4096.0;
static const double COLOUR_TOLERANCE = 1e-5;
static const double FINE_COLOUR_TOLERANCE = 5e-5; // the encoding in the finest of 16 levels is good to 4e-4 of entries
static const double LOSS_TOLERANCE = 1e-5;        // share of the sum over rays, plus COLOUR_TOLERANCE for a loss near 0
static const double GATE_TOLERANCE = 1e-3;        // share of a hidden unit's value, when that is above 1
static const double STEP_TOLERANCE = 2e-4; // share of the move and of 2^-8 of the param: rounding is well below that
static const double MOMENT_TOLERANCE = 1e-6;
static const double LEAST_MOMENT = 1e-30; // likewise
static const double OWN_TOLERANCE = 0.02; // share of the longest move: a gradient near 0 is a difference of large ones

// Numbers that an effect moves in a pass of its own: those of the step's photo, with their visits, or all.
static const struct own_update {
    const char *range; // its name in the list of step_bench_ranges()
    uint32_t params, moments;
    bool of_photo;
    double ridge;
} own_updates[] = {{"code weights", VW_SLOT_CODE_WEIGHTS, VW_SLOT_CODE_WEIGHT_MOMENTS, false, 0.0},
                   {"code", VW_SLOT_CODES, VW_SLOT_CODE_MOMENTS, true, 1.0},
                   {"code of visibility", VW_SLOT_VISIBILITY_CODES, VW_SLOT_VISIBILITY_MOMENTS, true, 0.0}};

struct hard_state hard_state_read(struct step_bench *bench) {
    vw_float4 *scalars = test_read(bench->scalars);
    struct vw_step_state *flags = test_read(bench->field.step_state);
    struct hard_state state = {.grid = grid_read(bench),
                               .weight_moments = test_read(bench->step.weight_moments),
                               .scalars = scalars[0],
                               .skipped = flags->skipped != 0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(own_updates); i++) {
        struct vw_buffer *moments = bench->step.effect_buffers[own_updates[i].moments];
        if (moments) state.effect_moments[own_updates[i].moments] = test_read(moments);
    }
    return state;
}

void hard_write_pixels(struct step_bench *bench) {
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
}

void hard_set_density(struct step_bench *bench, float weight) {
    float *weights = bench->params + bench->model.weights.offset_bytes / sizeof(float);
    for (uint32_t k = 0; k < bench->config.width; k++)
        weights[reference_block_index(&bench->model.specialization, 1, 0, k)] = weight;
    step_bench_write_params(bench);
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

static void compare_losses(struct hard_finding *finding, struct step_bench *bench,
                           const struct reference_step *reference) {
    float *losses = test_read(bench->step.ray_loss);
    vw_float4 *scalars = test_read(bench->scalars);
    for (uint32_t ray = 0; ray < reference->ray_count; ray++)
        hard_compare(finding, "loss of a ray", ray, losses[ray], reference->losses[ray], 1.0, COLOUR_TOLERANCE);
    hard_compare(finding, "loss", 0, (double)scalars->x + scalars->y, reference->loss,
                 reference->loss + COLOUR_TOLERANCE / LOSS_TOLERANCE, LOSS_TOLERANCE);
    hard_equal(finding, "flag", 0, scalars->z, 0.0);
}

// Compares the gradients of all ranges but the grid.
static void compare_ranges(struct hard_finding *finding, const struct step_bench *bench,
                           struct reference_step *reference, struct reference_params *params, const float *d_weights) {
    struct step_range ranges[STEP_RANGES_MAX];
    uint32_t count = step_bench_ranges(bench, reference, params, d_weights, ranges);
    for (uint32_t r = 0; r < count; r++) {
        double scale = fmax(largest(ranges[r].expected, ranges[r].count), LEAST_GRADIENT);
        for (size_t i = 0; i < ranges[r].count; i++)
            hard_compare(finding, ranges[r].name, i, ranges[r].gradient[i], ranges[r].expected[i], scale,
                         ranges[r].tolerance);
    }
}

static void compare_grid_gradients(struct hard_finding *finding, const struct step_bench *bench,
                                   const struct reference_step *reference, const int64_t *quanta) {
    const struct vw_specialization *s = &bench->model.specialization;
    size_t features = 2 * (size_t)bench->layout->pair_count;
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
static struct reference_step *run_reference(struct hard_finding *finding, struct step_bench *bench, uint64_t number,
                                            struct reference_params *params) {
    vw_uint4 *relu = step_bench_read_active(bench);
    struct reference_step *reference = step_bench_reference(bench);
    double sizes = 1.0;
    reference_step_forward(reference, params, true, number);
    for (uint32_t i = 0; i < bench->padded_samples; i++)
        sizes = fmax(sizes, fmax(largest(reference->samples[i].before1, bench->config.width),
                                 largest(reference->samples[i].before2, bench->config.width)));
    hard_equal(finding, "units on the wrong side of 0", 0,
               (double)reference_adopt_gates(reference, relu, GATE_TOLERANCE * sizes), 0.0);
    refuse_kinks(finding, bench, reference);
    reference_step_backward(reference, params);
    return reference;
}

struct hard_gradients hard_take_gradients(struct step_bench *bench, uint64_t number) {
    step_bench_gradients(bench, number);
    uint64_t *words = test_read(bench->volume->d_grid);
    struct hard_gradients gradients = {test_read(bench->step.d_weights),
                                       test_allocate(2 * (size_t)bench->layout->pair_count, sizeof *gradients.quanta)};
    reference_unpack_grid(&bench->model, words, gradients.quanta);
    memset(words, 0, vw_buffer_size_bytes(bench->volume->d_grid));
    test_write(bench->volume->d_grid, words);
    return gradients;
}

static struct reference_step *check_gradients(struct hard_finding *finding, struct step_bench *bench, uint64_t number,
                                              const struct hard_gradients *gradients) {
    struct reference_params *params = reference_params_create(&bench->model, test_read(bench->field.params));
    struct reference_step *reference = run_reference(finding, bench, number, params);
    compare_losses(finding, bench, reference);
    compare_ranges(finding, bench, reference, params, gradients->weights);
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
    for (uint64_t pair = 0; pair < bench->layout->pair_count; pair++) {
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

// Checks how an effect moved its own numbers by the device's gradient, a share of the longest move; those of other
// photos must stay, and their moments.
static void check_own_update(struct hard_finding *finding, const struct step_bench *bench, uint64_t number,
                             const struct own_update *update, const struct step_range *range,
                             const struct hard_state *before, const struct hard_state *after) {
    const struct vw_specialization *s = &bench->model.specialization;
    const struct vw_param_range *params = &bench->model.ranges[update->params];
    size_t count = range->count, view = update->of_photo ? bench->view : 0, stride = 2 * count + update->of_photo,
           all = vw_buffer_size_bytes(bench->step.effect_buffers[update->moments]),
           first = params->offset_bytes / sizeof(float);
    float *own = before->effect_moments[update->moments] + stride * view,
          *value = before->grid.grid + first + count * view,
          *own_after = after->effect_moments[update->moments] + stride * view,
          *value_after = after->grid.grid + first + count * view;
    double *moves = test_allocate(count, sizeof *moves);
    uint64_t visits = number;
    if (update->of_photo) visits = 1 + (uint64_t)((const uint32_t *)own)[2 * count];
    for (size_t k = 0; k < count; k++) {
        double moment1 = own[k], moment2 = own[count + k],
               gradient =
                   (double)range->gradient[k] * s->inverse_rays + update->ridge * reference_photo_ridge * value[k];
        moves[k] = (update->of_photo ? reference_photo_rate(visits) : 1.0) *
                   reference_adam(s, gradient, visits, &moment1, &moment2);
    }
    double scale = largest(moves, count);
    for (size_t k = 0; k < count; k++) {
        hard_compare(finding, range->name, k, value_after[k], value[k] - moves[k],
                     scale + 0x1p-12 * fabs((double)value[k]) + LEAST_GRADIENT, OWN_TOLERANCE);
        value_after[k] = value[k];
    }
    hard_same_bits(finding, "codes of other photos", after->grid.grid + first, before->grid.grid + first,
                   params->size_bytes);
    if (!update->of_photo) return;
    hard_equal(finding, "visits", view, ((const uint32_t *)own_after)[2 * count], (double)visits);
    memcpy(own_after, own, stride * sizeof *own);
    hard_same_bits(finding, "moments of other photos", after->effect_moments[update->moments],
                   before->effect_moments[update->moments], all);
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
    struct reference_params *params = reference_params_create(&bench->model, test_read(bench->field.params));
    struct reference_step *reference = check_gradients(finding, bench, number, &gradients);
    struct step_range ranges[STEP_RANGES_MAX];
    uint32_t count = step_bench_ranges(bench, reference, params, gradients.weights, ranges);
    struct hard_state before = hard_state_read(bench);
    step_bench_step(bench, number);
    struct hard_state after = hard_state_read(bench);
    hard_equal(finding, "flag", 0, after.scalars.z, 0.0);
    hard_same_bits(finding, "loss of the same step again", &after.scalars, &before.scalars, 2 * sizeof(float));
    hard_check_update(finding, bench, number, &gradients, &before, &after);
    for (uint32_t r = 0; r < count; r++)
        for (size_t i = 0; i < VW_ARRAY_COUNT(own_updates); i++)
            if (!strcmp(ranges[r].name, own_updates[i].range))
                check_own_update(finding, bench, number, &own_updates[i], &ranges[r], &before, &after);
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
    struct vw_ray *rays = test_read(evaluator->rays);
    vw_float4 *colours = test_read(evaluator->colours);
    float *params = test_read(bench->field.params);
    struct reference_params *reference_params = reference_params_create(&bench->model, params);
    struct reference_step *reference = reference_step_create(&bench->model, rays, bench->config.rays);
    reference->sample_places = step_bench_sample_places(vw_volume_evaluation_of(evaluator)->places);
    reference_step_forward(reference, reference_params, false, 0);
    double tolerance = bench->config.levels > 8 ? FINE_COLOUR_TOLERANCE : COLOUR_TOLERANCE;
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        const double rgb[3] = {colours[ray].x, colours[ray].y, colours[ray].z};
        for (int c = 0; c < 3; c++)
            hard_compare(finding, "rendered colour", ray, rgb[c], reference->colours[ray][c], 1.0, tolerance);
        hard_compare(finding, "light that is left", ray, colours[ray].w, reference->left[ray], 1.0, tolerance);
    }
}
