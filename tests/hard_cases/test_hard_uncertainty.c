// Hard pixels of uncertainty: features that say nothing, all certain, none certain, no error at all, losses beyond the
// floats, photos of which no pixel counts, large features, and step numbers past 2^31.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/synthetic_scene.h"

static const struct step_case setup = {.name = "uncertainty", .seed = 393, HARD_STEP, .effects = "uncertainty"};

static float *features_of(const struct step_bench *bench) {
    return vw_buffer_map(bench->step.effect_buffers[VW_SLOT_FEATURES]);
}

// Opens a bench whose pixels have features of this size, and a bias of the logit.
static struct step_bench *open_with(const struct step_case *c, float size, float logit) {
    struct step_bench *bench = step_bench_open(c);
    bench->params[vw_uncertainty_network(&bench->model).offset_bytes / 4 + 4 * (UNCERTAINTY_LOGIT + VISIBILITY4)] =
        logit;
    step_bench_write_params(bench);
    for (uint32_t i = 0; i < bench->config.rays * REFERENCE_FEATURES; i++)
        if (i % REFERENCE_FEATURES + 1 < REFERENCE_FEATURES) features_of(bench)[i] *= size;
    return bench;
}

// Checks that the bias is all that is learned of pixels that look alike, so that all stay alike.
static void constant_features(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 0.0f, 0.0f);
    for (uint64_t number = 1; number <= 3; number++) hard_check_step(finding, bench, number);
    float *of_rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    for (uint32_t ray = 1; ray < bench->config.rays; ray++)
        hard_equal(finding, "certainty", ray, of_rays[2 * ray], of_rays[0]);
}

// Checks that a loss is the plain one where all is certain.
static void all_certain(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 1.0f, 1e4f);
    hard_check_step(finding, bench, 1);
    float *of_rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++)
        hard_equal(finding, "certainty", ray, of_rays[2 * ray], 1.0);
}

// Returns how many params are not finite after three steps.
static double count_lost(struct step_bench *bench) {
    double lost = 0.0;
    for (uint64_t number = 1; number <= 3; number++) step_bench_step(bench, number);
    struct hard_state state = hard_state_read(bench);
    for (size_t i = 0; i < bench->model.param_bytes / sizeof(float); i++) lost += !isfinite(state.grid.grid[i]);
    return lost;
}

// Checks the gradient that leads back, and that nothing is lost where there is none.
static void none_certain(struct hard_finding *finding) {
    static const float logits[] = {-20.0f, -60.0f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(logits); i++) {
        struct step_bench *bench = open_with(&setup, 1.0f, logits[i]);
        for (uint64_t number = 1; number <= 2; number++) hard_check_step(finding, bench, number);
        test_release(bench);
    }
    hard_equal(finding, "params that are not finite", 0, count_lost(open_with(&setup, 1.0f, -1e4f)), 0.0);
}

// Checks that certainty rises where nothing is wrong, though nothing tells pixels apart.
static void no_error(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 0.0f, 0.0f);
    struct vw_evaluator *evaluator = step_bench_evaluate(bench);
    vw_float4 *colours = step_bench_read(bench, evaluator->colours);
    for (uint32_t i = 0; i < bench->config.rays; i++)
        bench->pixels[i].rgba = (vw_float4){colours[i].x, colours[i].y, colours[i].z, 1.0f};
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    float *before = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    for (uint64_t number = 2; number <= 20; number++) step_bench_step(bench, number);
    float *after = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]);
    hard_require(finding, after[0] > before[0], "certainty rises");
}

// Checks that a step with an infinite loss is skipped and says so, however certain it is.
static void infinite_losses(struct hard_finding *finding) {
    static const float logits[] = {-1e30f, 0.0f, 1e30f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(logits); i++) {
        struct step_bench *bench = open_with(&setup, 1.0f, logits[i]);
        hard_check_infinite_loss(finding, bench);
        test_release(bench);
    }
}

// Checks that the largest error that is finite leaves all params finite.
static void huge_error(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 1.0f, 0.0f);
    bench->pixels[3].rgba.x = 1e4f;
    hard_write_pixels(bench);
    hard_equal(finding, "params that are not finite", 0, count_lost(bench), 0.0);
}

static void large_features(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 1e3f, 0.0f);
    for (uint64_t number = 1; number <= 2; number++) hard_check_step(finding, bench, number);
}

static void masked_photo(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 1.0f, 0.0f);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    struct hard_state state = hard_state_read(bench);
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
    hard_equal(finding, "loss", 0, state.scalars.x, 0.0);
}

static void late_steps(struct hard_finding *finding) {
    static const uint64_t numbers[] = {1609, 1610, INT32_MAX, 1ull << 33, 1ull << 50};
    struct step_bench *bench = open_with(&setup, 1.0f, 0.0f);
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) {
        step_bench_write_params(bench);
        hard_check_step(finding, bench, numbers[i]);
        hard_compare(finding, "certain loss", i, reference_certain_loss(&bench->model.specialization, numbers[i]), 0.01,
                     0.01, 1e-3);
    }
}

static void photos_of_one_pixel(struct hard_finding *finding) {
    struct vw_scene *scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 2, .width_px = 1, .height_px = 1});
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "uncertainty");
    hard_train_well(finding, scene, &config);
}

static const struct hard_case cases[] = {
    {"constant features", "pixels that look alike are told apart", constant_features},
    {"all certain", "a loss that differs from the plain one", all_certain},
    {"none certain", "the logarithm of 0, and a division by it", none_certain},
    {"no error", "certainty that is lost for nothing", no_error},
    {"a huge error", "params that are not finite", huge_error},
    {"infinite losses, certain or not", "0 times infinity that no flag tells", infinite_losses},
    {"features of 1,000", "a logit beyond the logistic function", large_features},
    {"all pixels of a photo masked", "a cost of pixels that do not count", masked_photo},
    {"steps 1,609 to 2^50", "a cost of 0, or one that starts anew", late_steps},
    {"photos of one pixel", "features of neighbours that are not there", photos_of_one_pixel},
};

int main(void) { return hard_cases_run("uncertainty", cases, VW_ARRAY_COUNT(cases)); }
