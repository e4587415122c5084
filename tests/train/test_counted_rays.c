// A step that looks only at the pixels with weight gives the bits of one that looks at all: under every field, loss and
// effect, and with what an earlier step left in the buffers of rays.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "reference/step_bench.h"
#include "support/gpu_fixture.h"

enum { WEIGHTY = 7 }; // no whole group of rays

// Takes a step on all pixels, then one on the first with weight.
static struct step_bench *take_steps(const struct step_case *c, bool looks_at_all) {
    struct step_bench *bench = step_bench_open(c);
    step_bench_step(bench, 1);
    for (uint32_t i = WEIGHTY; i < bench->config.rays; i++) bench->pixels[i].weight = 0.0f;
    memcpy(vw_buffer_map(bench->pixel_buffer), bench->pixels, bench->config.rays * sizeof *bench->pixels);
    if (!looks_at_all) bench->step.counted[0] = WEIGHTY;
    step_bench_step(bench, 2);
    return bench;
}

static void check_case(const struct step_case *c) {
    struct step_bench *all = take_steps(c, true), *few = take_steps(c, false);
    struct vw_buffer *of_all[TRAINING_STATE_BUFFERS_MAX], *of_few[TRAINING_STATE_BUFFERS_MAX];
    uint32_t count = vw_step_training_state(&all->step, of_all);
    assert_int_equal(vw_step_training_state(&few->step, of_few), count);
    for (uint32_t i = 0; i < count; i++)
        if (memcmp(test_read(of_all[i]), test_read(of_few[i]), vw_buffer_size_bytes(of_all[i])))
            fail_msg("%s: buffer %u of the training's state differs", all->where, i);
    vw_float4 *row = test_read(all->scalars), *few_row = test_read(few->scalars);
    if (memcmp(row, few_row, sizeof *row) != 0) fail_msg("%s: loss or flags differ", all->where);
    test_release(few);
    test_release(all);
}

// Lists what step_cases lacks.
static const struct step_case more_cases[] = {
    {"placed samples", .seed = 61, .importance_samples = 24},
    {"pose", .seed = 62, .another_effect = "pose"},
    {"transient", .seed = 63, .another_effect = "transient", .ray_lanes = 8},
    {"encoder", .seed = 64, .another_effect = "appearance_encoder"},
    {"mlp", .seed = 65, .field = VW_FIELD_MLP, .width = 16, .mlp_depth = 3, .importance_samples = 24,
     .own_coarse = true},
};

TEST(rays_without_weight_change_no_bit) {
    for (uint32_t i = 0; i < step_case_count; i++)
        if (!(step_cases[i].consistency_weight > 0.0)) check_case(&step_cases[i]); // a picture needs all
}

TEST_CASES(nor_in_other_fields_and_effects, i, VW_ARRAY_COUNT(more_cases)) { check_case(&more_cases[i]); }

TEST_GROUP(NULL, test_gpu_close)
