// The ledger as an outsider sees it: its rows, its chain recomputed from raw SQL, and what failures leave behind.
#include "unit/ledger_fixture.h"

#include <signal.h>
#include <sodium.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "ledger/ledger_private.h"
#include "viewworth/file.h"

static const struct test_trainer trainer = {
    .worth_db = {0.5, -0.2, 0.1, -0.3, 0.2}, .noise_db = 0.05, .first_epoch_factor = 3, .epochs = 4};
enum { RECORD_COUNT = 1 + 4 * TEST_TRAIN_COUNT };

static struct vw_ledger *create_ledger(const char *path) {
    struct vw_ledger_run run = test_run("{\"burn_in_epochs\": 1}");
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger));
    return ledger;
}

// Records a run of 4 epochs in batches of `batch` steps; steps 7 and 8 are not finite, step 12 was not validated.
static void record_steps(struct vw_ledger *ledger, uint32_t batch) {
    struct vw_step_record records[RECORD_COUNT];
    struct vw_view_error errors[2 * RECORD_COUNT];
    uint32_t count = test_train(&trainer, records, errors);
    records[7].nonfinite = true;
    errors[2 * 8].mse = INFINITY;
    records[12].validated = false;
    records[12].val_psnr = records[12].val_psnr_pooled = records[12].val_l1 = NAN;
    records[12].views = NULL;
    for (uint32_t first = 0; first < count; first += batch) {
        uint32_t some = count - first < batch ? count - first : batch;
        ASSERT_OK(vw_ledger_append(ledger, &records[first], some, test_validation_views));
    }
}

static const struct vw_ledger_score scores[] = {
    {1, "dv_psnr", 1.5, "dB", 0.25, 3},
    {2, "dv_psnr", -0.0, "dB", NAN, 1},
    {1, "dv_loss", 0.015, "mean absolute error", 0.0025, 3},
};

static char *record_run(const char *folder, const char *name, uint32_t batch) {
    char *path = vw_path_join(folder, name);
    struct vw_ledger *ledger = create_ledger(path);
    record_steps(ledger, batch);
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scores, VW_ARRAY_COUNT(scores)));
    vw_ledger_close(&ledger);
    assert_null(ledger);
    return path;
}

static sqlite3 *open_raw(const char *path) {
    sqlite3 *raw = NULL;
    assert_int_equal(sqlite3_open_v2(path, &raw, SQLITE_OPEN_READWRITE, NULL), SQLITE_OK);
    return raw;
}

static sqlite3_stmt *query(sqlite3 *raw, const char *sql, int64_t value) {
    sqlite3_stmt *statement = NULL;
    if (sqlite3_prepare_v2(raw, sql, -1, &statement, NULL) != SQLITE_OK) fail_msg("%s: %s", sql, sqlite3_errmsg(raw));
    if (sqlite3_bind_parameter_count(statement)) sqlite3_bind_int64(statement, 1, value);
    return statement;
}

// The first column of the first row as text, "NULL" for NULL; to be freed.
static char *ask(const char *path, const char *sql) {
    sqlite3 *raw = open_raw(path);
    sqlite3_stmt *statement = query(raw, sql, 0);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    const char *text = (const char *)sqlite3_column_text(statement, 0);
    char *answer = vw_copy_text(text ? text : "NULL");
    sqlite3_finalize(statement);
    sqlite3_close(raw);
    return answer;
}

static void assert_answer(const char *path, const char *sql, const char *expected) {
    char *answer = ask(path, sql);
    if (strcmp(answer, expected) != 0) fail_msg("%s gave %s, not %s", sql, answer, expected);
    free(answer);
}

static void change(const char *path, const char *sql) {
    sqlite3 *raw = open_raw(path);
    assert_int_equal(sqlite3_exec(raw, sql, NULL, NULL, NULL), SQLITE_OK);
    assert_true(sqlite3_total_changes(raw) > 0);
    sqlite3_close(raw);
}

// ---- The chain, written a second time from its description ----

static void feed(crypto_generichash_state *state, char tag, uint64_t word, const char *text) {
    unsigned char bytes[9] = {(unsigned char)tag};
    for (int i = 0; i < 8; i++) bytes[1 + i] = (unsigned char)(word >> 8 * i);
    crypto_generichash_update(state, bytes, tag == 'n' ? 1 : 9);
    if (text) crypto_generichash_update(state, (const unsigned char *)text, strlen(text));
}

