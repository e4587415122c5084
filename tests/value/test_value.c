// Scores against a fake trainer whose photos' worths are known, and the SQL that recomputes them.
#include "support/ledger_fixture.h"

#include <sqlite3.h>

#include "viewworth/value.h"

static const double worth_db[TEST_TRAIN_COUNT] = {0.5, -0.2, 0.1, -0.3, 0.2};

static struct test_recording *train(double noise_db, uint32_t epochs, uint64_t seed) {
    struct test_trainer trainer = {.noise_db = noise_db, .first_epoch_factor = 10, .epochs = epochs, .seed = seed};
    memcpy(trainer.worth_db, worth_db, sizeof worth_db);
    return test_record(&trainer);
}

static void flag(struct test_recording *training, uint32_t step) {
    struct vw_step_record *record = &training->records[step];
    record->nonfinite = true;
    record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
}

static struct vw_value_input input_of(const struct test_recording *training, uint32_t burn_in_epochs) {
    struct vw_value_input input = test_value_input(training->records, training->count);
    input.burn_in_epochs = burn_in_epochs;
    return input;
}

static struct vw_ledger_score *score(const struct test_recording *training, uint32_t burn_in_epochs, uint32_t *count) {
    struct vw_value_input input = input_of(training, burn_in_epochs);
    struct vw_ledger_score *scores = NULL;
    ASSERT_OK(vw_value_score(&input, &scores, count));
    return scores;
}

static const double ROUNDING = 1e-12;

TEST(burn_in_leaves_epochs_out) {
    AUTO_FREE struct test_recording *training = train(0, 4, 3);
    const double expected[] = {13, 3, 2, 1}; // visits' worth of photo 1: the first epoch counts tenfold
    uint32_t count = 0;
    for (uint32_t burn_in = 0; burn_in < 4; burn_in++) {
        AUTO_FREE struct vw_ledger_score *scores = score(training, burn_in, &count);
        const struct vw_ledger_score *first = test_find_score(scores, count, "dv_psnr", 1);
        assert_near(first->value, expected[burn_in] * worth_db[0], ROUNDING);
        assert_int_equal(first->visits, 4 - burn_in);
        assert_int_equal(isnan(first->standard_error), burn_in == 3); // one visit has none
    }
    free(score(training, 4, &count));
    assert_int_equal(count, 0);
}

// Three visits with deltas 1, 2 and 6. How large the standard error is, is the matter of value/uncertainty.h.
TEST(what_was_visited_has_a_standard_error) {
    struct test_recording training = {.count = 4};
    const double psnr[] = {10, 11, 13, 19};
    for (uint32_t i = 0; i < training.count; i++)
        training.records[i] = test_step(i, i ? i - 1 : 0, i ? 3 : (uint32_t)VW_RECORD_UNTRAINED, psnr[i]);
    uint32_t count = 0;
    AUTO_FREE struct vw_ledger_score *scores = score(&training, 0, &count);
    const struct vw_ledger_score *third = test_find_score(scores, count, "dv_psnr", 3);
    assert_near(third->value, 9, ROUNDING);
    assert_true(third->standard_error > 0 && third->ci_low < 9 && third->ci_high > 9);
    assert_int_equal(third->visits, 3);
    const struct vw_ledger_score *unvisited = test_find_score(scores, count, "dv_psnr", 5);
    assert_true(unvisited->value == 0 && unvisited->visits == 0 && isnan(unvisited->standard_error));
}

// The delta of the first step after burn-in is taken from the last value within it, and step 0 may lack a value.
TEST(a_flagged_start_is_no_delta) {
    AUTO_FREE struct test_recording *training = train(0, 1, 3);
    flag(training, 0);
    uint32_t count = 0, visits = 0;
    AUTO_FREE struct vw_ledger_score *scores = score(training, 0, &count);
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) visits += scores[i].visits;
    assert_int_equal(visits, TEST_TRAIN_COUNT - 1);
    for (uint32_t step = 0; step < training->count; step++) flag(training, step); // as a run without validation
    free(score(training, 0, &count));
    assert_int_equal(count, 0);
    free(score(&(struct test_recording){.count = 0}, 0, &count));
    assert_int_equal(count, 0);
}

