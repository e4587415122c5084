// Records become visits: forms of the delta, flagged steps, epochs, and what momentum mixed.
#include "support/value_game.h"

#include "value/series.h"

static const uint64_t seed = 11;

static double noisy(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)first;
    return test_worth_db[order[step]] + 0.3 * test_noise(with_seed, step);
}

static struct vw_series make(const struct test_game *game, uint32_t burn_in_epochs, double beta1, enum vw_form form) {
    struct vw_value_input input = test_input_of(game, burn_in_epochs, beta1);
    struct vw_series series;
    ASSERT_OK(vw_series_make(&input, VW_MEASURE_PSNR, form, &series));
    return series;
}

static double sum_of(const struct vw_series *series, uint32_t image) { // TEST_IMAGE_COUNT: of all
    double sum = 0;
    for (uint64_t i = 0; i < series->count; i++)
        if (image == TEST_IMAGE_COUNT || series->visits[i].image == image) sum += series->visits[i].delta;
    return sum;
}

// A sum of a hundred numbers near 20 is right to some 1e-13.
static const double rounding = 1e-12;

TEST(steps_add_up_to_last_minus_first) {
    AUTO_FREE struct test_game *game = test_play(noisy, 20, seed);
    const double before[] = {12, game->records[TEST_TRAIN_COUNT].val_psnr,
                             game->records[7 * TEST_TRAIN_COUNT].val_psnr};
    const uint32_t burn_in[] = {0, 1, 7};
    for (size_t i = 0; i < VW_ARRAY_COUNT(burn_in); i++) {
        AUTO(vw_series_free) struct vw_series series = make(game, burn_in[i], 0, VW_FORM_STEP);
        assert_int_equal(series.count, (20 - burn_in[i]) * TEST_TRAIN_COUNT);
        assert_int_equal(series.epoch_count, 20 - burn_in[i]);
        assert_near(sum_of(&series, TEST_IMAGE_COUNT), game->records[game->count - 1].val_psnr - before[i], rounding);
    }
}

// Each photo's revisit deltas add up to the measure after its last visit minus the one after its last visit within
// burn-in.
TEST(revisits_telescope) {
    AUTO_FREE struct test_game *game = test_play(noisy, 20, seed);
    struct vw_series series = make(game, 2, 0, VW_FORM_REVISIT);
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
        double first = NAN, last = NAN;
        for (uint32_t step = 1; step < game->count; step++) {
            if (game->order[step] != photo) continue;
            if (game->records[step].epoch < 2) first = game->records[step].val_psnr;
            last = game->records[step].val_psnr;
        }
        assert_near(sum_of(&series, test_train_views[photo]), last - first, rounding);
    }
    vw_series_free(&series);
    struct vw_value_input input = test_input_of(game, 0, 0);
    input.images++; // so that the first image is one that is trained on
    input.image_count--;
    ASSERT_OK(vw_series_make(&input, VW_MEASURE_PSNR, VW_FORM_REVISIT, &series));
    for (uint32_t i = 0; i < series.count; i++) // the untrained field does not count as an earlier visit
        assert_int_equal(isnan(series.visits[i].delta), i < TEST_TRAIN_COUNT);
    vw_series_free(&series);
}

TEST(flagged_steps_are_bridged) {
    AUTO_FREE struct test_game *game = test_play(noisy, 6, seed);
    const uint32_t flagged = 12, photo = game->order[flagged];
    uint32_t later = flagged + 1, earlier = flagged - 1;
    while (game->order[later] != photo) later++;
    while (game->order[earlier] != photo) earlier--;
    test_flag(game, flagged);
    const struct vw_step_record *records = game->records;
    struct vw_series series = make(game, 1, 0, VW_FORM_STEP); // the first visit is that of step 1 + TEST_TRAIN_COUNT
    const struct vw_visit *visits = series.visits - 1 - TEST_TRAIN_COUNT;
    assert_true(isnan(visits[flagged].delta));
    assert_true(visits[flagged + 1].delta == records[flagged + 1].val_psnr - records[flagged - 1].val_psnr);
    vw_series_free(&series);
    series = make(game, 1, 0, VW_FORM_REVISIT);
    visits = series.visits - 1 - TEST_TRAIN_COUNT;
    assert_true(isnan(visits[flagged].delta));
    assert_true(visits[later].delta == records[later].val_psnr - records[earlier].val_psnr);
    vw_series_free(&series);
}