static void feed_text(crypto_generichash_state *state, const char *text) { feed(state, 't', strlen(text), text); }

static void feed_rows(crypto_generichash_state *state, sqlite3 *raw, const char *sql, int64_t value) {
    sqlite3_stmt *statement = query(raw, sql, value);
    while (sqlite3_step(statement) == SQLITE_ROW)
        for (int i = 0; i < sqlite3_column_count(statement); i++) {
            double real = sqlite3_column_double(statement, i);
            uint64_t bits;
            memcpy(&bits, &real, sizeof bits);
            switch (sqlite3_column_type(statement, i)) {
            case SQLITE_INTEGER: feed(state, 'i', (uint64_t)sqlite3_column_int64(statement, i), NULL); break;
            case SQLITE_FLOAT: feed(state, 'r', bits, NULL); break;
            case SQLITE_TEXT: feed_text(state, (const char *)sqlite3_column_text(statement, i)); break;
            default: feed(state, 'n', 0, NULL);
            }
        }
    sqlite3_finalize(statement);
}

// Ends a hash into `hex` and tells whether `sql` finds the same.
static bool hash_is(crypto_generichash_state *state, sqlite3 *raw, const char *sql, int64_t value, char hex[65]) {
    unsigned char hash[32];
    crypto_generichash_final(state, hash, sizeof hash);
    sodium_bin2hex(hex, 65, hash, sizeof hash);
    sqlite3_stmt *statement = query(raw, sql, value);
    bool same = sqlite3_step(statement) == SQLITE_ROW && strcmp((const char *)sqlite3_column_text(statement, 0), hex) == 0;
    sqlite3_finalize(statement);
    return same;
}

static int64_t count_steps(sqlite3 *raw) {
    sqlite3_stmt *statement = query(raw, "SELECT count(*) FROM step", 0);
    sqlite3_step(statement);
    int64_t count = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    return count;
}

static bool chain_holds(const char *path) {
    sqlite3 *raw = open_raw(path);
    crypto_generichash_state state;
    char head[65];
    crypto_generichash_init(&state, NULL, 0, 32);
    feed_rows(&state, raw, "SELECT run_id, scene_hash, seed, subset_hash, device, driver, shader_hash, version FROM run", 0);
    feed_rows(&state, raw, "SELECT image_id, scene_hash, name, split, provider, sha256, truth FROM image ORDER BY image_id", 0);
    bool holds = hash_is(&state, raw, "SELECT row_hash FROM run", 0, head);
    int64_t count = count_steps(raw);
    for (int64_t step = 0; step < count; step++) {
        crypto_generichash_init(&state, NULL, 0, 32);
        feed_text(&state, head);
        feed_rows(&state, raw,
                  "SELECT run_id, step, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1, nonfinite, clamped, floored"
                  " FROM step WHERE step = ?",
                  step);
        feed_rows(&state, raw, "SELECT run_id, step, image_id, mse, l1 FROM view WHERE step = ? ORDER BY image_id", step);
        holds = hash_is(&state, raw, "SELECT row_hash FROM step WHERE step = ?", step, head) && holds;
    }
    crypto_generichash_init(&state, NULL, 0, 32);
    feed_text(&state, head);
    feed_rows(&state, raw, "SELECT scene_path, config_json, scene_options_json, started_utc, finished_utc, status FROM run", 0);
    feed_rows(&state, raw, "SELECT run_id, image_id, method, value, unit, stderr, visits FROM score ORDER BY image_id, method", 0);
    holds = hash_is(&state, raw, "SELECT final_hash FROM run", 0, head) && holds;
    sqlite3_close(raw);
    return holds;
}

// ---- Tests ----

