// Hard masks of visibility: nothing visible, all of it, photos of which no pixel counts, losses beyond the floats,
// step numbers past 2^31, and photos of one pixel.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "hard_cases/hard_run.h"
#include "hard_cases/hard_step.h"
#include "support/synthetic_scene.h"

static const struct step_case setup = {.name = "visibility", .seed = 391, HARD_STEP, .effects = "visibility"};

static struct vw_scene *scene;

// Opens a bench whose pixels are visible as the logistic function of about `logit` says.
static struct step_bench *open_with(const struct step_case *c, float logit) {
    struct step_bench *bench = step_bench_open(c);
    bench->params[vw_visibility_network(&bench->model).offset_bytes / 4 + 4 * (VISIBILITY_LOGIT + VISIBILITY4)] = logit;
    step_bench_write_params(bench);
    return bench;
}

static double total_weight(const struct step_bench *bench) {
    double sum = 0.0;
    for (uint32_t i = 0; i < bench->config.rays; i++) sum += bench->pixels[i].weight;
    return sum;
}

// Checks that under every loss the step costs the whole size penalty, the field learns nothing, and comes out as it
// was.
static void nothing_visible(struct hard_finding *finding) {
    static const enum vw_loss losses[] = {VW_LOSS_L1, VW_LOSS_L2, VW_LOSS_HUBER};
    for (size_t i = 0; i < VW_ARRAY_COUNT(losses); i++) {
        struct step_case c = setup;
        c.loss = losses[i];
        struct step_bench *bench = open_with(&c, -60.0f);
        for (uint64_t number = 1; number <= 2; number++) {
            hard_check_step(finding, bench, number);
            struct hard_state state = hard_state_read(bench);
            double weight = reference_size_weight(&bench->model.specialization, number);
            hard_compare(finding, "penalty of leaving all out", number, state.scalars.x, weight * total_weight(bench),
                         weight * total_weight(bench), 1e-5);
            hard_same_bits(finding, "the field's grid", state.grid.grid, bench->params, bench->model.grid.size_bytes);
        }
        test_release(bench);
    }
}

static void all_visible(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 1e4f);
    hard_check_step(finding, bench, 1);
    float *of_rays = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY]),
          *losses = step_bench_read(bench, bench->step.ray_loss);
    for (uint32_t ray = 0; ray < bench->config.rays; ray++) {
        hard_equal(finding, "visibility", ray, of_rays[2 * ray], 1.0);
        hard_equal(finding, "gradient by it", ray, of_rays[2 * ray + 1], losses[ray]);
    }
}

// Checks that the network and the photo's code stay as they are, to the bit, and that the visit counts.
static void masked_photo(struct hard_finding *finding) {
    struct step_bench *bench = open_with(&setup, 0.0f);
    for (uint32_t i = 0; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    hard_write_pixels(bench);
    hard_check_step(finding, bench, 1);
    struct hard_state state = hard_state_read(bench);
    struct vw_visibility_moments *moments =
        step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_VISIBILITY_MOMENTS]);
    hard_same_bits(finding, "params", state.grid.grid, bench->params, bench->model.param_bytes);
    hard_equal(finding, "loss", 0, state.scalars.x, 0.0);
    hard_equal(finding, "visits", 0, moments[bench->view].visits, 1.0);
    hard_equal(finding, "visits of another photo", 0, moments[1 - bench->view].visits, 0.0);

    scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 2, .width_px = 12, .height_px = 8});
    scene->views[1].image.unusable = vw_allocate(12 * 8, 1);
    memset(scene->views[1].image.unusable, 1, 12 * 8);
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "visibility");
    hard_train_well(finding, scene, &config);
}

// Checks that a step with an infinite loss is skipped and says so: 0 times infinity is not a number.
static void infinite_losses(struct hard_finding *finding) {
    static const float logits[] = {-1e30f, 0.0f, 1e30f};
    for (size_t i = 0; i < VW_ARRAY_COUNT(logits); i++) {
        struct step_bench *bench = open_with(&setup, logits[i]);
        hard_check_infinite_loss(finding, bench);
        test_release(bench);
    }
}

// Checks that the penalty falls to its floor and stays there.
static void late_steps(struct hard_finding *finding) {
    static const uint64_t numbers[] = {2120, 2121, INT32_MAX, 1ull << 33, 1ull << 50};
    struct step_bench *bench = open_with(&setup, 0.0f);
    for (size_t i = 0; i < VW_ARRAY_COUNT(numbers); i++) {
        step_bench_write_params(bench);
        hard_check_step(finding, bench, numbers[i]);
        hard_compare(finding, "weight of size", i, reference_size_weight(&bench->model.specialization, numbers[i]),
                     6e-3, 6e-3, 1e-3);
    }
}

static void photos_of_one_pixel(struct hard_finding *finding) {
    scene = synthetic_scene(
        &(struct synthetic_scene_params){.train_views = 4, .val_views = 2, .width_px = 1, .height_px = 1});
    struct vw_config config = hard_run_config();
    strcpy(config.effects, "visibility");
    hard_train_well(finding, scene, &config);
}

static const struct hard_case cases[] = {
    {"nothing visible", "0/0 in Adam; a field that moves without a gradient", nothing_visible},
    {"all visible", "a loss that differs from the plain one", all_visible},
    {"all pixels of a photo masked", "a penalty on pixels that do not count", masked_photo},
    {"infinite losses, left out or not", "0 times infinity that no flag tells", infinite_losses},
    {"steps 2,120 to 2^50", "a penalty of 0, or one that starts anew", late_steps},
    {"photos of one pixel", "places that are 0/0", photos_of_one_pixel},
};

int main(void) { return hard_cases_run("visibility", cases, VW_ARRAY_COUNT(cases)); }
