// --table-precision: how floats become halves, where a run on halves begins, what it saves, and that neither precision
// takes the files of the other. What its passes compute is in tests/kernels and tests/hard_cases.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/compute.h"
#include "reference/reference.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/initial_values.h"
#include "train/trainer.h"

static struct vw_config config_of(enum vw_table_precision precision) {
    struct vw_config config = test_config();
    config.table_precision = precision;
    return config;
}

// ---- Rounding -------------------------------------------------------------------------------------------------------

static void assert_nearest(float value) {
    double expected = reference_half(value), found = reference_half_value(vw_half_nearest(value));
    if (found != expected || signbit(found) != signbit(expected))
        fail_msg("%.9g becomes %.9g, not %.9g", value, found, expected);
}

// All halves, the middles between neighbours, and the floats beside both.
TEST(every_float_becomes_the_nearest_half) {
    for (uint32_t bits = 0; bits < 0x7C00; bits++) {
        double value = reference_half_value((uint16_t)bits),
               next = bits < 0x7BFF ? reference_half_value((uint16_t)(bits + 1)) : 65536.0;
        const float at[] = {(float)value, (float)(0.5 * (value + next))};
        assert_int_equal(vw_half_nearest(at[0]), bits);
        for (int i = 0; i < 2; i++) {
            for (int sign = -1; sign <= 1; sign += 2) {
                assert_nearest((float)sign * at[i]);
                assert_nearest((float)sign * nextafterf(at[i], INFINITY));
                assert_nearest((float)sign * nextafterf(at[i], -INFINITY));
            }
        }
    }
    assert_int_equal(vw_half_nearest(NAN) & 0x7FFF, 0x7C00);
    assert_int_equal(vw_half_nearest(-INFINITY), 0xFC00);
    assert_int_equal(vw_half_nearest(3e38f), 0x7C00);
}

// ---- Params ---------------------------------------------------------------------------------------------------------

TEST(a_run_on_halves_begins_where_one_on_floats_does) {
    struct vw_scene *scene = test_scene();
    const struct vw_config configs[] = {config_of(VW_TABLE_FLOAT32), config_of(VW_TABLE_FLOAT16)};
    struct vw_trainer *floats = test_trainer_create(scene, &configs[0], false, 0),
                      *halves = test_trainer_create(scene, &configs[1], false, 0);
    const struct vw_model *wide = &floats->model, *narrow = &halves->model;
    char *before = test_allocate(wide->param_bytes, 1), *after = test_allocate(narrow->param_bytes, 1);
    ASSERT_OK(vw_model_initialise(wide, NULL, 7, before));
    ASSERT_OK(vw_model_initialise(narrow, NULL, 7, after));
    const struct vw_specialization *ours = &narrow->specialization, *theirs = &wide->specialization;
    assert_true(ours->dense_levels > 0 &&
                ours->dense_levels < ours->levels); // dense levels of halves and of floats are padded differently
    for (uint32_t level = 0; level < ours->levels; level++) {
        uint64_t end = level + 1 < ours->levels ? theirs->first_pair[level + 1] : wide->pair_count,
                 first = theirs->first_pair[level];
        for (uint64_t i = 0; i < 2 * (end - first); i++)
            assert_true(reference_feature(narrow, after, 2 * (uint64_t)ours->first_pair[level] + i) ==
                        reference_half(reference_feature(wide, before, 2 * first + i)));
    }
    assert_int_equal(wide->weights.size_bytes, narrow->weights.size_bytes);
    assert_memory_equal(before + wide->weights.offset_bytes, after + narrow->weights.offset_bytes,
                        wide->weights.size_bytes);
}

struct taken {
    uint64_t param_bytes, param_count, device_bytes;
    double update_bytes,
        field_bytes; // that update_grid and forward_field have to move, the latter in training and validation
    double gathered_pairs;
};