static void rows_read_back(void **state) {
    char *path = record_run(*state, "ledger.db", 6);
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_open(path, &ledger));
    struct vw_ledger_run run, expected = test_run("{\"burn_in_epochs\": 1}");
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    assert_string_equal(run.run_id, expected.run_id);
    assert_string_equal(run.scene_path, expected.scene_path);
    assert_string_equal(run.config_json, expected.config_json);
    assert_string_equal(run.driver, expected.driver);
    assert_string_equal(run.started_utc, expected.started_utc);
    assert_string_equal(run.scene_options_json, expected.scene_options_json);
    assert_true(run.seed == expected.seed);

    const struct vw_ledger_image *images = NULL, *again = NULL;
    uint32_t image_count = 0;
    ASSERT_OK(vw_ledger_get_images(ledger, &images, &image_count));
    assert_int_equal(image_count, TEST_IMAGE_COUNT);
    for (uint32_t i = 0; i < image_count; i++) {
        assert_int_equal(images[i].image_id, test_images[i].image_id);
        assert_string_equal(images[i].name, test_images[i].name);
        assert_string_equal(images[i].split, test_images[i].split);
        assert_true(!images[i].truth == !test_images[i].truth && !images[i].provider == !test_images[i].provider);
    }
    assert_string_equal(images[5].truth, "occluder");
    ASSERT_OK(vw_ledger_get_images(ledger, &again, &image_count));
    assert_ptr_equal(images, again); // lent until closed

    struct vw_step_record written[RECORD_COUNT], *read = NULL;
    struct vw_view_error errors[2 * RECORD_COUNT];
    uint64_t count = 0;
    test_train(&trainer, written, errors);
    ASSERT_OK(vw_ledger_get_steps(ledger, &read, &count));
    assert_int_equal(count, RECORD_COUNT);
    for (uint32_t i = 0; i < count; i++) {
        bool nonfinite = i == 7 || i == 8, valued = !nonfinite && i != 12;
        assert_int_equal(read[i].step, i);
        assert_int_equal(read[i].epoch, written[i].epoch);
        assert_int_equal(read[i].view, written[i].view);
        assert_int_equal(read[i].nonfinite, nonfinite);
        assert_int_equal(read[i].validated, valued);
        assert_int_equal(read[i].clamped_count, i);
        assert_int_equal(read[i].floored_views, read[i].nonfinite || !read[i].validated ? 0 : i % 3);
        assert_true(valued ? read[i].val_psnr == written[i].val_psnr : isnan(read[i].val_psnr));
        assert_true(valued ? read[i].val_psnr_pooled == written[i].val_psnr_pooled : isnan(read[i].val_psnr_pooled));
        assert_true(valued ? read[i].val_l1 == written[i].val_l1 : isnan(read[i].val_l1));
        assert_true(i && !nonfinite ? read[i].train_loss == 0.2 : isnan(read[i].train_loss));
        assert_null(read[i].views);
    }
    free(read);
    vw_ledger_close(&ledger);
    vw_ledger_close(&ledger); // NULL is fine
    free(path);
}