TEST(less_loss_is_more_worth) {
    AUTO_FREE struct test_game *game = test_play(noisy, 2, seed);
    struct vw_value_input input = test_input_of(game, 1, 0);
    AUTO(vw_series_free) struct vw_series series;
    ASSERT_OK(vw_series_make(&input, VW_MEASURE_L1, VW_FORM_STEP, &series));
    for (uint32_t i = 0; i < series.count; i++) {
        uint32_t step = 1 + TEST_TRAIN_COUNT + i;
        assert_true(series.visits[i].delta == -(game->records[step].val_l1 - game->records[step - 1].val_l1));
    }
}

// Epochs may have any numbers, and photos any number of visits in each.
TEST(epochs_are_counted_where_they_change) {
    AUTO_FREE struct test_game *game = test_play(noisy, 4, seed);
    const uint32_t epochs[] = {3, 3, 5, 4000000000u}, expected[] = {0, 1, 2};
    for (uint32_t step = 1; step < game->count; step++) game->records[step].epoch = epochs[game->records[step].epoch];
    struct vw_series series = make(game, 3, 0, VW_FORM_STEP);
    assert_int_equal(series.count, 4 * TEST_TRAIN_COUNT);
    assert_int_equal(series.epoch_count, 3);
    for (uint32_t i = 0; i < series.count; i++)
        assert_int_equal(series.visits[i].epoch, i < 2 * TEST_TRAIN_COUNT ? 0 : expected[i / TEST_TRAIN_COUNT - 1]);
    vw_series_free(&series);
    series = make(game, 4000000001u, 0, VW_FORM_STEP);
    assert_int_equal(series.count, 0);
    assert_int_equal(series.epoch_count, 0);
    vw_series_free(&series);
}

TEST(visits_are_sorted_by_photo) {
    AUTO_FREE struct test_game *game = test_play(noisy, 5, seed);
    AUTO(vw_series_free)
    struct vw_series series = make(game, 1, 0, VW_FORM_STEP), sorted = make(game, 1, 0, VW_FORM_STEP);
    uint64_t starts[TEST_IMAGE_COUNT + 1], at = 0;
    ASSERT_OK(vw_series_sort_by_photo(&sorted, TEST_IMAGE_COUNT, starts));
    for (uint32_t image = 0; image < TEST_IMAGE_COUNT; image++) {
        assert_int_equal(starts[image], at);
        for (uint64_t i = 0; i < series.count; i++)
            if (series.visits[i].image == image) {
                assert_true(sorted.visits[at].image == image && sorted.visits[at].epoch == series.visits[i].epoch);
                assert_true(sorted.visits[at++].delta == series.visits[i].delta);
            }
    }
    assert_int_equal(at, series.count);
    assert_int_equal(starts[TEST_IMAGE_COUNT], at);
}

TEST(an_unknown_image_is_refused) {
    AUTO_FREE struct test_game *game = test_play(noisy, 2, seed);
    game->records[7].view = 99;
    struct vw_value_input input = test_input_of(game, 1, 0);
    AUTO(vw_series_free) struct vw_series series;
    ASSERT_FAILS(vw_series_make(&input, VW_MEASURE_PSNR, VW_FORM_STEP, &series), VW_ERROR_INPUT,
                 "step 7: image 99 is not in the image table");
}

// ---- Momentum -------------------------------------------------------------------------------------------------------

static const double beta1 = 0.9;

