// Agreement of the scores of several runs: numbers worked out by hand, and the edges where a measure says nothing.
#include "support/ledger_fixture.h"

#include "lab/evaluation/full_agreement.h"

static const double ROUNDING = 4e-16; // a few roundings of numbers near 1

static struct vw_full_agreement compare(const double *a, const double *b, const bool *clean, uint32_t count) {
    struct vw_full_agreement agreement;
    ASSERT_OK(vw_full_agreement_of_pair(a, b, clean, count, &agreement));
    return agreement;
}

TEST(numbers_worked_out_by_hand) {
    // Deviations -2 -1 0 1 2 and -1 -2 1 0 2: products 2 2 0 0 4, squares 10 and 10.
    const double a[] = {-2, -1, 0, 1, 2}, b[] = {-1.5, -2.5, 0.5, -0.5, 1.5};
    struct vw_full_agreement agreement = compare(a, b, NULL, 5);
    assert_int_equal(agreement.photos, 5);
    assert_int_equal(agreement.clean, 0);
    assert_near(agreement.values[VW_AGREEMENT_PEARSON], 0.8, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_SPEARMAN], 0.8, ROUNDING);
    assert_true(isnan(agreement.values[VW_AGREEMENT_CLEAN_PEARSON]) &&
                isnan(agreement.values[VW_AGREEMENT_CLEAN_SPEARMAN]));
    // Positive: {3, 4} and {2, 4}. Alike: 0, 1 and 4. By chance: (2 * 2 + 3 * 3) / 25 = 13 / 25; (15 - 13) / (25 - 13).
    assert_near(agreement.values[VW_AGREEMENT_POSITIVE_JACCARD], 1.0 / 3, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_SAME_SIGN], 0.6, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_SIGN_KAPPA], 1.0 / 6, ROUNDING);
}

TEST(ties_share_their_rank) {
    // Ranks 1.5 1.5 3 4 and 1 2.5 2.5 4: deviations -1 -1 0.5 1.5 and -1.5 0 0 1.5, products 1.5 0 0 2.25, squares 4.5
    // and 4.5.
    const double a[] = {1, 1, 2, 9}, b[] = {-7, 0, 0, 100};
    assert_near(compare(a, b, NULL, 4).values[VW_AGREEMENT_SPEARMAN], 3.75 / 4.5, ROUNDING);
}

TEST(the_clean_are_compared_alone) {
    const double a[] = {1, 2, 3, -50, -60}, b[] = {3, 1, 2, -60, -50};
    const bool clean[] = {true, true, true, false, false};
    struct vw_full_agreement agreement = compare(a, b, clean, 5);
    assert_int_equal(agreement.clean, 3);
    assert_true(agreement.values[VW_AGREEMENT_PEARSON] > 0.95); // which the two corrupted photos make
    assert_near(agreement.values[VW_AGREEMENT_CLEAN_PEARSON], -0.5, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_CLEAN_SPEARMAN], -0.5, ROUNDING);
}

TEST(two_extremes_do_not_decide) {
    // Without 50 and -40 (the second run's; 0 in the first): -2 -1 0 1 2 and -1 -2 1 0 2, as above.
    const double a[] = {-2, 50, -1, 0, 1, 0, 2}, b[] = {-1, 60, -2, 1, 0, -40, 2};
    struct vw_full_agreement agreement = compare(a, b, NULL, 7);
    assert_near(agreement.values[VW_AGREEMENT_TRIMMED_PEARSON], 0.8, ROUNDING);
    assert_true(isnan(compare(a, b, NULL, 4).values[VW_AGREEMENT_TRIMMED_PEARSON]));
    const double equal[] = {1, 1, 1, 1, 3}, other[] = {1, 2, 3, 4, 5}; // no spread: the last is farthest in the first
    assert_true(isnan(compare(equal, other, NULL, 5).values[VW_AGREEMENT_TRIMMED_PEARSON]));
}

TEST(coverage_counts_intervals_that_hold_the_mean) {
    // The mean of two runs is seen from a score at 1 / sqrt(2) of the way to the other one: 0.707 of 1.
    double values[] = {0, 5, 1, NAN}, low[] = {-1, 0, 0.2, 0}, high[] = {0.71, 9, 2, 1};
    struct vw_score_table table = {.values = values, .ci_low = low, .ci_high = high};
    const struct vw_score_tables tables = {.run_count = 2, .photo_count = 2};
    struct vw_coverage coverage = vw_agreement_coverage(&tables, &table);
    assert_int_equal(coverage.intervals, 2); // the other photo has a score in one run only
    assert_near(coverage.share, 1, ROUNDING);
    high[0] = 0.70;
    assert_near(vw_agreement_coverage(&tables, &table).share, 0.5, ROUNDING);
    low[0] = low[2] = NAN;
    assert_true(isnan(vw_agreement_coverage(&tables, &table).share));
}

