// Hard occupancy: nothing kept, everything kept, one sample kept, densities that are not numbers, rays that miss the
// box, 65,536 rays. Each is a whole step past the warm-up, held against the reference with the device's choice of
// samples (which check_occupancy.c evaluates).
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/text.h"
#include "hard_cases/hard_step.h"

enum { STEP = 300, REFRESHING_STEP = 320 };
static const float DENSE = 10.0f;

static const struct step_case setup = {.name = "occupancy",
                                       .seed = 351,
                                       .rays = 60,
                                       .samples = 16,
                                       .levels = 4,
                                       .log2_table = 8,
                                       .width = 16,
                                       .loss = VW_LOSS_L2,
                                       .effects = "background,occupancy"};

// Believes `density` of all cells but one.
static void believe(struct step_bench *bench, float density, uint32_t other_cell, float other_density) {
    float *densities = test_allocate(VW_OCCUPANCY_CELLS, sizeof *densities);
    for (uint32_t i = 0; i < VW_OCCUPANCY_CELLS; i++) densities[i] = i == other_cell ? other_density : density;
    step_bench_write(bench, bench->field.effect_buffers[VW_SLOT_OCCUPANCY], densities);
}

static uint32_t kept_count(struct step_bench *bench) {
    uint32_t *begins = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT_BEGINS]),
             count = begins[bench->step.padded_rays];
    return count;
}

static uint32_t slot_count(struct step_bench *bench) {
    struct vw_kept *kept = step_bench_read(bench, bench->step.effect_buffers[VW_SLOT_KEPT]);
    uint32_t slots = kept->slots;
    return slots;
}

// ---- Nothing, one, all ----------------------------------------------------------------------------------------------

static void nothing_kept(struct hard_finding *finding) {
    for (enum vw_scatter_form scatter = SCATTER_ATOMICS; scatter <= SCATTER_WALK; scatter++) {
        struct step_case empty = setup;
        empty.scatter = scatter;
        struct step_bench *bench = step_bench_open(&empty);
        float *zeros = test_allocate(bench->model.param_bytes, 1);
        believe(bench, 0.0f, 0, 0.0f);
        struct hard_gradients gradients = hard_take_gradients(bench, STEP);
        hard_equal(finding, "slots", 0, slot_count(bench), 0.0);
        hard_same_bits(finding, "gradients of the weights", gradients.weights, zeros,
                       16 * (size_t)bench->model.weight_columns);
        hard_check_step(finding, bench, STEP);
        float *params = step_bench_read(bench, bench->field.params);
        hard_same_bits(finding, "params", params, bench->params, bench->model.param_bytes);
        hard_check_rendering(finding, bench); // nothing is skipped there
        test_release(bench);
    }
}

// Returns a cell in which a single sample of the step lies.
static uint32_t lonely_cell(struct hard_finding *finding, struct step_bench *bench) {
    const struct vw_specialization *s = &bench->model.specialization;
    uint32_t *visits = test_allocate(VW_OCCUPANCY_CELLS, sizeof *visits), lonely = UINT32_MAX;
    struct vw_ray *rays = rays_make(bench);
    for (uint32_t i = 0; i < bench->padded_samples; i++) {
        struct reference_ray ray = reference_ray_of(&rays[i / s->samples]);
        double position[3];
        uint32_t line = i / s->samples, sample = i % s->samples;
        reference_sample_position(s, &ray, sample,
                                  reference_stratum_offset(s, line, sample, vw_model_key_of_step(&bench->model, STEP)),
                                  position);
        visits[reference_cell(position)]++;
    }
    for (uint32_t cell = VW_OCCUPANCY_CELLS / 2; cell < VW_OCCUPANCY_CELLS && lonely == UINT32_MAX; cell++)
        if (visits[cell] == 1) lonely = cell;
    hard_require(finding, lonely != UINT32_MAX, "some cell holds one sample");
    return lonely;
}

static void one_kept(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    believe(bench, 0.0f, lonely_cell(finding, bench), DENSE);
    hard_check_step(finding, bench, STEP);
    hard_equal(finding, "kept samples", 0, kept_count(bench), 1.0);
    hard_equal(finding, "slots", 0, slot_count(bench), VW_FIELD_GROUP);
}

