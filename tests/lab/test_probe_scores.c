// Noise and scores of probes, from rows whose results are counted by hand.
#include "support/ledger_fixture.h"

#include "base/memory.h"
#include "lab/probes/probe_scores.h"

enum { PSNR = 20 }; // PSNR in dB of every state whose photos are tried

// PSNR in dB; L1 is a hundredth, so that what is worked out for one holds for both. Step 7 is flagged.
static const struct {
    uint32_t view;
    double psnr;
} steps[] = {
    {VW_RECORD_UNTRAINED, PSNR}, {3, 11}, {3, 13}, {5, PSNR}, {3, PSNR}, {5, PSNR}, {6, 15}, {3, NAN}, {5, PSNR}};

static const struct {
    uint64_t step;
    enum vw_probe_kind kind;
    uint32_t view;
    double psnr;
} rows[] = {
    {2, VW_PROBE_REPEATED, 3, 11},         {2, VW_PROBE_ZERO_LEARNING_RATE, 3, 11},
    {2, VW_PROBE_RESAMPLED, 3, 13},        {2, VW_PROBE_RESAMPLED, 3, 16}, // with 13: mean 14, variance 6 / 2
    {3, VW_PROBE_REPEATED, 5, 13.5},       {3, VW_PROBE_ZERO_LEARNING_RATE, 5, 12.75},
    {4, VW_PROBE_SAME_STATE, 3, PSNR + 1}, // state means of photo 3: 2 and 4; variances: 2 and 0
    {4, VW_PROBE_SAME_STATE, 3, PSNR + 3}, {4, VW_PROBE_SAME_STATE, 5, PSNR - 1}, // one state: -1
    {4, VW_PROBE_SAME_STATE, 5, NAN},      {6, VW_PROBE_RESAMPLED, 6, NAN},       // with 15: a single value
    {7, VW_PROBE_RESAMPLED, 3, 20},        {7, VW_PROBE_RESAMPLED, 3, 22},        // variance 2
    {7, VW_PROBE_SAME_STATE, 5, 9}, // after it there is no value to compare with
    {8, VW_PROBE_REPEATED, 5, 14.75},      {8, VW_PROBE_SAME_STATE, 3, PSNR + 4},
    {8, VW_PROBE_SAME_STATE, 3, PSNR + 4},
};

struct fixture {
    struct vw_step_record records[VW_ARRAY_COUNT(steps)];
    struct vw_probe probes[VW_ARRAY_COUNT(rows)];
    struct vw_ledger_score scores[3];
};

static struct vw_probed_run make_run(struct fixture *fixture) {
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(steps); i++)
        fixture->records[i] = (struct vw_step_record){
            .step = i, .view = i ? steps[i].view : 0, .val_psnr = steps[i].psnr, .val_l1 = steps[i].psnr / 100};
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(rows); i++)
        fixture->probes[i] = (struct vw_probe){.step = rows[i].step,
                                               .index = i,
                                               .kind = rows[i].kind,
                                               .view = rows[i].view,
                                               .val_psnr = rows[i].psnr,
                                               .val_l1 = rows[i].psnr / 100};
    fixture->scores[0] = (struct vw_ledger_score){.image_id = 3, .method = "dv_psnr", .value = 0.5, .visits = 2};
    fixture->scores[1] = (struct vw_ledger_score){.image_id = 3, .method = "dv_loss", .value = 0.5, .visits = 8};
    fixture->scores[2] = (struct vw_ledger_score){.image_id = 6, .method = "dv_psnr", .value = 0.5, .visits = 1};
    return (struct vw_probed_run){.records = fixture->records,
                                  .probes = fixture->probes,
                                  .images = test_images,
                                  .scores = fixture->scores,
                                  .probe_count = VW_ARRAY_COUNT(rows),
                                  .image_count = TEST_IMAGE_COUNT,
                                  .score_count = VW_ARRAY_COUNT(fixture->scores)};
}

static void check_near(double value, double expected, const char *what) {
    if (isnan(expected) ? !isnan(value) : !(fabs(value - expected) <= 1e-12))
        fail_msg("%s is %.17g, not %.17g", what, value, expected);
}

static const struct vw_probe_score *find(const struct vw_probe_score *scores, uint32_t count, const char *method,
                                         uint32_t image_id) {
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(scores[i].method, method) == 0 && scores[i].image_id == image_id) return &scores[i];
    fail_msg("no %s of image %u", method, image_id);
    return NULL;
}

TEST(scores_are_those_counted_by_hand) {
    const struct {
        const char *method;
        uint32_t image_id, visits;
        double value, standard_error, resampling_stderr;
    } cases[] = {
        {"same_state_psnr", 3, 4, 3, sqrt(2.0 / 2), sqrt((2 + 0) / 2.0 / 4)},
        {"same_state_psnr", 5, 1, -1, NAN, NAN}, // one value cannot tell
        {"same_state_psnr", 1, 0, 0, NAN, NAN},  // not probed
        {"dv_psnr", 3, 2, 0.5, 0, sqrt(2 * 2.5)},
        {"dv_loss", 3, 8, 0.5, 0, 0.01 * sqrt(8 * 2.5)},
        {"dv_psnr", 6, 1, 0.5, 0, NAN},
    };
    struct fixture fixture;
    struct vw_probed_run run = make_run(&fixture);
    struct vw_probe_score *scores = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_probe_scores_make(&run, &scores, &count));
    assert_int_equal(count, TEST_TRAIN_COUNT + run.score_count);
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) assert_int_equal(scores[i].image_id, test_train_views[i]);
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct vw_probe_score *score = find(scores, count, cases[i].method, cases[i].image_id);
        assert_int_equal(score->visits, cases[i].visits);
        check_near(score->value, cases[i].value, "the score");
        check_near(score->standard_error, cases[i].standard_error, "its standard error");
        check_near(score->resampling_stderr, cases[i].resampling_stderr, "its sampling error");
    }
    free(scores);
    for (uint32_t i = 0; i < run.probe_count; i++) fixture.probes[i].kind = VW_PROBE_RESAMPLED;
    ASSERT_OK(vw_probe_scores_make(&run, &scores, &count));
    assert_int_equal(count, run.score_count); // no state was probed
    free(scores);
}

TEST(noise_is_of_all_probes) {
    struct fixture fixture;
    struct vw_probed_run run = make_run(&fixture);
    struct vw_noise_floor floor;
    vw_noise_floor_find(&run, &floor);
    assert_int_equal(floor.repeated_count, 2); // step 8 has nothing to compare it with
    assert_int_equal(floor.zero_learning_rate_count, 2);
    assert_int_equal(floor.resampled_count, 4);
    check_near(floor.repeated_db, 0.5, "the largest delta of a repeat"); // upwards; at learning rate 0 downwards
    check_near(floor.zero_learning_rate_db, 0.25, "the largest delta of a step with learning rate 0");
    check_near(floor.resampled_db, sqrt((3 + 2) / 2.0), "the spread of redraws in dB");
    check_near(floor.resampled_l1, 0.01 * sqrt((3 + 2) / 2.0), "the spread of redraws in L1");
    run.probe_count = 1;
    vw_noise_floor_find(&run, &floor);
    assert_true(floor.repeated_count == 1 && floor.zero_learning_rate_count == 0 && floor.resampled_count == 0);
    assert_true(floor.repeated_db == 0); // exactly
    assert_true(isnan(floor.zero_learning_rate_db) && isnan(floor.resampled_db) && isnan(floor.resampled_l1));
}