TEST(missing_scores_are_left_out) {
    const double a[] = {NAN, -2, -1, 0, 5, 1, 2, INFINITY}, b[] = {3, -1.5, -2.5, 0.5, NAN, -0.5, 1.5, 1};
    struct vw_full_agreement agreement = compare(a, b, NULL, 8);
    assert_int_equal(agreement.photos, 5);
    assert_near(agreement.values[VW_AGREEMENT_PEARSON], 0.8, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_SAME_SIGN], 0.6, ROUNDING);
}

TEST(where_nothing_can_be_said) {
    const double equal[] = {-1, -1, -1}, other[] = {-3, -2, -1}, positive[] = {1, 2, 3}, lost[] = {NAN, NAN, NAN};
    struct vw_full_agreement agreement = compare(equal, other, NULL, 3);
    assert_true(isnan(agreement.values[VW_AGREEMENT_PEARSON]) && isnan(agreement.values[VW_AGREEMENT_SPEARMAN]));
    assert_true(isnan(agreement.values[VW_AGREEMENT_POSITIVE_JACCARD])); // no set to agree on
    assert_near(agreement.values[VW_AGREEMENT_SAME_SIGN], 1, ROUNDING);
    assert_true(isnan(agreement.values[VW_AGREEMENT_SIGN_KAPPA])); // nothing beyond chance can be told
    agreement = compare(other, positive, NULL, 3);
    assert_near(agreement.values[VW_AGREEMENT_PEARSON], 1, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_POSITIVE_JACCARD], 0, ROUNDING);
    assert_near(agreement.values[VW_AGREEMENT_SIGN_KAPPA], 0, ROUNDING);
    agreement = compare(positive, positive, NULL, 1);
    assert_true(isnan(agreement.values[VW_AGREEMENT_PEARSON]) && isnan(agreement.values[VW_AGREEMENT_SPEARMAN]));
    assert_near(agreement.values[VW_AGREEMENT_POSITIVE_JACCARD], 1, ROUNDING);
    agreement = compare(lost, positive, NULL, 3);
    assert_int_equal(agreement.photos, 0);
    for (int i = 0; i < VW_AGREEMENT_COUNT; i++) assert_true(isnan(agreement.values[i]));
}

TEST(pairs_are_summarised) {
    double values[] = {1,      2, 3, /**/ 3,   2,   1,
                       /**/ 2, 1, 3, /**/ NAN, NAN, NAN}; // r: -1, 0.5, -0.5; the last run has none
    struct vw_score_table table = {.method = "some", .unit = "dB", .values = values};
    struct vw_score_tables tables = {.run_count = 4, .photo_count = 3, .tables = &table, .count = 1};
    AUTO_FREE struct vw_full_agreement *pairs = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_full_agreement_of_pairs(&tables, &table, &pairs, &count));
    assert_int_equal(count, 6);
    struct vw_agreement_summary summary = vw_full_agreement_summarise(pairs, count, VW_AGREEMENT_PEARSON);
    assert_int_equal(summary.pairs, 3);
    assert_near(summary.mean, -1.0 / 3, ROUNDING);
    assert_near(summary.lowest, -1, ROUNDING);
    assert_near(summary.highest, 0.5, ROUNDING);
    assert_near(pairs[1].values[VW_AGREEMENT_PEARSON], 0.5, ROUNDING);
    summary = vw_full_agreement_summarise(pairs, count, VW_AGREEMENT_CLEAN_PEARSON);
    assert_true(summary.pairs == 0 && isnan(summary.mean) && isnan(summary.lowest) && isnan(summary.highest));
}

// ---- From ledgers ---------------------------------------------------------------------------------------------------

static struct vw_value_input input_of(const struct test_recording *training, const struct vw_ledger_image *images) {
    struct vw_value_input input = test_value_input(training->records, training->count);
    input.images = images;
    return input;
}