static void tables_are_as_contracted(void **state) {
    char *path = record_run(*state, "ledger.db", 6);
    const char *tables[][2] = {
        {"run", "run_id,scene_hash,scene_path,seed,config_json,subset_hash,device,driver,shader_hash,version,started_utc,finished_utc,"
                "status,row_hash,final_hash,scene_options_json"},
        {"image", "image_id,scene_hash,name,split,provider,sha256,truth"},
        {"step", "run_id,step,epoch,image_id,train_loss,val_psnr,val_psnr_pooled,val_l1,nonfinite,row_hash,clamped,floored"},
        {"view", "run_id,step,image_id,mse,l1"},
        {"score", "run_id,image_id,method,value,unit,stderr,visits"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        char *sql = vw_format_text("SELECT group_concat(name) FROM (SELECT name FROM pragma_table_info('%s') ORDER BY cid)", tables[i][0]);
        assert_answer(path, sql, tables[i][1]);
        free(sql);
    }
    assert_answer(path, "SELECT image_id FROM step WHERE step = 0", "NULL");
    assert_answer(path,
                  "SELECT count(*) FROM step WHERE step IN (7, 8) AND nonfinite = 1 AND train_loss IS NULL AND val_psnr IS NULL"
                  " AND val_psnr_pooled IS NULL AND val_l1 IS NULL",
                  "2");
    assert_answer(path, "SELECT count(*) FROM step WHERE nonfinite = 1", "2");
    assert_answer(path, "SELECT count(*) FROM step WHERE step = 12 AND val_psnr IS NULL AND train_loss = 0.2", "1");
    assert_answer(path, "SELECT count(*) FROM view WHERE step IN (7, 8, 12)", "0");
    assert_answer(path, "SELECT count(*) FROM view", "36"); // 2 for each of the other 18 steps
    assert_answer(path, "SELECT group_concat(image_id) FROM view WHERE step = 3", "0,4");
    assert_answer(path, "SELECT status || ' ' || finished_utc FROM run", "finished 2026-11-21T04:00:00Z");
    assert_answer(path, "SELECT seed FROM run", "9223372036854775807");
    assert_answer(path, "SELECT stderr FROM score WHERE image_id = 2", "NULL");
    assert_answer(path, "SELECT count(*) FROM score", "3");
    assert_answer(path, "PRAGMA user_version", "1");
    assert_answer(path, "PRAGMA journal_mode", "delete");
    assert_answer(path, "PRAGMA integrity_check", "ok");
    assert_answer(path, "SELECT count(*) FROM pragma_foreign_key_check", "0");
    free(path);
}

static void chain_holds_whatever_the_batches(void **state) {
    char *path = record_run(*state, "ledger.db", 6), *other = record_run(*state, "other.db", 1);
    assert_true(chain_holds(path));
    assert_true(chain_holds(other));
    char *head = ask(path, "SELECT final_hash FROM run");
    assert_answer(other, "SELECT final_hash FROM run", head);
    free(head);
    free(other);
    free(path);
}

// What may differ between two runs of one identity leaves the chain of the steps alone, and shows in the final hash.
static void chain_of_steps_is_the_run(void **state) {
    char *path = record_run(*state, "ledger.db", 6), *other = vw_path_join(*state, "other.db");
    struct vw_ledger_run run = test_run("{\"burn_in_epochs\": 1, \"epochs\": 9}");
    run.scene_path = "elsewhere/small.json";
    run.scene_options_json = "{}";
    run.started_utc = "2027-01-01T00:00:00Z";
    struct vw_ledger *ledger = NULL;
    ASSERT_OK(vw_ledger_create(other, &run, test_images, TEST_IMAGE_COUNT, &ledger));
    record_steps(ledger, 6);
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scores, VW_ARRAY_COUNT(scores)));
    vw_ledger_close(&ledger);
    assert_true(chain_holds(other));
    char *heads = ask(path, "SELECT group_concat(row_hash) FROM (SELECT row_hash FROM run UNION ALL SELECT row_hash FROM step)");
    assert_answer(other, "SELECT group_concat(row_hash) FROM (SELECT row_hash FROM run UNION ALL SELECT row_hash FROM step)", heads);
    char *final = ask(path, "SELECT final_hash FROM run"), *other_final = ask(other, "SELECT final_hash FROM run");
    assert_string_not_equal(final, other_final);
    free(other_final);
    free(final);
    free(heads);
    free(other);
    free(path);
}

static void chain_shows_each_change(void **state) {
    const char *changes[] = {
        "UPDATE step SET val_psnr = val_psnr + 1e-9 WHERE step = 3",
        "UPDATE step SET clamped = 0 WHERE step = 5",
        "UPDATE step SET floored = floored + 1 WHERE step = 5",
        "UPDATE step SET val_l1 = NULL WHERE step = 1",
        "UPDATE step SET image_id = 3 - image_id WHERE image_id IN (1, 2)",
        "DELETE FROM view WHERE step = 4 AND image_id = 4",
        "UPDATE view SET mse = 2 WHERE step = 20 AND image_id = 0",
        "DELETE FROM step WHERE step = 20",
        "UPDATE step SET nonfinite = 1 WHERE step = 12",
        "UPDATE image SET truth = 'clean' WHERE image_id = 2",
        "UPDATE image SET split = 'test' WHERE image_id = 6",
        "DELETE FROM image WHERE image_id = 7",
        "UPDATE run SET seed = 1",
        "UPDATE run SET config_json = '{}'",
        "UPDATE run SET status = 'interrupted'",
        "UPDATE run SET scene_path = 'other'",
        "UPDATE run SET scene_options_json = '{}'",
        "UPDATE run SET started_utc = finished_utc",
        "UPDATE run SET driver = 'other'",
        "UPDATE score SET value = 9 WHERE method = 'dv_loss'",
        "DELETE FROM score WHERE image_id = 2",
        "UPDATE step SET row_hash = (SELECT row_hash FROM step WHERE step = 1) WHERE step = 2",
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(changes); i++) {
        char *path = record_run(*state, "ledger.db", 6);
        assert_true(chain_holds(path));
        change(path, changes[i]);
        if (chain_holds(path)) fail_msg("the chain does not show: %s", changes[i]);
        unlink(path);
        free(path);
    }
}

