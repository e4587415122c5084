// Runs that continue in their ledger: append after append, after its end, and after failures, which change nothing.
#include "support/ledger_chain.h"

#include "ledger/ledger_private.h"

FOLDER_TEST(steps_must_follow_each_other) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_create(path);
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    const struct vw_step_record *records = recording->records;
    assert_int_equal(vw_ledger_append(ledger, &records[1], 2, test_validation_views), VW_ERROR_USAGE);
    ASSERT_OK(vw_ledger_append(ledger, records, 3, test_validation_views));
    assert_int_equal(vw_ledger_append(ledger, &records[2], 2, test_validation_views), VW_ERROR_USAGE);
    assert_int_equal(vw_ledger_next_step(ledger), 3);
    assert_answer(path, "SELECT count(*) FROM step", "3");
}

static void assert_run(struct vw_ledger *ledger, const char *status, const char *config_json) {
    struct vw_ledger_run run;
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    assert_string_equal(run.status, status);
    assert_string_equal(run.config_json, config_json);
}

static void assert_head(struct vw_ledger *ledger, const char *path, const char *sql) {
    char head[VW_HASH_HEX_BYTES];
    vw_ledger_chain_head(ledger, head);
    assert_answer(path, sql, head);
}

// Records steps 0 to 2, ends the run as `ended` unless that is NULL, and goes on with more epochs.
static void go_on_after(const char *folder, const char *ended) {
    const char *config = "{\"burn_in_epochs\": 1}", *extended = "{\"burn_in_epochs\": 1, \"epochs\": 60}";
    AUTO_FREE char *whole = test_ledger_record(folder, "whole.db", &test_four_epochs, 6),
                   *path = vw_path_join(folder, "ledger.db");
    AUTO_FREE char *head = sql_ask(whole, "SELECT row_hash FROM step WHERE step = 5");
    struct vw_ledger *ledger = test_ledger_create(path);
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    assert_head(ledger, path, "SELECT row_hash FROM run");
    ASSERT_OK(vw_ledger_append(ledger, recording->records, 3, test_validation_views));
    assert_head(ledger, path, "SELECT row_hash FROM step WHERE step = 2");
    assert_run(ledger, "running", config);
    if (ended) {
        ASSERT_OK(vw_ledger_finish(ledger, ended, "2026-11-21T03:30:00Z", test_scores, 1));
        assert_run(ledger, ended, config);
        assert_head(ledger, path, SQL_FINAL_HASH);
    }
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    assert_head(ledger, path, ended ? SQL_FINAL_HASH : "SELECT row_hash FROM step WHERE step = 2");
    ASSERT_OK(vw_ledger_extend(ledger, extended));
    assert_run(ledger, ended ? ended : "running", config); // as yet nothing is written
    ASSERT_OK(vw_ledger_append(ledger, &recording->records[3], 3, test_validation_views));
    assert_run(ledger, "running", extended);
    assert_head(ledger, path, "SELECT row_hash FROM step WHERE step = 5");
    assert_answer(path, "SELECT count(*) FROM score", "0");
    assert_answer(path, "SELECT status FROM run WHERE finished_utc IS NULL", "running");
    assert_answer(path, "SELECT config_json FROM run", extended);
    assert_answer(path, "SELECT row_hash FROM step WHERE step = 5", head); // as if never interrupted
    assert_true(chain_holds(path));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", test_scores, 2));
    ASSERT_OK(vw_ledger_extend(ledger, config));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:01Z", &test_scores[2], 1)); // replaces
    assert_answer(path, "SELECT group_concat(method) FROM score", "dv_loss");
    assert_run(ledger, "finished", config);
    assert_head(ledger, path, SQL_FINAL_HASH);
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    unlink(whole);
    unlink(path);
}

FOLDER_TEST(a_run_can_go_on) {
    const char *const ends[] = {"finished", "interrupted", "failed", NULL};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ends); i++) go_on_after(*state, ends[i]);
}

// The field of an end is not that of the next one.
FOLDER_TEST(a_field_is_of_one_end) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = test_ledger_create(path);
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    struct vw_ledger_run run;
    ASSERT_OK(vw_ledger_append(ledger, recording->records, 3, test_validation_views));
    test_ledger_finish(ledger, "finished");
    assert_answer(path, "SELECT field_sha256 FROM run", HEX_B);
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    assert_string_equal(run.field_sha256, HEX_B);
    ASSERT_OK(vw_ledger_append(ledger, &recording->records[3], 3, test_validation_views));
    assert_answer(path, "SELECT field_sha256 FROM run", "NULL");
    ASSERT_OK(vw_ledger_finish(ledger, "interrupted", "2026-11-21T04:00:00Z", NULL, 0));
    assert_answer(path, "SELECT field_sha256 FROM run", "NULL");
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
}

// A finish that fails (two scores of one key) leaves the run as it was.
FOLDER_TEST(a_failed_finish_changes_nothing) {
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = test_ledger_create(path);
    const struct vw_ledger_score twice[] = {test_scores[0], test_scores[0]};
    AUTO_FREE char *final_hash = sql_ask(path, SQL_FINAL_HASH);
    ASSERT_OK(vw_ledger_extend(ledger, "{}"));
    assert_int_equal(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", twice, 2), VW_ERROR_IO);
    assert_run(ledger, "running", "{\"burn_in_epochs\": 1}");
    assert_head(ledger, path, "SELECT row_hash FROM run");
    assert_answer(path, SQL_FINAL_HASH, final_hash);
    assert_answer(path, "SELECT count(*) FROM score", "0");
    test_ledger_finish(ledger, "finished");
    assert_run(ledger, "finished", "{}");
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
}

static int count_changes(struct vw_ledger *ledger, const struct vw_step_record *record) {
    int before = sqlite3_total_changes(ledger->database.handle);
    ASSERT_OK(vw_ledger_append(ledger, record, 1, test_validation_views));
    return sqlite3_total_changes(ledger->database.handle) - before;
}

// The run row and the scores are written when a run goes on or is extended, not with each submission.
FOLDER_TEST(a_submission_writes_its_own_rows_only) {
    enum { STEP = 1 + TEST_VALIDATION_COUNT, RUN = 2 }; // the run row once for its final hash
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_create(path);
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    const struct vw_step_record *records = recording->records;
    assert_int_equal(count_changes(ledger, &records[0]), STEP);
    ASSERT_OK(vw_ledger_extend(ledger, "{\"burn_in_epochs\": 1}")); // the same
    assert_int_equal(count_changes(ledger, &records[1]), STEP);
    ASSERT_OK(vw_ledger_extend(ledger, "{}"));
    assert_int_equal(count_changes(ledger, &records[2]), STEP + RUN);
    assert_int_equal(count_changes(ledger, &records[3]), STEP);
    test_ledger_finish(ledger, "finished");
    assert_int_equal(count_changes(ledger, &records[4]), STEP + RUN + TEST_SCORE_COUNT + TEST_RETRAINING_COUNT);
    assert_int_equal(count_changes(ledger, &records[5]), STEP);
}