static struct test_recording *train(uint32_t epochs, uint64_t seed) {
    struct test_trainer trainer = test_four_epochs;
    trainer.epochs = epochs;
    trainer.seed = seed;
    return test_record(&trainer);
}

// The first epochs of a longer run are the run of so many epochs.
TEST(first_epochs_are_scored_as_a_run_of_their_own) {
    AUTO_FREE struct test_recording *longer = train(9, 1), *shorter = train(4, 1), *other = train(4, 2);
    struct vw_value_input runs[] = {input_of(longer, test_images), input_of(other, test_images)};
    struct vw_value_input wanted[] = {input_of(shorter, test_images), input_of(other, test_images)};
    struct vw_score_tables first, whole;
    ASSERT_OK(vw_score_tables_make(runs, 2, 4, &first));
    ASSERT_OK(vw_score_tables_make(wanted, 2, UINT32_MAX, &whole));
    assert_int_equal(first.photo_count, TEST_TRAIN_COUNT);
    assert_true(first.count >= 2 && first.count == whole.count);
    for (uint32_t i = 0; i < first.count; i++) {
        assert_string_equal(first.tables[i].method, whole.tables[i].method);
        assert_memory_equal(first.tables[i].values, whole.tables[i].values, 2 * TEST_TRAIN_COUNT * sizeof(double));
    }
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) {
        assert_int_equal(first.photos[i], test_train_views[i]);
        assert_int_equal(first.clean[i], i != 1 && i != 3);
    }
    const struct vw_score_table *table = vw_score_tables_find(&first, "dv_psnr");
    assert_non_null(table);
    assert_true(table->values[0] > 0 && table->values[TEST_TRAIN_COUNT + 3] < 0); // one value from each run
    assert_null(vw_score_tables_find(&first, "none"));
    vw_score_tables_free(&first);
    vw_score_tables_free(&whole);
    ASSERT_OK(vw_score_tables_make(runs, 2, 1, &first)); // burn-in alone
    assert_int_equal(first.count, 0);
    vw_score_tables_free(&first);
}

// A run that has no step after burn-in has no score of any method: its places are NaN, and the others' pairs stay.
TEST(a_run_without_scores_takes_no_part) {
    AUTO_FREE struct test_recording *full = train(4, 1), *other = train(4, 2), *burned = train(1, 3);
    struct vw_value_input runs[] = {input_of(burned, test_images), input_of(full, test_images),
                                    input_of(other, test_images)};
    AUTO(vw_score_tables_free) struct vw_score_tables tables;
    ASSERT_OK(vw_score_tables_make(runs, 3, 4, &tables));
    const struct vw_score_table *table = vw_score_tables_find(&tables, "dv_loss");
    assert_non_null(table);
    AUTO_FREE struct vw_full_agreement *pairs = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_full_agreement_of_pairs(&tables, table, &pairs, &count));
    assert_true(isnan(table->values[0]) && isfinite(table->values[TEST_TRAIN_COUNT]));
    assert_int_equal(pairs[0].photos, 0);
    assert_int_equal(pairs[2].photos, TEST_TRAIN_COUNT);
    assert_int_equal(pairs[2].clean, 3);
    assert_int_equal(vw_full_agreement_summarise(pairs, count, VW_AGREEMENT_PEARSON).pairs, 1);
}

TEST(truth_is_not_made_up) {
    AUTO_FREE struct test_recording *training = train(4, 1);
    struct vw_ledger_image images[TEST_IMAGE_COUNT];
    for (int i = 0; i < TEST_IMAGE_COUNT; i++) {
        images[i] = test_images[i];
        images[i].ground_truth = NULL;
    }
    struct vw_value_input run = input_of(training, images);
    AUTO(vw_score_tables_free) struct vw_score_tables tables;
    ASSERT_OK(vw_score_tables_make(&run, 1, 4, &tables));
    assert_null(tables.clean);
}

TEST(runs_on_other_photos_are_refused) {
    AUTO_FREE struct test_recording *training = train(4, 1);
    struct vw_ledger_image images[TEST_IMAGE_COUNT];
    memcpy(images, test_images, sizeof images);
    images[3].name = "images/other.png";
    struct vw_value_input runs[] = {input_of(training, test_images), input_of(training, images)};
    AUTO(vw_score_tables_free) struct vw_score_tables tables;
    ASSERT_FAILS(vw_score_tables_make(runs, 2, 4, &tables), VW_ERROR_INPUT, "run 2");
}
