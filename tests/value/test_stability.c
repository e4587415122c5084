// The rule by which scores count as stable: it depends on records alone, and ignores those after the last complete
// epoch.
#include "support/ledger_fixture.h"

#include "value/stability.h"
#include "viewworth/value.h"

static struct test_recording *train(double noise_db, uint32_t epochs) {
    const struct test_trainer trainer = {{0.5, -0.2, 0.1, -0.3, 0.2}, noise_db, 10, epochs, 3};
    return test_record(&trainer);
}

// Begins `watch`, which is zero before, and adds the records; the caller ends it.
static void watch_records(const struct test_recording *training, uint32_t record_count, uint32_t burn_in_epochs,
                          struct vw_stability_watch *watch) {
    ASSERT_OK(vw_stability_watch_begin(test_train_views, TEST_TRAIN_COUNT, burn_in_epochs, watch));
    for (uint32_t i = 0; i < record_count; i++) ASSERT_OK(vw_stability_watch_add(watch, &training->records[i]));
}

static struct vw_stability measure(const struct test_recording *training, uint32_t record_count,
                                   uint32_t burn_in_epochs) {
    struct vw_stability_watch watch = {0};
    struct vw_stability stability;
    watch_records(training, record_count, burn_in_epochs, &watch);
    ASSERT_OK(vw_stability_watch_measure(&watch, &stability));
    vw_stability_watch_end(&watch);
    return stability;
}

static struct vw_stability measure_epochs(const struct test_recording *training, uint32_t epochs,
                                          uint32_t burn_in_epochs) {
    return measure(training, 1 + epochs * TEST_TRAIN_COUNT, burn_in_epochs);
}

TEST(photos_that_differ_are_stable_once_enough_epochs_count) {
    AUTO_FREE struct test_recording *training = train(0, 20);
    for (uint32_t burn_in = 0; burn_in < 3; burn_in++)
        for (uint32_t epochs = 0; epochs <= 20; epochs++) {
            struct vw_stability stability = measure_epochs(training, epochs, burn_in);
            assert_int_equal(stability.epochs, epochs > burn_in ? epochs - burn_in : 0);
            assert_int_equal(stability.earlier_epochs, stability.epochs / 2);
            bool enough = stability.epochs >= VW_STABILITY_EPOCHS_MIN;
            assert_true(enough ? stability.correlation > 1 - 1e-12 : isnan(stability.correlation)); // 1 to rounding
            assert_int_equal(vw_stability_reaches(&stability, 0.99), enough);
        }
}

// Photo 1's deltas turn from +1 to -1 after the sixth of the epochs that count, the others' do not change: 0.11, 0.22,
// 0.33, 0.44. After 5 or 6 it is the best. After 10 it has 2, the second lowest: ranks 5 1 2 3 4 and 2 1 3 4 5
// correlate by 0.4. From 11 on, when it has 1, it is the worst: by 0. After 22, when half the epochs agree again, the
// last ends give 0.9, 0.9 and 1.
TEST(ranks_that_turn_are_not) {
    AUTO_FREE struct test_recording *training = train(0, 25);
    double psnr = training->records[0].val_psnr = 10;
    for (uint32_t i = 1; i < training->count; i++) {
        struct vw_step_record *record = &training->records[i];
        double worth = 0;
        for (uint32_t t = 1; t < TEST_TRAIN_COUNT; t++)
            if (record->view == test_train_views[t]) worth = 0.11 * t;
        if (record->view == test_train_views[0]) worth = record->epoch <= 6 ? 1 : -1;
        record->val_psnr = psnr += worth;
    }
    const struct {
        uint32_t epochs;
        double correlation;
    } cases[] = {{10, 0.4}, {11, 0}, {12, 0}, {13, 0}, {14, 0}, {22, 0.9}, {24, 1}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_stability stability = measure_epochs(training, 1 + cases[i].epochs, 1);
        assert_int_equal(stability.epochs, cases[i].epochs);
        assert_int_equal(stability.earlier_epochs, cases[i].epochs / 2);
        if (!(fabs(stability.correlation - cases[i].correlation) <= 1e-12))
            fail_msg("after %u epochs the ranks correlate by %g, not %g", cases[i].epochs, stability.correlation,
                     cases[i].correlation);
        assert_false(vw_stability_reaches(&stability, cases[i].correlation + 0.01));
    }
}

TEST(an_incomplete_epoch_is_left_out) {
    AUTO_FREE struct test_recording *training = train(0.4, 12);
    const struct vw_stability whole = measure_epochs(training, 11, 1);
    assert_true(whole.correlation < 1); // the noise is large enough to tell epochs apart
    for (uint32_t extra = 0; extra < TEST_TRAIN_COUNT; extra++) {
        struct vw_stability stability = measure(training, 1 + 11 * TEST_TRAIN_COUNT + extra, 1);
        assert_int_equal(stability.epochs, 10);
        assert_true(stability.correlation == whole.correlation);
    }
    struct vw_stability next = measure_epochs(training, 12, 1);
    assert_int_equal(next.epochs, 11);
}

TEST(nothing_is_never_stable) {
    AUTO_FREE struct test_recording *training = train(0, 12);
    struct vw_stability none = measure(training, 0, 1);
    assert_true(none.epochs == 0 && isnan(none.correlation));
    for (uint32_t i = 0; i < training->count; i++) training->records[i].val_psnr = 10; // photos that do not differ
    struct vw_stability flat = measure_epochs(training, 12, 1);
    assert_true(isnan(flat.correlation));
    assert_false(vw_stability_reaches(&flat, 1e-9));
    for (uint32_t i = 0; i < training->count; i++)
        training->records[i].val_psnr = NAN; // a run without validation has no scores
    struct vw_stability blind = measure_epochs(training, 12, 1);
    assert_true(blind.epochs == 11 && isnan(blind.correlation));
}

// After every epoch the sums are the default method's scores of a run that ended there, to the bit.
TEST(sums_are_the_scores_of_the_epochs_so_far) {
    AUTO_FREE struct test_recording *training = train(0.4, 12);
    training->records[7].val_psnr = NAN; // a step without a value, and a photo without a visit in its epoch
    training->records[7].nonfinite = true;
    AUTO(vw_stability_watch_end) struct vw_stability_watch watch = {0};
    watch_records(training, training->count, 1, &watch);
    assert_int_equal(watch.epoch_count, 11);
    for (uint32_t epoch = 0; epoch < watch.epoch_count; epoch++) {
        const struct vw_value_input input = test_value_input(training->records, 1 + (epoch + 2) * TEST_TRAIN_COUNT);
        AUTO_FREE struct vw_ledger_score *scores = NULL;
        uint32_t count = 0;
        ASSERT_OK(vw_value_score(&input, &scores, &count));
        for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
            const struct vw_ledger_score *score =
                test_find_score(scores, count, vw_value_default_method, test_train_views[photo]);
            double sum = watch.sums[epoch * TEST_TRAIN_COUNT + photo];
            assert_true(score->visits ? sum == score->value : isnan(sum));
        }
    }
}

TEST(a_step_on_another_photo_is_refused) {
    AUTO(vw_stability_watch_end) struct vw_stability_watch watch = {0};
    ASSERT_OK(vw_stability_watch_begin(test_train_views, TEST_TRAIN_COUNT, 0, &watch));
    const struct vw_step_record record = {.step = 1, .view = 1000, .val_psnr = 10};
    ASSERT_FAILS(vw_stability_watch_add(&watch, &record), VW_ERROR_INPUT, "image 1000");
}
