// Hard cases of the effects visibility and uncertainty, which weigh rays by a network: nothing and all that counts,
// photos of which no pixel does, losses beyond the floats, step numbers past 2^31, and features that say nothing or too
// much. Whole steps held against the reference.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_step.h"

static const struct step_case visibility = {"visibility", .seed = 391, HARD_STEP, .effects = "visibility"},
                              uncertainty = {"uncertainty", .seed = 393, HARD_STEP, .effects = "uncertainty"};

// Opens a bench whose pixels count as the logistic function of about `logit` says; `size`: that of their features,
// where they have any.
static struct step_bench *open_with(const struct step_case *setup, float size, float logit) {
    struct step_bench *bench = step_bench_open(setup);
    struct vw_buffer *features = bench->step.effect_buffers[VW_SLOT_FEATURES];
    uint64_t offset_bytes = features ? vw_uncertainty_network(&bench->model).offset_bytes
                                     : vw_visibility_network(&bench->model).offset_bytes;
    uint32_t column = features ? UNCERTAINTY_LOGIT : VISIBILITY_LOGIT;
    bench->params[offset_bytes / 4 + 4 * (column + VISIBILITY4)] = logit;
    step_bench_write_params(bench);
    for (uint32_t i = 0; features && i < bench->config.rays * REFERENCE_FEATURES; i++)
        if (i % REFERENCE_FEATURES + 1 < REFERENCE_FEATURES) ((float *)vw_buffer_map(features))[i] *= size;
    return bench;
}

// Reads, for every ray, how much it counts, and the gradient by that.
static float *weights_of(struct step_bench *bench) { return test_read(bench->step.effect_buffers[VW_SLOT_VISIBILITY]); }

// Returns how many params are not finite after three steps.
static double count_lost(struct step_bench *bench) {
    double lost = 0.0;
    for (uint64_t number = 1; number <= 3; number++) step_bench_step(bench, number);
    struct hard_state state = hard_state_read(bench);
    for (size_t i = 0; i < bench->model.param_bytes / sizeof(float); i++) lost += !isfinite(state.grid.grid[i]);
    return lost;
}

// Checks that under every loss the step costs the whole size penalty, the field learns nothing, and comes out as it
// was.
static void nothing_visible(struct hard_finding *finding) {
    static const enum vw_loss losses[] = {VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER};
    for (size_t i = 0; i < VW_ARRAY_COUNT(losses); i++) {
        struct step_case c = visibility;
        c.loss = losses[i];
        struct step_bench *bench = open_with(&c, 1.0f, -60.0f);
        double pixels = 0.0;
        for (uint32_t ray = 0; ray < bench->config.rays; ray++) pixels += bench->pixels[ray].weight;
        for (uint64_t number = 1; number <= 2; number++) {
            hard_check_step(finding, bench, number);
            struct hard_state state = hard_state_read(bench);
            double cost = reference_size_weight(&bench->model.specialization, number) * pixels;
            hard_compare(finding, "penalty of leaving all out", number, state.scalars.x, cost, cost, 1e-5);
            hard_same_bits(finding, "the field's grid", state.grid.grid, bench->params, bench->layout->grid.size_bytes);
        }
        test_release(bench);
    }
}

// Checks the gradient that leads back, and that nothing is lost where there is none.
static void none_certain(struct hard_finding *finding) {
    static const float logits[] = {-20.0f, -60.0f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(logits); i++) {
        struct step_bench *bench = open_with(&uncertainty, 1.0f, logits[i]);
        for (uint64_t number = 1; number <= 2; number++) hard_check_step(finding, bench, number);
        test_release(bench);
    }
    hard_equal(finding, "params that are not finite", 0, count_lost(open_with(&uncertainty, 1.0f, -1e4f)), 0.0);
}

// Checks that a loss is the plain one where all counts.
static void check_all(struct hard_finding *finding, const struct step_case *setup) {
    struct step_bench *bench = open_with(setup, 1.0f, 1e4f);
    hard_check_step(finding, bench, 1);
    float *weights = weights_of(bench), *losses = test_read(bench->step.ray_loss);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        hard_equal(finding, "weight", ray, weights[2 * ray], 1.0);
        if (setup == &visibility) hard_equal(finding, "gradient by it", ray, weights[2 * ray + 1], losses[ray]);
    }
}

static void all_counts(struct hard_finding *finding) {
    check_all(finding, &visibility);
    check_all(finding, &uncertainty);
}

