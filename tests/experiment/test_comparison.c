// Paired comparison: cases with known means, errors and intervals.
#include "support/cmocka_test.h"

#include "experiment/comparison.h"
#include "value/evaluation/outcomes.h"

#define ROUNDING 1e-12 // rounding of a few sums of numbers near 20

// Every measure its own field, and every field its own measure.
TEST(measures_are_the_fields) {
    const struct vw_retrain_result outcome = {
        .val_psnr = 1, .val_ssim = 2, .val_l1 = 3, .test_psnr = 4, .test_ssim = 5, .test_l1 = 6, .seconds = 7};
    static const char *const names[] = {"val_psnr", "val_ssim", "val_l1", "test_psnr", "test_ssim", "test_l1"};
    for (int i = 0; i < VW_OUTCOME_COUNT; i++) {
        enum vw_outcome measure = (enum vw_outcome)i;
        assert_string_equal(vw_outcome_name(measure), names[i]);
        assert_near(vw_outcome_of(&outcome, measure), i + 1, 0);
        assert_int_equal(vw_outcome_higher_is_better(measure), strstr(names[i], "_l1") == NULL);
    }
}

static struct vw_paired_difference compare_outcome(const struct vw_retrain_result *results,
                                                   const struct vw_retrain_result *against, uint32_t count,
                                                   enum vw_outcome outcome) {
    double values[4], others[4];
    for (uint32_t i = 0; i < count; i++) {
        values[i] = vw_outcome_of(&results[i], outcome);
        others[i] = vw_outcome_of(&against[i], outcome);
    }
    return vw_samples_compare(values, others, count);
}

// 20, 22, 24: mean 22, variance 4, standard error sqrt(4 / 3).
TEST(means_over_seeds) {
    const double psnr_db[] = {20, 22, 24}, unknown[] = {20, NAN};
    struct vw_outcome_mean mean = vw_samples_average(psnr_db, 3);
    assert_near(mean.mean, 22, ROUNDING);
    assert_near(mean.standard_error, sqrt(4.0 / 3), ROUNDING);
    mean = vw_samples_average(psnr_db, 1);
    assert_near(mean.mean, 20, ROUNDING);
    assert_true(isnan(mean.standard_error));
    mean = vw_samples_average(psnr_db, 0);
    assert_true(isnan(mean.mean) && isnan(mean.standard_error));
    assert_true(isnan(vw_samples_average(unknown, 2).mean));
}

// Seeds that differ by decibels, and lists by 1, 2 and 3: pairing leaves a mean of 2 with the standard error 1 /
// sqrt(3), and with t(2) = 4.3027 an interval of 2 -+ 2.484. Unpaired, the luck of the seeds would hide it.
TEST(luck_of_the_seed_cancels) {
    const struct vw_retrain_result better[] = {{.val_psnr = 11}, {.val_psnr = 32}, {.val_psnr = 53}};
    const struct vw_retrain_result worse[] = {{.val_psnr = 10}, {.val_psnr = 30}, {.val_psnr = 50}};
    struct vw_paired_difference paired = compare_outcome(better, worse, 3, VW_OUTCOME_VAL_PSNR);
    assert_near(paired.difference, 2, ROUNDING);
    assert_near(paired.standard_error, sqrt(1.0 / 3), ROUNDING);
    assert_near(paired.ci_low, 2 - 4.302652729749 * sqrt(1.0 / 3), 1e-9);
    assert_near(paired.ci_high, 2 + 4.302652729749 * sqrt(1.0 / 3), 1e-9);
    assert_false(paired.beyond_noise); // three seeds do not tell 2 from 0 here
    paired = compare_outcome(worse, better, 3, VW_OUTCOME_VAL_PSNR);
    assert_near(paired.difference, -2, ROUNDING);
}

TEST(what_is_beyond_noise) {
    const struct vw_retrain_result zero[4] = {{0}};
    const struct vw_retrain_result alike[] = {{.test_l1 = 1}, {.test_l1 = 1.25}, {.test_l1 = 0.75}, {.test_l1 = 1}};
    const struct vw_retrain_result less[] = {{.test_l1 = -1}, {.test_l1 = -1.25}, {.test_l1 = -0.75}, {.test_l1 = -1}};
    const struct vw_retrain_result apart[] = {{.test_l1 = 4}, {.test_l1 = -2}, {.test_l1 = 3}, {.test_l1 = -1}};
    const struct vw_retrain_result same[] = {{.test_l1 = 1}, {.test_l1 = 1}, {.test_l1 = 1}, {.test_l1 = 1}};
    assert_true(compare_outcome(alike, zero, 4, VW_OUTCOME_TEST_L1).beyond_noise);
    assert_true(compare_outcome(less, zero, 4, VW_OUTCOME_TEST_L1).beyond_noise);
    assert_false(compare_outcome(apart, zero, 4, VW_OUTCOME_TEST_L1).beyond_noise);
    assert_true(compare_outcome(same, zero, 4, VW_OUTCOME_TEST_L1).beyond_noise); // an interval without width
    assert_false(compare_outcome(zero, zero, 4, VW_OUTCOME_TEST_L1).beyond_noise);
}

TEST(one_seed_has_no_interval) {
    const struct vw_retrain_result a = {.val_ssim = 0.75}, b = {.val_ssim = 0.5};
    struct vw_paired_difference paired = compare_outcome(&a, &b, 1, VW_OUTCOME_VAL_SSIM);
    assert_near(paired.difference, 0.25, 0);
    assert_true(isnan(paired.standard_error) && isnan(paired.ci_low) && isnan(paired.ci_high));
    assert_false(paired.beyond_noise);
}

// A split without photos has no values.
TEST(no_value_makes_no_difference) {
    const struct vw_retrain_result a[] = {{.test_psnr = 20}, {.test_psnr = NAN}},
                                   b[] = {{.test_psnr = 20}, {.test_psnr = 21}};
    struct vw_paired_difference paired = compare_outcome(a, b, 2, VW_OUTCOME_TEST_PSNR);
    assert_true(isnan(paired.difference) && isnan(paired.standard_error) && isnan(paired.ci_low) &&
                isnan(paired.ci_high));
    assert_false(paired.beyond_noise);
}
