// Scores of probes, from rows whose scores are counted by hand.
#include "support/ledger_fixture.h"

#include "value/probe_scores.h"
#include "viewworth/value.h"

enum { PSNR = 20 }; // of every state

// Steps 4 and 8 end epochs; the photos are 3 and 5.
static const struct {
    uint64_t step;
    uint32_t epoch, view;
    double psnr;
} steps[] = {{0, 0, VW_RECORD_UNTRAINED, PSNR},
             {1, 0, 3, PSNR},
             {2, 0, 5, PSNR},
             {3, 1, 3, PSNR},
             {4, 1, 5, PSNR},
             {5, 2, 5, PSNR},
             {6, 2, 3, PSNR},
             {7, 3, 3, NAN},
             {8, 3, 5, PSNR}};

enum { OWN = VW_RECORD_UNTRAINED };
static const struct probe_row {
    uint64_t step;
    enum vw_probe_kind kind;
    uint32_t view;
    double psnr; // the change in dB; of L1 it is -0.01 times that
} rows[] = {
    {2, VW_PROBE_SAME_STATE, 3, 100},                                  // in burn-in
    {4, VW_PROBE_RESAMPLED, OWN, 7},                                   // of another kind
    {4, VW_PROBE_SAME_STATE, 3, 1},                                    // state means: 2 and 4; variances: 2 and 0
    {4, VW_PROBE_SAME_STATE, 3, 3},   {4, VW_PROBE_SAME_STATE, 5, -1}, // one state: -1
    {4, VW_PROBE_SAME_STATE, 5, NAN}, {7, VW_PROBE_SAME_STATE, 5, 9},  // behind it there is no value to compare with
    {8, VW_PROBE_SAME_STATE, 3, 4},   {8, VW_PROBE_SAME_STATE, 3, 4},
};

struct probed_run {
    struct vw_step_record records[VW_ARRAY_COUNT(steps)];
    struct vw_probe probes[VW_ARRAY_COUNT(rows)];
};

static struct vw_value_input make_run(struct probed_run *run) {
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(steps); i++)
        run->records[i] = (struct vw_step_record){.step = steps[i].step,
                                                  .epoch = steps[i].epoch,
                                                  .view = steps[i].view,
                                                  .validated = true,
                                                  .val_psnr = steps[i].psnr,
                                                  .val_psnr_pooled = steps[i].psnr,
                                                  .val_l1 = steps[i].psnr / 100};
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(rows); i++) {
        double psnr = PSNR + rows[i].psnr, l1 = PSNR / 100.0 - 0.01 * rows[i].psnr;
        run->probes[i] = (struct vw_probe){rows[i].step, i, rows[i].kind, psnr, psnr, l1, rows[i].view};
    }
    return (struct vw_value_input){.records = run->records,
                                   .record_count = VW_ARRAY_COUNT(steps),
                                   .probes = run->probes,
                                   .probe_count = VW_ARRAY_COUNT(rows),
                                   .burn_in_epochs = 1,
                                   .images = test_images,
                                   .image_count = TEST_IMAGE_COUNT};
}

static void check_near(double value, double expected, const char *what) {
    if (isnan(expected) ? !isnan(value) : !(fabs(value - expected) <= 1e-12))
        fail_msg("%s is %.17g, not %.17g", what, value, expected);
}

TEST(scores_are_those_counted_by_hand) {
    const struct {
        uint32_t image_id, visits;
        double value, standard_error, resampling_stderr;
    } cases[] = {
        {3, 4, 3, sqrt(2.0 / 2), sqrt((2 + 0) / 2.0 / 4)},
        {5, 1, -1, NAN, NAN}, // one value cannot tell
        {1, 0, 0, NAN, NAN},  // not probed
    };
    struct probed_run run;
    struct vw_value_input input = make_run(&run);
    struct vw_ledger_score scores[TEST_IMAGE_COUNT];
    uint32_t count = 0;
    ASSERT_OK(vw_probe_scores_append(&input, scores, &count));
    assert_int_equal(count, TEST_TRAIN_COUNT);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct vw_ledger_score *score = test_find_score(scores, count, "same_state_psnr", cases[i].image_id);
        assert_int_equal(score->visits, cases[i].visits);
        check_near(score->value, cases[i].value, "the score");
        check_near(score->standard_error, cases[i].standard_error, "its standard error");
        check_near(score->resampling_stderr, cases[i].resampling_stderr, "its sampling error");
        assert_true(isnan(score->ci_low) && isnan(score->ci_high)); // no interval from so few states
    }
}

// They stand behind what is there already, in the order of the images.
TEST(a_run_without_probes_has_no_scores) {
    struct probed_run run;
    struct vw_value_input input = make_run(&run);
    struct vw_ledger_score scores[2 * TEST_IMAGE_COUNT] = {{.method = "other"}};
    uint32_t count = 1;
    ASSERT_OK(vw_probe_scores_append(&input, scores, &count));
    assert_int_equal(count, 1 + TEST_TRAIN_COUNT);
    assert_string_equal(scores[0].method, "other");
    for (uint32_t i = 1; i < count; i++) {
        assert_string_equal(scores[i].method, "same_state_psnr");
        assert_int_equal(scores[i].image_id, test_train_views[i - 1]);
    }
    count = 0;
    for (uint32_t i = 0; i < input.probe_count; i++) run.probes[i].kind = VW_PROBE_RESAMPLED;
    ASSERT_OK(vw_probe_scores_append(&input, scores, &count));
    assert_int_equal(count, 0);
    input = make_run(&run);
    input.burn_in_epochs = 4;
    ASSERT_OK(vw_probe_scores_append(&input, scores, &count));
    assert_int_equal(count, 0);
}

// vw_value_score has them behind its own, which are what they are without.
TEST(they_stand_behind_the_other_scores) {
    struct probed_run run;
    struct vw_value_input input = make_run(&run);
    AUTO_FREE struct vw_ledger_score *with = NULL, *without = NULL;
    struct vw_noise_floor floor;
    uint32_t with_count = 0, without_count = 0;
    ASSERT_OK(vw_value_score(&input, &with, &with_count));
    vw_value_noise_floor(&input, &floor);
    assert_true(floor.resampled_count == 1 && floor.repeated_count == 0 && floor.zero_learning_rate_count == 0 &&
                isnan(floor.zero_learning_rate_db)); // of those rows but one is of noise
    input.probe_count = 0;
    ASSERT_OK(vw_value_score(&input, &without, &without_count));
    assert_int_equal(with_count, without_count + TEST_TRAIN_COUNT);
    for (uint32_t i = 0; i < without_count; i++) {
        assert_string_equal(with[i].method, without[i].method);
        assert_true(with[i].value == without[i].value && with[i].visits == without[i].visits);
    }
}

TEST(an_unknown_photo_is_an_error) {
    struct probed_run run;
    struct vw_value_input input = make_run(&run);
    struct vw_ledger_score scores[TEST_IMAGE_COUNT];
    uint32_t count = 0;
    run.probes[3].view = 1000;
    ASSERT_FAILS(vw_probe_scores_append(&input, scores, &count), VW_ERROR_INPUT, "step 4: probe 3 is of image 1000");
}