// Compares the params and the loss after two steps with the effect and without it.
static void compare_with_off(struct hard_finding *finding, const struct step_case *with) {
    struct step_case without = *with;
    without.effects = vw_word_list_has(with->effects, "background") ? "background" : NULL;
    struct step_bench *on = step_bench_open(with), *off = step_bench_open(&without);
    believe(on, DENSE, 0, DENSE);
    for (uint64_t number = STEP; number < STEP + 2; number++) {
        step_bench_step(on, number);
        step_bench_step(off, number);
    }
    float *params_on = step_bench_read(on, on->field.params), *params_off = step_bench_read(off, off->field.params);
    float *loss_on = step_bench_read(on, on->scalars), *loss_off = step_bench_read(off, off->scalars);
    hard_require(finding, memcmp(params_on, on->params, on->model.param_bytes) != 0, "the steps move the params");
    hard_same_bits(finding, "params", params_on, params_off, on->model.param_bytes);
    hard_same_bits(finding, "loss and flags", loss_on, loss_off, 16);
}

static void everything_kept(struct hard_finding *finding) {
    for (enum vw_scatter_form scatter = SCATTER_ATOMICS; scatter <= SCATTER_WALK; scatter++) {
        struct step_case full = setup;
        full.scatter = scatter;
        compare_with_off(finding, &full);
    }
}

// ---- No numbers -----------------------------------------------------------------------------------------------------

static void densities_that_are_no_numbers(struct hard_finding *finding) {
    static const float unusual[] = {NAN, INFINITY};
    struct step_bench *bench = step_bench_open(&setup);
    uint32_t cell = lonely_cell(finding, bench);
    for (size_t i = 0; i < VW_ARRAY_COUNT(unusual); i++) {
        believe(bench, 0.0f, cell, unusual[i]);
        step_bench_gradients(bench, STEP);
        hard_equal(finding, "kept samples", 0, kept_count(bench), 1.0);
    }
    float *params = test_allocate(bench->model.param_bytes, 1);
    memcpy(params, bench->params, bench->model.param_bytes);
    for (size_t i = bench->model.grid.size_bytes / 4; i < bench->model.param_bytes / 4; i++)
        params[i] = NAN; // the networks
    step_bench_write(bench, bench->field.params, params);
    believe(bench, 0.0f, cell, 0.0f);
    step_bench_step(bench, REFRESHING_STEP);
    float *after = step_bench_read(bench, bench->field.params);
    vw_float4 *scalars = step_bench_read(bench, bench->scalars);
    hard_equal(finding, "kept samples", 0, kept_count(bench), bench->padded_samples);
    hard_require(finding, scalars->z != 0.0f,
                 "a field that is not a number is noticed, although all was believed empty");
    hard_same_bits(finding, "params of a skipped step", after, params, bench->model.param_bytes);
}

// ---- Rays -----------------------------------------------------------------------------------------------------------

static void rays_that_miss(struct hard_finding *finding) {
    struct step_bench *bench = step_bench_open(&setup);
    const double outside[3] = {-2.0, 0.5, 0.5}, away[3] = {-4.0, 0.5, 0.5};
    rays_look(&bench->scene->views[0], &bench->scene->box, outside, away); // view 1 still looks at the box
    rays_make(bench);
    hard_check_step(finding, bench, STEP);
    uint32_t missing = 0;
    struct vw_ray *rays = step_bench_read(bench, bench->step.ray_buffer);
    for (uint32_t i = 0; i < bench->config.rays; i++) missing += rays[i].direction_stride.w == 0.0f;
    hard_require(finding, missing >= bench->config.rays / 2, "half of the rays miss the box");
}

// Checks as many rays as a step may have, in one chunk and in four; each invocation of the prefix sum walks 256 of
// them.
static void rays_65536(struct hard_finding *finding) {
    struct step_case many = {.name = "65,536 rays",
                             .seed = 352,
                             .rays = 65536,
                             .samples = 1,
                             .levels = 1,
                             .features = 4,
                             .log2_table = 4,
                             .width = 16,
                             .loss = VW_LOSS_L2,
                             .effects = "occupancy"};
    struct step_bench *bench = step_bench_open(&many);
    struct hard_gradients gradients = hard_take_gradients(bench, STEP);
    hard_check_gradients(finding, bench, STEP, &gradients);
    uint32_t kept = kept_count(bench);
    hard_require(finding, kept > many.rays / 4 && kept < many.rays / 4 * 3, "about half of the samples are kept");
    many.chunk_samples = 16384;
    compare_with_off(finding, &many);
}

static const struct hard_case cases[] = {
    {"no sample kept", "dispatches of nothing; gradients left from before", nothing_kept},
    {"one sample kept", "padding that adds to the gradients", one_kept},
    {"every sample kept", "other bits than without the effect", everything_kept},
    {"densities that are not numbers", "what is broken is believed empty and never met", densities_that_are_no_numbers},
    {"rays that miss the box", "samples of no length in cells of the faces", rays_that_miss},
    {"65,536 rays", "a prefix sum that ends early", rays_65536},
};

int main(void) { return hard_cases_run("occupancy", cases, VW_ARRAY_COUNT(cases)); }
