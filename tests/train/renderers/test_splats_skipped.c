// Steps of splats that cannot be taken: with more pairs than have room, or numbers that are not finite. Such a step
// changes nothing, is flagged and counted, and the run goes on; where there are many, it ends with the remedy.
// wrap: vw_splats_pair_room
#include "support/cmocka_test.h"

#include "run/run.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "support/trainer_fixture.h"
#include "train/renderers/splats/splats.h"

static uint32_t step_pairs, validation_pairs; // the room for pairs of one drawing; 0: the device's

WRAPS(vw_splats_pair_room);

uint32_t __wrap_vw_splats_pair_room(const struct vw_radiance_field *field, const struct vw_splat_room *room) {
    uint32_t pairs = room->views == 1 ? step_pairs : validation_pairs; // the scene has two validation photos
    return pairs ? pairs : __real_vw_splats_pair_room(field, room);
}

// Gives steps room for so many pairs, but not validation.
static struct vw_config config_with_room(uint32_t pairs) {
    struct vw_config config = test_config_of(VW_FIELD_SPLATS);
    config.rays = VW_SPLAT_SQUARE * VW_SPLAT_SQUARE;
    step_pairs = pairs;
    validation_pairs = 0;
    strcpy(config.effects, "none");
    return config;
}

// Returns the pairs of the last step.
static uint32_t pairs_of(const struct vw_trainer *trainer) {
    struct vw_splat_state state;
    ASSERT_OK(vw_buffer_read(vw_splat_step_of(&trainer->step)->drawing.state, 0, &state, sizeof state));
    return state.pairs;
}

static uint32_t count_flagged(const struct test_run *run) {
    uint32_t flagged = 0;
    for (uint32_t i = 0; i < run->count; i++) {
        const struct vw_step_record *record = &run->records[i];
        flagged += record->nonfinite;
        assert_int_equal(record->nonfinite, isnan(record->val_psnr));
    }
    assert_int_equal(flagged, run->stats.nonfinite_steps);
    return flagged;
}

TEST(a_run_without_room_stays_where_it_begins) {
    struct vw_config config = config_with_room(1);
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 0);
    const uint32_t *before = test_read(trainer->field.params);
    const struct test_run *run = test_run_of(trainer);
    assert_false(run->records[0].nonfinite); // the untrained field is drawn
    assert_int_equal(count_flagged(run), run->count - 1);
    assert_memory_equal(run->params, before, trainer->model.param_bytes);
}

TEST(a_step_without_room_is_left_out_and_the_others_are_taken) {
    struct vw_scene *scene = test_scene();
    struct vw_config config = config_with_room(0);
    struct vw_trainer *trainer = test_trainer_create(scene, &config, true, 1);
    struct test_run *roomy = test_run_of(trainer);
    assert_int_equal(count_flagged(roomy), 0);
    config = config_with_room(pairs_of(trainer)); // some squares show more splats, and some fewer
    struct test_run *one = test_run(scene, &config, true, 1), *many = test_run(scene, &config, true, 7);
    test_run_assert_same(one, many);
    uint32_t flagged = count_flagged(one);
    if (!flagged || flagged == one->count - 1) fail_msg("%u of %u steps are left out", flagged, one->count - 1);
    assert_memory_not_equal(one->params, roomy->params, 4 * one->param_words);
}

TEST(a_validation_without_room_has_no_values) {
    struct vw_config config = config_with_room(0);
    validation_pairs = 1;
    const struct test_run *run = test_run(test_scene(), &config, true, 0);
    assert_int_equal(count_flagged(run), run->count);
    for (uint32_t i = 1; i < run->count; i++) assert_true(isfinite(run->records[i].train_loss)); // they are taken
}

static const struct {
    uint32_t column, lane;
    float value;
} poisons[] = {{SPLAT_HARMONICS, 1, NAN}, {SPLAT_HARMONICS, 2, INFINITY}};

// Colours are the numbers that no cut-off stops: a splat with another number that is not finite is not shown at all.
TEST_CASES(colours_that_are_not_finite_flag_every_row_that_shows_them, i, VW_ARRAY_COUNT(poisons)) {
    struct vw_config config = config_with_room(0);
    config.rays = 4 * VW_SPLAT_SQUARE * VW_SPLAT_SQUARE; // whole photos
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, true, 1);
    uint64_t stride = vw_splat_model_of(&trainer->model)->count;
    for (uint64_t splat = 0; splat < stride; splat++)
        ASSERT_OK(vw_buffer_write(trainer->field.params,
                                  16 * (poisons[i].column * stride + splat) + 4 * poisons[i].lane, &poisons[i].value,
                                  sizeof(float)));
    const uint32_t *before = test_read(trainer->field.params);
    const struct test_run *run = test_run_of(trainer);
    assert_int_equal(count_flagged(run), run->count);
    assert_memory_equal(run->params, before, trainer->model.param_bytes);
}

// A rate beyond all reason flags the steps after which params would not be finite.
TEST(params_stay_finite_whatever_the_rate) {
    struct vw_config config = config_with_room(0);
    config.learning_rate = 1e6;
    config.epochs = 8;
    struct vw_trainer *trainer = test_trainer_create(test_scene(), &config, false, 0);
    const struct test_run *run = test_run_of(trainer);
    for (uint32_t i = 0; i < run->param_words; i++) assert_true(isfinite(((const float *)run->params)[i]));
}

FOLDER_TEST(a_run_whose_steps_have_no_room_ends_with_the_remedy) {
    struct vw_config config = config_with_room(1);
    config.epochs = 6; // 36 steps
    struct vw_run *run = NULL;
    const struct vw_run_params params = {.scene = {.path = SMALL_SCENE}, .config = &config, .out = *state};
    ASSERT_OK(vw_run_open(&params, &run));
    ASSERT_FAILS(vw_run_advance(run, UINT64_MAX), VW_ERROR_DEVICE, "stopped at step 21: 21 steps were not finite",
                 "try a lower --lr or fewer --splats");
    vw_run_close(&run);
}

TEST_GROUP(NULL, test_gpu_close)