// A table of photos and epochs would take 3 GB for a ledger of 7 MB.
TEST(epochs_that_no_training_has_are_refused) {
    enum { STEPS = 20000 };
    enum { IMAGES = 2000 };
    AUTO_FREE struct test_recording *training = train(0, 3, 3);
    AUTO_FREE struct vw_step_record *records = vw_allocate(STEPS, sizeof *records);
    AUTO_FREE struct vw_ledger_image *images = vw_allocate(IMAGES, sizeof *images);
    for (uint32_t i = 0; i < IMAGES; i++) images[i] = (struct vw_ledger_image){.image_id = i, .split = "train"};
    struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    for (uint32_t i = 0; i < STEPS; i++) {
        records[i] = training->records[1 + i % 3];
        records[i].step = i;
        records[i].epoch = i * 100;
    }
    struct vw_value_input input = input_of(training, 1);
    input.records = records;
    input.record_count = STEPS;
    input.images = images;
    input.image_count = IMAGES;
    ASSERT_FAILS(vw_value_score(&input, &scores, &count), VW_ERROR_INPUT, "too many for 20000 steps");
    assert_null(scores);
}

// ---- The query that recomputes scores ----

// Records a noisy run with two flagged steps under `folder`/`name`/ledger.db; the scores are given back.
static struct vw_ledger_score *record_run(const char *folder, const char *name, const char *config_json,
                                          uint32_t burn_in_epochs, uint64_t seed, uint32_t *count) {
    AUTO_FREE struct test_recording *training = train(0.4, TEST_EPOCHS_MOST, seed);
    flag(training, 33);
    flag(training, 34);
    AUTO_FREE char *out = vw_path_join(folder, name), *path = vw_path_join(out, "ledger.db");
    struct vw_ledger_run run = test_run(config_json);
    struct vw_ledger *ledger = NULL;
    AUTO_FREE struct vw_step_record *records = NULL;
    struct vw_ledger_score *scores = NULL;
    uint64_t record_count = 0;
    ASSERT_OK(vw_folder_create(out));
    ASSERT_OK(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger));
    ASSERT_OK(vw_ledger_append(ledger, training->records, training->count, test_validation_views));
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &record_count));
    struct vw_value_input input = input_of(training, burn_in_epochs);
    input.records = records;
    input.record_count = record_count;
    ASSERT_OK(vw_value_score(&input, &scores, count));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scores, *count));
    vw_ledger_close(&ledger);
    return scores;
}

static void compare_with_query(const char *path, const char *sql, const struct vw_ledger_score *scores,
                               uint32_t count) {
    sqlite3 *raw = NULL;
    sqlite3_stmt *statement = NULL;
    uint32_t rows = 0;
    assert_int_equal(sqlite3_open_v2(path, &raw, SQLITE_OPEN_READONLY, NULL), SQLITE_OK);
    if (sqlite3_prepare_v2(raw, sql, -1, &statement, NULL) != SQLITE_OK)
        fail_msg("scripts/dv_psnr.sql: %s", sqlite3_errmsg(raw));
    assert_string_equal(sqlite3_column_name(statement, 3), "dv_psnr");
    for (; sqlite3_step(statement) == SQLITE_ROW; rows++) {
        const struct vw_ledger_score *expected =
            test_find_score(scores, count, "dv_psnr", (uint32_t)sqlite3_column_int(statement, 1));
        double value = sqlite3_column_double(statement, 3);
        if (!(fabs(value - expected->value) <= 1e-9))
            fail_msg("scripts/dv_psnr.sql gives image %u %.12g, not %.12g", expected->image_id, value, expected->value);
        assert_int_equal(sqlite3_column_int(statement, 4), expected->visits);
    }
    assert_int_equal(rows, TEST_TRAIN_COUNT);
    sqlite3_finalize(statement);
    sqlite3_close(raw);
}

FOLDER_TEST(the_query_reproduces_dv_psnr) {
    AUTO_FREE void *sql = temporary_read(VW_SOURCE_FOLDER "/scripts/dv_psnr.sql", NULL);
    const struct {
        const char *name, *config_json;
        uint32_t burn_in_epochs;
    } runs[] = {{"three", "{\"burn_in_epochs\": 3}", 3}, {"none", "{\"burn_in_epochs\": 0}", 0}, {"default", "{}", 1}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(runs); i++) {
        uint32_t count = 0;
        AUTO_FREE struct vw_ledger_score *scores =
            record_run(*state, runs[i].name, runs[i].config_json, runs[i].burn_in_epochs, 7, &count);
        AUTO_FREE char *path = vw_format_text("%s/%s/ledger.db", (const char *)*state, runs[i].name);
        compare_with_query(path, sql, scores, count);
    }
}