static void creating_needs_a_free_place(void **state) {
    char *path = record_run(*state, "ledger.db", 6);
    char *head = ask(path, "SELECT final_hash FROM run");
    struct vw_ledger_run run = test_run("{}");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger), VW_ERROR_USAGE);
    assert_null(ledger);
    assert_non_null(strstr(vw_error_message(), path));
    assert_non_null(strstr(vw_error_message(), "choose another --out"));
    assert_answer(path, "SELECT final_hash FROM run", head);
    free(head);

    char *missing = vw_path_join(*state, "missing/ledger.db");
    assert_int_equal(vw_ledger_create(missing, &run, test_images, TEST_IMAGE_COUNT, &ledger), VW_ERROR_IO);
    assert_non_null(strstr(vw_error_message(), missing));
    free(missing);
    free(path);
}

// An image table that breaks a rule (two images of one name) fails after the run has been begun: nothing may stay.
static void a_failed_creation_leaves_nothing(void **state) {
    char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger_image images[2] = {test_images[0], test_images[1]};
    images[1].name = images[0].name;
    struct vw_ledger_run run = test_run("{}");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(vw_ledger_create(path, &run, images, 2, &ledger), VW_ERROR_IO);
    assert_null(ledger);
    free(path);
    assert_int_equal(rmdir(*state), 0); // empty
    assert_int_equal(mkdir(*state, 0777), 0);
}

static void only_ledgers_open(void **state) {
    char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = NULL;
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT); // missing
    assert_false(vw_file_exists(path));
    char text[200];
    memset(text, 'a', sizeof text); // longer than a database header
    ASSERT_OK(vw_file_write(path, text, sizeof text));
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT); // text
    assert_non_null(strstr(vw_error_message(), "not a viewworth ledger"));
    unlink(path);
    ASSERT_OK(vw_file_write(path, "", 0));
    change(path, "CREATE TABLE run (a); INSERT INTO run VALUES (1); PRAGMA user_version = 0");
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT); // someone else's database
    change(path, "INSERT INTO run VALUES (2); PRAGMA user_version = 1");
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT);
    unlink(path);
    free(path);

    path = record_run(*state, "ledger.db", 6);
    change(path, "UPDATE run SET seed = 1; PRAGMA user_version = 2");
    assert_int_equal(vw_ledger_open(path, &ledger), VW_ERROR_INPUT);
    assert_non_null(strstr(vw_error_message(), "newer viewworth"));
    assert_null(ledger);
    free(path);
}

static void steps_must_follow_each_other(void **state) {
    char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = create_ledger(path);
    struct vw_step_record records[RECORD_COUNT];
    struct vw_view_error errors[2 * RECORD_COUNT];
    test_train(&trainer, records, errors);
    assert_int_equal(vw_ledger_append(ledger, &records[1], 2, test_validation_views), VW_ERROR_USAGE);
    ASSERT_OK(vw_ledger_append(ledger, records, 3, test_validation_views));
    assert_int_equal(vw_ledger_append(ledger, &records[2], 2, test_validation_views), VW_ERROR_USAGE);
    assert_answer(path, "SELECT count(*) FROM step", "3");
    vw_ledger_close(&ledger);
    free(path);
}

static void a_finished_run_can_go_on(void **state) {
    char *whole = record_run(*state, "whole.db", 6), *path = vw_path_join(*state, "ledger.db");
    char *head = ask(whole, "SELECT row_hash FROM step WHERE step = 5");
    struct vw_ledger *ledger = create_ledger(path);
    struct vw_step_record records[RECORD_COUNT];
    struct vw_view_error errors[2 * RECORD_COUNT];
    test_train(&trainer, records, errors);
    ASSERT_OK(vw_ledger_append(ledger, records, 3, test_validation_views));
    ASSERT_OK(vw_ledger_finish(ledger, "interrupted", "2026-11-21T03:30:00Z", scores, 1));
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    ASSERT_OK(vw_ledger_open(path, &ledger));
    ASSERT_OK(vw_ledger_append(ledger, &records[3], 3, test_validation_views));
    assert_answer(path, "SELECT count(*) FROM score", "0");
    assert_answer(path, "SELECT status FROM run WHERE finished_utc IS NULL AND final_hash IS NULL", "running");
    assert_answer(path, "SELECT row_hash FROM step WHERE step = 5", head); // as if never interrupted
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scores, 2));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:01Z", &scores[2], 1)); // replaces
    assert_answer(path, "SELECT group_concat(method) FROM score", "dv_loss");
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    free(head);
    free(path);
    free(whole);
}

