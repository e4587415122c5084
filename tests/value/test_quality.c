// quality: the mean of two ranks from a ledger's rows, its interval, and what has none; train_fit, the loss it ranks.
#include "support/value_game.h"

enum { EPOCHS = 13, BURN_IN = 1, LATE = EPOCHS - 4 }; // the last third of 12 epochs
static const double late_loss[TEST_TRAIN_COUNT] = {0.25, 0.5, 0.25, 0.125, 0.375};

static double noisy(const uint32_t *order, uint32_t first, uint32_t step, uint64_t seed) {
    (void)first;
    return test_worth_db[order[step]] + test_noise(seed, step);
}

// Plays a game whose losses are reversed before the late epochs.
static struct test_game *play(test_rule *rule, uint32_t epochs) {
    struct test_game *game = test_play(rule, epochs, 3);
    for (uint32_t step = 1; step < game->count; step++) {
        double loss = late_loss[game->order[step]];
        game->records[step].train_loss = game->records[step].epoch < LATE ? 1 - loss : loss;
    }
    return game;
}

static struct vw_ledger_score *score(const struct test_game *game, uint32_t *count) {
    struct vw_value_input input = test_input_of(game, BURN_IN, 0);
    struct vw_ledger_score *scores = NULL;
    ASSERT_OK(vw_value_score(&input, &scores, count));
    return scores;
}

static const struct vw_ledger_score *quality_of(const struct vw_ledger_score *scores, uint32_t count, uint32_t photo) {
    return test_find_score(scores, count, "quality", test_train_views[photo]);
}

// Photo 1 has the largest training loss, photo 3 the least dv_loss: neither is the best by the mean of both.
TEST(quality_is_the_mean_of_two_ranks) {
    const double expected[TEST_TRAIN_COUNT] = {(4 + 2.5) / 8, (1 + 0) / 8.0, (2 + 2.5) / 8, (0 + 4) / 8.0,
                                               (3 + 1) / 8.0};
    AUTO_FREE struct test_game *game = play(test_additive, EPOCHS);
    uint32_t count = 0;
    for (uint32_t step = game->count - 3; step < game->count; step++) { // flagged steps do not count
        test_flag(game, step);
        game->records[step].train_loss = 1e9;
    }
    AUTO_FREE struct vw_ledger_score *scores = score(game, &count);
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
        const struct vw_ledger_score *quality = quality_of(scores, count, photo);
        assert_string_equal(quality->unit, "mean rank");
        if (quality->value != expected[photo])
            fail_msg("photo %u has quality %g, not %g", photo, quality->value, expected[photo]);
        assert_in_range(quality->visits, EPOCHS - BURN_IN - 1, EPOCHS - BURN_IN);
        const struct vw_ledger_score *fit = test_find_score(scores, count, "train_fit", test_train_views[photo]);
        assert_near(fit->value, -10 * log10(late_loss[photo]), 1e-12); // only late visits count
        assert_in_range(fit->visits, EPOCHS - LATE - 1, EPOCHS - LATE);
    }
}

TEST(its_interval_is_drawn_from_the_epochs) {
    AUTO_FREE struct test_game *steady = play(test_additive, EPOCHS), *moving = play(noisy, EPOCHS);
    uint32_t count = 0;
    struct vw_ledger_score *same = score(steady, &count), *scores = score(moving, &count),
                           *again = score(moving, &count);
    double widest = 0;
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
        const struct vw_ledger_score *certain = quality_of(same, count, photo), *one = quality_of(scores, count, photo),
                                     *other = quality_of(again, count, photo);
        assert_true(certain->ci_low == certain->value && certain->ci_high == certain->value); // all epochs agree
        assert_true(0 <= one->ci_low && one->ci_low <= one->value && one->value <= one->ci_high && one->ci_high <= 1);
        assert_true(one->ci_low == other->ci_low && one->ci_high == other->ci_high);
        assert_in_range(one->rank_ci_low, 1, one->rank_ci_high);
        widest = fmax(widest, one->standard_error);
    }
    assert_true(widest > 0.05);
    free(same);
    free(scores);
    free(again);
}

static bool has_quality(const struct vw_ledger_score *scores, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(scores[i].method, "quality") == 0) return true;
    return false;
}

TEST(without_losses_there_is_none) {
    AUTO_FREE struct test_game *game = play(noisy, 4);
    uint32_t count = 0;
    struct vw_ledger_score *scores = score(game, &count);
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++)
        assert_true(isnan(quality_of(scores, count, photo)->ci_low)); // three epochs are too few for an interval
    free(scores);
    for (uint32_t step = 0; step < game->count; step++)
        if (game->order[step] == 2) game->records[step].train_loss = NAN;
    scores = score(game, &count);
    assert_int_equal(quality_of(scores, count, 2)->visits, 0);
    assert_int_equal(quality_of(scores, count, 1)->visits, 3);
    free(scores);
    for (uint32_t step = 0; step < game->count; step++) game->records[step].train_loss = NAN;
    scores = score(game, &count);
    assert_true(count > 0 && !has_quality(scores, count));
    free(scores);
}
