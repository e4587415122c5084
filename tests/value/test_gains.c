// Gains of lists over all photos: a case by hand, and games whose gain is known.
#include "support/cmocka_test.h"

#include "support/draws.h"
#include "value/evaluation/gains.h"

#define ROUNDING 1e-12

// Two lists, two seeds, three photos. Differences, means over seeds: 1, 2, 3; so gain 2 and variance over photos 1, of
// which a third counts. Means of trainings: 10 and 12 of all, 13 and 13 of the list: residuals of the two-way table are
// +-0.5, their squares add up to 1 with 1 degree of freedom; 2 / 2 times 1 counts. Degrees of freedom:
// (4/3)^2 / ((1/3)^2 / 2 + 1 / 1) = 1.68, rounded down to 1, where t is 31.8205.
TEST(both_noises_count) {
    static const double psnr_db[] = {
        9,  10, 11, 11, 12, 13, // all photos
        11, 13, 15, 11, 13, 15,
    };
    struct vw_gain gains[2];
    ASSERT_OK(vw_gains_estimate(psnr_db, 2, 2, 3, gains));
    assert_true(gains[0].gain_db == 0 && gains[0].ci_low == 0 && gains[0].ci_high == 0);
    assert_near(gains[1].gain_db, 2, ROUNDING);
    assert_near(gains[1].standard_error, sqrt(4.0 / 3), ROUNDING);
    assert_near(gains[1].ci_low, 2 - 31.8205159537740 * sqrt(4.0 / 3), 1e-9);
    assert_near(gains[1].ci_high, 2 + 31.8205159537740 * sqrt(4.0 / 3), 1e-9);
}

// A second list with the same results adds no degree of freedom; one with those of all photos has no noise.
TEST(equal_lists_are_counted_once) {
    static const double psnr_db[] = {
        9,  10, 11, 11, 12, 13, // all photos
        11, 13, 15, 11, 13, 15, 11, 13, 15, 11, 13, 15, 9, 10, 11, 11, 12, 13,
    };
    struct vw_gain gains[4];
    ASSERT_OK(vw_gains_estimate(psnr_db, 4, 2, 3, gains));
    assert_near(gains[1].standard_error, sqrt(4.0 / 3), ROUNDING);
    assert_near(gains[2].ci_low, 2 - 31.8205159537740 * sqrt(4.0 / 3), 1e-9);
    assert_true(gains[3].gain_db == 0 && gains[3].ci_low == 0 && gains[3].ci_high == 0);
}

TEST(too_little_data_proves_nothing) {
    static const double psnr_db[] = {10, 10, 12, 12.5}, unknown[] = {9, 10, 11, 11, 12, 13, 11, NAN, 15, 11, 13, 15};
    struct vw_gain gains[2];
    ASSERT_OK(vw_gains_estimate(psnr_db, 2, 1, 2, gains)); // one seed
    assert_near(gains[1].gain_db, 2.25, ROUNDING);
    assert_true(isnan(gains[1].ci_low) && isnan(gains[1].ci_high));
    assert_int_equal(vw_gains_choose(gains, 2), 0);
    ASSERT_OK(vw_gains_estimate(psnr_db, 2, 2, 1, gains)); // one photo
    assert_true(isnan(gains[1].ci_low));
    ASSERT_OK(vw_gains_estimate(unknown, 2, 2, 3, gains));
    assert_true(isnan(gains[1].gain_db) && isnan(gains[1].ci_low));
    assert_int_equal(vw_gains_choose(gains, 2), 0);
}

TEST(the_best_of_those_that_are_sure_is_chosen) {
    const struct vw_gain gains[] = {
        {0, 0, 0, 0}, {3, 2, -0.1, 6}, {1, 0.1, 0.8, 1.2}, {1.5, 0.5, 0.5, 2.5}, {2, 1, 0, 4}};
    assert_int_equal(vw_gains_choose(gains, 5), 3);
    assert_int_equal(vw_gains_choose(gains, 3), 2);
    assert_int_equal(vw_gains_choose(gains, 2), 0);
}

// ---- Games ----
// A list's result: its gain, what the photo adds to it, and the noise of its training, which all photos share.

enum { LISTS = 14, SEEDS = 2, VIEWS = 6, GAMES = 400 };

// Returns the gain of the list that is chosen in a game; `gains_db` has the true gains.
static double play(uint32_t game, const double gains_db[LISTS]) {
    static double psnr_db[LISTS * SEEDS * VIEWS];
    struct vw_gain gains[LISTS];
    for (uint32_t i = 0; i < LISTS * SEEDS * VIEWS; i++) {
        uint32_t list = i / (SEEDS * VIEWS), training = i / VIEWS, view = i % VIEWS;
        psnr_db[i] = 20 + 3 * test_normal(game, 0, view) + gains_db[list] +
                     (list ? 0.1 * test_normal(game, 1, list * VIEWS + view) : 0) +
                     0.15 * test_normal(game, 2, training) + 0.05 * test_normal(game, 3, i);
    }
    ASSERT_OK(vw_gains_estimate(psnr_db, LISTS, SEEDS, VIEWS, gains));
    return gains_db[vw_gains_choose(gains, LISTS)];
}

// Returns the share of games in which a list of that gain is chosen.
static double share_of(const double gains_db[LISTS], double gain_db) {
    uint32_t chosen = 0;
    for (uint32_t game = 0; game < GAMES; game++) chosen += play(game, gains_db) == gain_db;
    return (double)chosen / GAMES;
}

TEST(no_worse_list_is_chosen) {
    static const double worse[LISTS] = {0, -0.3, -0.3, -0.4, -0.5, -0.3, -0.6, -0.8, -1, -0.3, -0.3, -0.3, -0.3, -0.3};
    double share = share_of(worse, 0);
    if (share < 0.99) fail_msg("all photos are kept in %g of the games", share);
}

// Thirteen lists have thirteen chances.
TEST(no_gain_is_seldom_found) {
    static const double none[LISTS] = {[1] = 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-9,
                                       1e-9,       1e-9, 1e-9, 1e-9, 1e-9, 1e-9};
    double share = share_of(none, 0);
    if (share < 0.9) fail_msg("all photos are kept in %g of the games", share);
}

// Without a harmful photo the second list gains 1 dB; other lists drop good photos, too.
TEST(a_large_gain_is_found) {
    static const double large[LISTS] = {0, 1, -0.2, 0.2, 0.1, 0, -0.3, -0.5, -0.5, -0.2, -0.2, -0.2, -0.2, -0.2};
    double share = share_of(large, 1);
    if (share < 0.99) fail_msg("the list without the harmful photo is chosen in %g of the games", share);
}