// A full disk, played by a bound on the pages of the file: the batch that does not fit is refused whole, and once there is
// room again the same batch goes in.
static void a_full_disk_loses_no_recorded_batch(void **state) {
    char *path = vw_path_join(*state, "ledger.db");
    struct vw_ledger *ledger = create_ledger(path);
    struct test_trainer longer = trainer;
    longer.epochs = TEST_EPOCHS_MOST;
    struct vw_step_record records[TEST_RECORDS_MOST];
    struct vw_view_error errors[2 * TEST_RECORDS_MOST];
    test_train(&longer, records, errors);
    ASSERT_OK(vw_ledger_append(ledger, records, 3, test_validation_views));
    sqlite3_exec(ledger->database.handle, "PRAGMA max_page_count = 1", NULL, NULL, NULL); // becomes the present size
    assert_int_equal(vw_ledger_append(ledger, &records[3], TEST_RECORDS_MOST - 3, test_validation_views), VW_ERROR_IO);
    assert_non_null(strstr(vw_error_message(), "disk is full"));
    assert_non_null(strstr(vw_error_message(), path));
    assert_answer(path, "SELECT count(*) FROM step", "3");
    assert_answer(path, "SELECT count(*) FROM view", "6");
    sqlite3_exec(ledger->database.handle, "PRAGMA max_page_count = 100000", NULL, NULL, NULL);
    ASSERT_OK(vw_ledger_append(ledger, &records[3], TEST_RECORDS_MOST - 3, test_validation_views));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scores, VW_ARRAY_COUNT(scores)));
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    free(path);
}

// Records 3 steps, then dies in the middle of a transaction whose pages have already spilled into the file.
static void die_in_a_transaction(const char *path) {
    struct vw_ledger_run run = test_run("{}");
    struct vw_ledger *ledger = NULL;
    struct vw_step_record records[RECORD_COUNT];
    struct vw_view_error errors[2 * RECORD_COUNT];
    test_train(&trainer, records, errors);
    if (vw_ledger_create(path, &run, test_images, TEST_IMAGE_COUNT, &ledger)) _exit(1);
    if (vw_ledger_append(ledger, records, 3, test_validation_views)) _exit(2);
    const char *sql = "PRAGMA cache_spill = 1; PRAGMA cache_size = 1; BEGIN IMMEDIATE;"
                      "UPDATE step SET val_psnr = 99; UPDATE image SET name = name || printf('%0100000d', 0);";
    if (sqlite3_exec(ledger->database.handle, sql, NULL, NULL, NULL) != SQLITE_OK) _exit(3);
    raise(SIGKILL);
}

static void a_killed_run_keeps_what_it_recorded(void **state) {
    char *path = vw_path_join(*state, "ledger.db"), *journal = vw_path_join(*state, "ledger.db-journal");
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        die_in_a_transaction(path);
        _exit(4);
    }
    int result = 0;
    assert_int_equal(waitpid(child, &result, 0), child);
    assert_true(WIFSIGNALED(result) && WTERMSIG(result) == SIGKILL);
    assert_true(vw_file_exists(journal)); // or this test shows nothing
    struct vw_ledger *ledger = NULL;
    struct vw_step_record *records = NULL;
    uint64_t count = 0;
    ASSERT_OK(vw_ledger_open(path, &ledger));
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &count));
    assert_int_equal(count, 3);
    assert_true(records[2].val_psnr < 99);
    free(records);
    ASSERT_OK(vw_ledger_finish(ledger, "failed", "2026-11-21T04:00:00Z", NULL, 0));
    vw_ledger_close(&ledger);
    assert_true(chain_holds(path));
    assert_false(vw_file_exists(journal));
    free(journal);
    free(path);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(rows_read_back, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(tables_are_as_contracted, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(chain_holds_whatever_the_batches, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(chain_of_steps_is_the_run, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(chain_shows_each_change, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(creating_needs_a_free_place, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(a_failed_creation_leaves_nothing, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(only_ledgers_open, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(steps_must_follow_each_other, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(a_finished_run_can_go_on, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(a_full_disk_loses_no_recorded_batch, test_set_up, test_tear_down),
        cmocka_unit_test_setup_teardown(a_killed_run_keeps_what_it_recorded, test_set_up, test_tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
