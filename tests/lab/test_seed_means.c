// Means of scores over seeds: levels that seeds share do not count, photos without a score do not either, and the
// intervals hold the truth as often as they say.
#include "support/cmocka_test.h"

#include "base/random.h"
#include "lab/evaluation/seed_means.h"

enum { SEEDS = 3, PHOTOS = 4 };

TEST(levels_of_seeds_do_not_count) {
    static const double plain[SEEDS * PHOTOS] = {1, 2, 3, 9, 1.5, 2, 2.5, 9, 0.5, 2, 3.5, 9};
    struct vw_seed_mean means[PHOTOS], moved[PHOTOS];
    double levelled[SEEDS * PHOTOS];
    for (int i = 0; i < SEEDS * PHOTOS; i++) levelled[i] = plain[i] + 10.0 * (i / PHOTOS);
    ASSERT_OK(vw_seed_means_make(plain, SEEDS, PHOTOS, means));
    ASSERT_OK(vw_seed_means_make(levelled, SEEDS, PHOTOS, moved));
    for (int i = 0; i < PHOTOS; i++) {
        assert_float_equal(moved[i].mean, means[i].mean + 10, 1e-12);
        assert_float_equal(moved[i].standard_error, means[i].standard_error, 1e-12);
        assert_int_equal(moved[i].overlaps, means[i].overlaps);
    }
    assert_float_equal(means[0].mean, 1, 1e-12);
    // Variances 0.25, 0, 0.25 and 0, times 4/3; their mean counts as two degrees of freedom more.
    assert_float_equal(means[0].standard_error, sqrt((2 * 0.25 + 2 * 0.125) * 4 / 3 / 4 / 3), 1e-12);
    assert_float_equal(means[1].standard_error, sqrt(2 * 0.125 * 4 / 3 / 4 / 3), 1e-12);
    assert_float_equal((means[0].ci_high - means[0].mean) / means[0].standard_error, 2.776, 0.01); // Student, 4 degrees
    assert_int_equal(means[3].rank, 1);
    assert_int_equal(means[3].overlaps, 0);
    assert_int_equal(means[3].rank_ci_high, 1);
    assert_int_equal(means[0].rank, 4);
    assert_int_equal(means[0].rank_ci_low, 3); // 9 and 3 lie above
    assert_int_equal(means[0].rank_ci_high, 4);
    assert_int_equal(means[0].overlaps, 1);
}

TEST(photos_that_a_seed_lacks_are_left_out) {
    const double values[SEEDS * PHOTOS] = {1, NAN, 3, 9, 1.5, 2, 2.5, 9, 0.5, 2, 3.5, 9};
    struct vw_seed_mean means[PHOTOS];
    ASSERT_OK(vw_seed_means_make(values, SEEDS, PHOTOS, means));
    assert_true(isnan(means[1].mean) && isnan(means[1].ci_low));
    assert_int_equal(means[1].rank, 0);
    assert_int_equal(means[0].rank, 3);
}

// Photos of different noise, two seeds: the intervals hold the photo's own place among the others.
TEST(intervals_hold_the_truth) {
    enum { TRIALS = 300, MANY = 12 };
    uint32_t held = 0;
    for (uint32_t trial = 0; trial < TRIALS; trial++) {
        double values[2 * MANY];
        struct vw_seed_mean means[MANY];
        for (uint32_t i = 0; i < 2 * MANY; i++) {
            uint32_t words[4];
            double sum = -6;
            for (uint32_t part = 0; part < 3; part++) { // nearly normal, variance 1
                vw_random_words(7, VW_RANDOM_JITTER, trial, i, part, words);
                for (int w = 0; w < 4; w++) sum += vw_random_unit(words[w]);
            }
            values[i] = i % MANY + (1 + 0.5 * (i % 2)) * sum;
        }
        ASSERT_OK(vw_seed_means_make(values, 2, MANY, means));
        double level = 0;
        for (uint32_t i = 0; i < MANY; i++) level += (means[i].mean - i) / MANY;
        for (uint32_t i = 0; i < MANY; i++) held += means[i].ci_low - level <= i && i <= means[i].ci_high - level;
    }
    double share = held / (double)(TRIALS * MANY);
    if (share < 0.93 || share > 0.99) fail_msg("%.3f of the 95 %% intervals hold the truth", share);
}