static struct taken take(enum vw_table_precision precision) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of(precision);
    config.base_resolution = 16; // all levels hashed: dense ones are padded
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 0);
    struct vw_trainer_stats stats;
    struct vw_pass_costs costs;
    vw_trainer_get_stats(trainer, &stats);
    vw_trainer_pass_costs(trainer, &costs);
    double samples = (double)(trainer->step.padded_rays + trainer->validation.evaluator.ray_count) * config.samples;
    struct taken taken = {.param_bytes = trainer->model.param_bytes,
                          .param_count = stats.param_count,
                          .device_bytes = stats.device_bytes,
                          .gathered_pairs = samples * 8.0 * config.levels * config.features / 2};
    assert_int_equal(vw_buffer_size_bytes(trainer->field.params), taken.param_bytes);
    for (uint32_t i = 0; i < costs.count; i++) {
        if (!strcmp(costs.list[i].name, "update_grid")) taken.update_bytes += costs.list[i].bytes;
        if (!strcmp(costs.list[i].name, "forward_field")) taken.field_bytes += costs.list[i].bytes;
    }
    test_release(trainer);
    return taken;
}

// 4 bytes of every pair: in the params block, on the device, and each time that a pass reads or writes one. 4 levels of
// 2^10 entries.
TEST(halves_take_half_the_bytes) {
    struct taken floats = take(VW_TABLE_FLOAT32), halves = take(VW_TABLE_FLOAT16);
    const uint64_t saved_bytes = 4 * (4 << 10);
    assert_int_equal(floats.param_bytes - halves.param_bytes, saved_bytes);
    assert_int_equal(floats.device_bytes - halves.device_bytes, saved_bytes);
    assert_int_equal(floats.param_count, halves.param_count);
    assert_true(floats.update_bytes - halves.update_bytes == 2.0 * (double)saved_bytes);
    assert_true(floats.field_bytes - halves.field_bytes == 4.0 * floats.gathered_pairs);
}

// ---- Runs -----------------------------------------------------------------------------------------------------------

// Whatever the submissions, the same steps.
TEST(a_run_on_halves_gives_the_same_bits_again) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_of(VW_TABLE_FLOAT16), wide = config_of(VW_TABLE_FLOAT32);
    config.epochs = wide.epochs = 12;
    struct test_run *first = test_run(scene, &config, true, 0), *second = test_run(scene, &config, true, 3),
                    *other = test_run(scene, &wide, true, 0);
    test_run_assert_same(first, second);
    double last = first->records[first->count - 1].val_psnr, start = first->records[0].val_psnr;
    print_message("from %.2f dB to %.2f, on floats %.2f\n", start, last, other->records[other->count - 1].val_psnr);
    assert_true(last > start + 1.0);                                           // it learns,
    assert_true(last != other->records[other->count - 1].val_psnr);            // in its own way,
    assert_true(fabs(last - other->records[other->count - 1].val_psnr) < 1.0); // about as well
}

// The files of each precision go to a trainer of the other, whose params stay as they are.
FOLDER_TEST(files_of_the_other_precision_are_refused) {
    const char *field = temporary_path(*state, "field"), *checkpoint = temporary_path(*state, "checkpoint");
    struct vw_scene *scene = test_scene();
    for (int i = 0; i < 2; i++) {
        struct vw_config ours = config_of((enum vw_table_precision)i),
                         theirs = config_of((enum vw_table_precision)(1 - i));
        struct vw_trainer *trainer = test_trainer_create(scene, &theirs, true, 0);
        uint64_t step = 0;
        test_run_of(trainer);
        ASSERT_OK(vw_trainer_save_field(trainer, field));
        ASSERT_OK(vw_trainer_save_checkpoint(trainer, checkpoint));
        trainer = test_trainer_create(scene, &ours, true, 0);
        ASSERT_FAILS(vw_trainer_load_field(trainer, field), VW_ERROR_INPUT, "trained with another configuration");
        ASSERT_FAILS(vw_trainer_load_checkpoint(trainer, checkpoint, UINT64_MAX, &step), VW_ERROR_INPUT,
                     "of another run");
        test_run_assert_same(test_run(scene, &ours, true, 0), test_run_of(trainer));
    }
}

TEST_GROUP(NULL, test_gpu_close)