// Checks that the params stay as they are, to the bit, and that the visit counts.
static void check_masked(struct hard_finding *finding, const struct step_case *setup) {
    struct step_bench *bench = open_with(setup, 1.0f, 0.0f);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    struct hard_state state = hard_state_read(bench);
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
    hard_equal(finding, "loss", 0, state.scalars.x, 0.0);
    if (setup == &uncertainty) return;
    struct vw_visibility_moments *moments = test_read(bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]);
    hard_equal(finding, "visits", 0, moments[bench->view].visits, 1.0);
    hard_equal(finding, "visits of another photo", 0, moments[1 - bench->view].visits, 0.0);
}

static void masked_photo(struct hard_finding *finding) {
    check_masked(finding, &visibility);
    check_masked(finding, &uncertainty);
}

// Checks that a step with an infinite loss is skipped and says so: 0 times infinity is not a number.
static void infinite_losses(struct hard_finding *finding) {
    static const float logits[] = {-1e30f, 0.0f, 1e30f};
    for (size_t i = 0; i < 2 * VW_ARRAY_COUNT(logits); i++) {
        struct step_bench *bench = open_with(i % 2 ? &visibility : &uncertainty, 1.0f, logits[i / 2]);
        hard_check_infinite_loss(finding, bench);
        test_release(bench);
    }
}

// Checks that the cost of leaving pixels out falls to its floor and stays there.
static void late_steps(struct hard_finding *finding) {
    static const uint64_t numbers[] = {1609, 1610, 2120, 2121, INT32_MAX, 1ull << 33, 1ull << 50};
    for (int doubt = 0; doubt < 2; doubt++) {
        struct step_bench *bench = open_with(doubt ? &uncertainty : &visibility, 1.0f, 0.0f);
        const struct vw_specialization *s = &bench->model.specialization;
        for (size_t i = doubt ? 0 : 2; i < VW_ARRAY_COUNT(numbers); i++) {
            double cost = doubt ? reference_certain_loss(s, numbers[i]) : reference_size_weight(s, numbers[i]),
                   floor = doubt ? 0.01 : 6e-3;
            step_bench_write_params(bench);
            hard_check_step(finding, bench, numbers[i]);
            hard_compare(finding, "cost of a pixel that is left out", i, cost, floor, floor, 1e-3);
        }
        test_release(bench);
    }
}

// Checks that the bias is all that is learned of pixels that look alike, so that all stay alike.
static void constant_features(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&uncertainty, 0.0f, 0.0f);
    for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
    float *weights = weights_of(bench);
    for (uint32_t ray = 1; ray < bench->config.rays; ray++)
        hard_equal(finding, "certainty", ray, weights[2 * ray], weights[0]);
}

// Checks that certainty rises where nothing is wrong, though nothing tells pixels apart.
static void no_error(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&uncertainty, 0.0f, 0.0f);
    struct vw_evaluator *evaluator = step_bench_evaluate(bench);
    vw_float4 *colours = test_read(evaluator->colours);
    for (uint32_t i = 0; i < bench->config.rays; i++)
        bench->pixels[i].rgba = (vw_float4){colours[i].x, colours[i].y, colours[i].z, 1.0f};
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    float *before = weights_of(bench);
    for (uint64_t number = 2; number <= 20; number++) step_bench_step(bench, number);
    hard_require(finding, weights_of(bench)[0] > before[0], "certainty rises");
}

// Checks that the largest error that is finite leaves all params finite.
static void huge_error(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&uncertainty, 1.0f, 0.0f);
    bench->pixels[3].rgba.x = 1e4f;
    hard_write_pixels(bench);
    hard_equal(finding, "params that are not finite", 0, count_lost(bench), 0.0);
}

static void large_features(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&uncertainty, 1e3f, 0.0f);
    for (uint64_t number = 1; number <= 2; number++) hard_check_step(finding, bench, number);
}

static const struct hard_case cases[] = {
    {"nothing visible", "0/0 in Adam; a field that moves without a gradient", nothing_visible},
    {"none certain", "the logarithm of 0, and a division by it", none_certain},
    {"all visible or certain", "a loss that differs from the plain one", all_counts},
    {"all pixels of a photo masked", "a cost of pixels that do not count", masked_photo},
    {"infinite losses, left out or not", "0 times infinity that no flag tells", infinite_losses},
    {"steps 1,609 to 2^50", "a cost of 0, or one that starts anew", late_steps},
    {"constant features", "pixels that look alike are told apart", constant_features},
    {"no error", "certainty that is lost for nothing", no_error},
    {"a huge error", "params that are not finite", huge_error},
    {"features of 1,000", "a logit beyond the logistic function", large_features},
};

HARD_CASES("visibility and uncertainty", cases)
