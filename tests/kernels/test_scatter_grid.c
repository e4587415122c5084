// Decision 3 in scatter_grid: sums of fixed-point gradients never wrap and are the same in every form. (All samples at
// the clamp in one entry: test_hard_training.)
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "kernels/checks/check.h"
#include "support/gpu_fixture.h"
#include "support/plain_config.h"

// A gradient scattered by one 64-bit atomic per feature.
struct scattered {
    float *rows;
    uint64_t *words;
    size_t size_bytes;
    uint32_t clamped;
};

static struct scattered scatter_by_atomics(const struct step_case *setup) {
    struct step_bench *bench = step_bench_open(setup);
    assert_true(vw_gpu_get_limits(bench->gpu)->int64_atomics);
    struct scattered scattered = {.rows = scatter_rows(bench, INPUT_ORDINARY),
                                  .size_bytes = vw_buffer_size_bytes(bench->volume->d_grid)};
    struct vw_step_state flags;
    scatter_run(bench, scattered.rows, &flags);
    scattered.words = test_read(bench->volume->d_grid);
    scattered.clamped = flags.clamped;
    return scattered;
}

// Checks that a form without 64-bit atomics gives their bits: two 32-bit atomics with a carry, or none.
static void gives_the_bits_of_atomics(struct step_case setup, enum vw_scatter_form form,
                                      const struct scattered *atomics) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.int64_atomics = false;
    setup.scatter = form;
    struct step_bench *bench = step_bench_open_clamped(&setup, &clamp);
    assert_false(vw_gpu_get_limits(bench->gpu)->int64_atomics);
    struct vw_step_state flags;
    scatter_run(bench, atomics->rows, &flags);
    uint64_t *words = test_read(bench->volume->d_grid);
    check_same_bits(bench->where, form == SCATTER_WALK ? "d_grid without atomics" : "d_grid with split atomics", words,
                    atomics->words, atomics->size_bytes);
    assert_int_equal(flags.clamped, atomics->clamped);
    test_release(bench);
}

// The quick tests take every second case, with one of the two other forms.
TEST(every_form_gives_the_same_bits) {
    bool all = test_is_full();
    for (uint32_t i = 0; i < step_case_count; i += all ? 1 : 2) {
        struct scattered atomics = scatter_by_atomics(&step_cases[i]);
        if (all || i % 4) gives_the_bits_of_atomics(step_cases[i], SCATTER_SPLIT_ATOMICS, &atomics);
        if (all || i % 4 == 0) gives_the_bits_of_atomics(step_cases[i], SCATTER_WALK, &atomics);
    }
}

// A loop of more trips would stop early on some drivers, so that long chunks are not walked.
TEST(only_short_chunks_are_walked) {
    struct vw_config config = plain_config();
    struct vw_effect_decision none[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    vw_effects_list(none, &effect_count);
    struct vw_scene scene = {0};
    for (config.samples = 1; config.samples <= 1024; config.samples++) {
        struct vw_model model;
        if (vw_config_check(&config) != VW_OK) continue;
        const struct vw_device_choices choices = {
            .chunk_samples = 1 << 18, .scatter = SCATTER_WALK, .slice_samples = 128, .slice_parts = 1};
        enum vw_status status =
            vw_model_create(&config, &scene, NULL, 0, none, &choices, vw_gpu_get_limits(test_gpu()), &model);
        assert_true(status || vw_volume_of(&model)->scatter != SCATTER_WALK ||
                    model.specialization.chunk_samples <= 65535 / 2);
        vw_model_destroy(&model);
    }
}

// The bound itself, for every step size: samples x (largest contribution + 4 for the rounding of eight corners) stays
// within the bits.
TEST(no_step_size_can_wrap) {
    static const uint32_t sample_counts[] = {1, 7, 30, 31, 32, 48, 127, 4096};
    struct vw_config config = plain_config();
    struct vw_effect_decision none[VW_EFFECT_COUNT_MAX];
    uint32_t effect_count;
    vw_effects_list(none, &effect_count);
    struct vw_scene scene = {0};
    for (size_t i = 0; i < VW_ARRAY_COUNT(sample_counts); i++) {
        for (config.rays = 1; config.rays <= 65536; config.rays += 1 + config.rays / 7) {
            struct vw_model model;
            config.samples = sample_counts[i];
            if (vw_config_check(&config) != VW_OK) continue;
            const struct vw_device_choices choices = {.chunk_samples = 1 << 14, .slice_samples = 128, .slice_parts = 1};
            assert_int_equal(vw_model_create(&config, &scene, NULL, 0, none, &choices, &vw_gpu_floor_limits, &model),
                             VW_OK);
            const struct vw_specialization *s = &model.specialization;
            double samples = (double)vw_model_pad_rays(&model, config.rays) * config.samples,
                   most = s->gradient_clamp / (double)s->gradient_quantum;
            if (!(samples * (most * (1.0 + 32.0 * FLOAT_ROUNDING) + 4.0) < (s->wide_gradient ? 0x1p63 : 0x1p31)))
                fail_msg("%u rays of %u samples may wrap", config.rays, config.samples);
            assert_true(most >= 0x1p15); // and 16 bits are left
            vw_model_destroy(&model);
        }
    }
}

TEST_GROUP(NULL, test_gpu_close)