// Returns a step's delta: the mix that Adam's first moment makes of what this and all earlier steps earn.
static double mix(const uint32_t *order, uint32_t step, uint64_t with_seed, double noise_db) {
    double sum = 0;
    for (uint32_t s = 1; s <= step; s++)
        sum += (1 - beta1) * pow(beta1, step - s) * (test_worth_db[order[s]] + noise_db * test_noise(with_seed, s));
    return sum;
}

static double mixed(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)first;
    return mix(order, step, with_seed, 0);
}

static double mixed_with_draws(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)first;
    return mix(order, step, with_seed, 0.5);
}

// Undoing the filter amplifies rounding, 1e-14 of some 20 dB, by (1 + b) / (1 - b) = 19.
static const double amplified_rounding = 1e-12;

// Asserts that the credits of a run of 20 epochs are the photos' worths and `noise_db` of noise, but that they are
// unknown from step `first` to `last`.
static void assert_credits(const struct test_game *game, double noise_db, uint32_t first, uint32_t last) {
    AUTO(vw_series_free) struct vw_series series = make(game, 1, beta1, VW_FORM_DECONVOLVED);
    for (uint32_t i = 0; i < series.count; i++) {
        uint32_t step = 1 + TEST_TRAIN_COUNT + i;
        double expected = test_worth_db[game->order[step]] + noise_db * test_noise(seed, step);
        if (step >= first && step <= last) assert_true(isnan(series.visits[i].delta));
        else assert_near(series.visits[i].delta, expected, amplified_rounding);
    }
}

// The worth comes back with the noise that its step drew: credits are not noisier than deltas without momentum.
TEST(draws_stay_with_their_steps) {
    AUTO_FREE struct test_game *game = test_play(mixed_with_draws, 20, seed);
    assert_credits(game, 0.5, UINT32_MAX, 0);
}

TEST(without_momentum_credits_are_deltas) {
    AUTO_FREE struct test_game *game = test_play(noisy, 20, seed);
    test_flag(game, 33);
    AUTO(vw_series_free)
    struct vw_series series = make(game, 1, 0, VW_FORM_STEP), credits = make(game, 1, 0, VW_FORM_DECONVOLVED);
    for (uint32_t i = 0; i < series.count; i++) {
        assert_int_equal(isnan(series.visits[i].delta), isnan(credits.visits[i].delta));
        if (!isnan(series.visits[i].delta)) assert_true(credits.visits[i].delta == series.visits[i].delta);
    }
}

// Leaves the first moment as it is at a flagged step, which was not taken.
static double mixed_but_for_one(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)first;
    (void)with_seed;
    double moment = 0;
    for (uint32_t s = 1; s <= step; s++)
        moment = s == 31 ? moment : beta1 * moment + (1 - beta1) * test_worth_db[order[s]];
    return step == 31 ? 0 : moment;
}

TEST(steps_not_taken_have_no_part_in_momentum) {
    AUTO_FREE struct test_game *game = test_play(mixed_but_for_one, 20, seed);
    test_flag(game, 31);
    assert_credits(game, 0, 31, 31);
}

TEST(what_has_no_value_has_no_credit) {
    AUTO_FREE struct test_game *game = test_play(mixed, 3, seed);
    for (uint32_t step = 0; step < 9; step++) test_flag(game, step);
    AUTO(vw_series_free) struct vw_series series = make(game, 1, beta1, VW_FORM_DECONVOLVED);
    for (uint32_t i = 0; i < series.count;
         i++) // step 9 is the first that has a value, but nothing to start from, and 10 needs its delta
        assert_int_equal(isnan(series.visits[i].delta), 1 + TEST_TRAIN_COUNT + i <= 10);
}

// Imported runs may have such steps: what the step earned went into the moment, unseen.
TEST(steps_taken_unvalidated_leave_credits_unknown) {
    AUTO_FREE struct test_game *game = test_play(mixed, 20, seed);
    const uint32_t unvalidated = 31;
    test_set_psnr(&game->records[unvalidated], NAN);
    game->records[unvalidated].validated = false;
    assert_credits(game, 0, unvalidated, unvalidated + 2);
}
