// Edits that vw_ledger_verify finds: every edit of every column, rows removed, added and moved, and files that only
// look like a ledger.
#include "support/ledger_sql.h"

#include "ledger/ledger_private.h"

enum { STEP_COUNT = 1 + 2 * TEST_TRAIN_COUNT };

static const char *const tables[] = {"run", "image", "step", "view", "score", "retraining", "payout_request"};
enum { TABLE_COUNT = VW_ARRAY_COUNT(tables) };
static const char *const states[] = {"running", "interrupted", "finished"}; // only the last has scores and retrainings

// A ledger as it was recorded, from which fresh copies are made.
struct original {
    const char *status;
    struct kept_file file;
};

static struct original record_original(const char *folder, const char *status) {
    AUTO_FREE char *path = vw_path_join(folder, "ledger.db");
    struct test_trainer trainer = test_four_epochs;
    trainer.epochs = 2;
    unlink(path);
    struct vw_ledger *ledger = test_ledger_create(path);
    test_ledger_append(ledger, &trainer, STEP_COUNT);
    const struct vw_payout_request request = {.cents = 100};
    if (strcmp(status, "running") != 0) test_ledger_finish(ledger, status);
    if (strcmp(status, "finished") == 0) ASSERT_OK(vw_ledger_set_payout_request(ledger, &request));
    vw_ledger_close(&ledger);
    return (struct original){status, temporary_keep(path)};
}

static enum vw_status verify(const char *path) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    enum vw_status status = vw_ledger_open(path, &ledger);
    if (!status) status = vw_ledger_verify(ledger);
    return status;
}

// Checks that verification finds the change and names the file; the message of a mismatch contains `word`.
static void assert_found(const struct original *original, const char *what, const char *word) {
    enum vw_status status = verify(original->file.path);
    const char *message = vw_error_message();
    if (status != VW_ERROR_MISMATCH && status != VW_ERROR_INPUT)
        fail_msg("%s ledger: %s: gave %d", original->status, what, (int)status);
    if (!strstr(message, original->file.path) || (status == VW_ERROR_MISMATCH && !strstr(message, word)))
        fail_msg("%s ledger: %s: the message does not name %s or the file: %s", original->status, what, word, message);
}

FOLDER_TEST(the_untouched_ledger_verifies) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(states); i++) {
        const struct original original = record_original(*state, states[i]);
        ASSERT_OK(verify(original.file.path));
    }
    AUTO_FREE char *path = vw_path_join(*state, "empty.db");
    struct vw_ledger *ledger = test_ledger_create(path);
    ASSERT_OK(vw_ledger_verify(ledger)); // without any step
    test_ledger_finish(ledger, "failed");
    ASSERT_OK(vw_ledger_verify(ledger));
    vw_ledger_close(&ledger);
    assert_int_equal(vw_exit_code(VW_ERROR_MISMATCH), 1);
}

// ---- Edits ----------------------------------------------------------------------------------------------------------

// The edits of a cell; %1$s is the column. An edit that a column cannot hold, or that leaves it as it was, does not
// count.
static const char *const edits[] = {
    "%1$s + 1",
    "%1$s * 1.0000000000000002220446049250313", // by one unit in the last place
    "-%1$s",
    "NULL",
    "0",
    "0.5",
    "'x'",
    "''",
    "upper(%1$s)",
    "%1$s || 'x'",
    "%1$s || char(0) || 'x'",
    "substr(%1$s, 1, length(%1$s) - 1)",
    "CAST(%1$s AS BLOB)",
    "x'00'",
};

struct column {
    char table[16], name[32];
};

static uint32_t list_columns(const char *path, struct column *columns, uint32_t most) {
    sqlite3 *raw = sql_open(path);
    uint32_t count = 0;
    for (size_t t = 0; t < TABLE_COUNT; t++) {
        AUTO_FREE char *sql = vw_format_text("SELECT name FROM pragma_table_info('%s')", tables[t]);
        sqlite3_stmt *statement = sql_query(raw, sql, 0);
        while (sqlite3_step(statement) == SQLITE_ROW) {
            assert_true(count < most);
            struct column *column = &columns[count++];
            snprintf(column->table, sizeof column->table, "%s", tables[t]);
            snprintf(column->name, sizeof column->name, "%s", (const char *)sqlite3_column_text(statement, 0));
        }
        sqlite3_finalize(statement);
    }
    sqlite3_close(raw);
    return count;
}

// Returns the condition that holds for one row of a table, in the order of its primary key; to be freed.
static char *row_at(const char *path, const char *table, int64_t row) {
    AUTO_FREE char *sql = vw_format_text(
        "SELECT group_concat(name) FROM (SELECT name FROM pragma_table_info('%s') WHERE pk ORDER BY pk)", table);
    AUTO_FREE char *key = sql_ask(path, sql);
    char *condition = vw_format_text("(%s) = (SELECT %s FROM %s ORDER BY %s LIMIT 1 OFFSET %lld)", key, key, table, key,
                                     (long long)row);
    return condition;
}

static int64_t count_rows(const char *path, const char *table) {
    AUTO_FREE char *sql = vw_format_text("SELECT count(*) FROM %s", table), *answer = sql_ask(path, sql);
    int64_t count = strtoll(answer, NULL, 10);
    return count;
}

// Runs `sql`, written for one row of the table, and tells whether the table now holds something else. The tamperer
// heeds no constraint but those that SQLite cannot do without.
static bool tamper(const char *path, const char *table, const char *sql) {
    sqlite3 *raw = sql_open(path);
    sqlite3_exec(raw, "PRAGMA ignore_check_constraints = ON; PRAGMA synchronous = OFF; PRAGMA journal_mode = OFF", NULL,
                 NULL, NULL);
    AUTO_FREE char *keep = vw_format_text("CREATE TEMP TABLE before AS SELECT * FROM main.%s", table);
    AUTO_FREE char *compare =
        vw_format_text("SELECT (SELECT count(*) FROM (SELECT * FROM main.%s EXCEPT SELECT * FROM before))"
                       " + (SELECT count(*) FROM (SELECT * FROM before EXCEPT SELECT * FROM main.%s))",
                       table, table);
    assert_int_equal(sqlite3_exec(raw, keep, NULL, NULL, NULL), SQLITE_OK);
    int result = sqlite3_exec(raw, sql, NULL, NULL, NULL);
    if (result != SQLITE_OK && result != SQLITE_CONSTRAINT) fail_msg("%s: %s", sql, sqlite3_errmsg(raw));
    sqlite3_stmt *statement = sql_query(raw, compare, 0);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    bool changed = sqlite3_column_int(statement, 0) > 0;
    sqlite3_finalize(statement);
    sqlite3_close(raw);
    return changed;
}

// Tries all edits of a column in the first, a middle and the last row; the quick tests in one of these, by turns. Gives
// how many there were.
static uint32_t edit_column(const struct original *original, const struct column *column, uint32_t turn) {
    temporary_put_back(&original->file);
    int64_t last = count_rows(original->file.path, column->table) - 1;
    uint32_t done = 0;
    for (int64_t place = 0; place < 3 && last >= 0; place++) {
        if (place != turn % 3 && !test_is_full()) continue;
        temporary_put_back(&original->file);
        AUTO_FREE char *condition = row_at(original->file.path, column->table, place * last / 2);
        for (size_t e = 0; e < VW_ARRAY_COUNT(edits); e++) {
            AUTO_FREE char *value = vw_format_text(edits[e], column->name);
            AUTO_FREE char *sql =
                vw_format_text("UPDATE %s SET %s = %s WHERE %s", column->table, column->name, value, condition);
            temporary_put_back(&original->file);
            if (tamper(original->file.path, column->table, sql)) {
                assert_found(original, sql, column->table);
                done++;
            }
        }
    }
    return done;
}

// Tells which states the quick tests edit: not the interrupted one, whose rows are those of the others.
static bool is_edited(size_t state) { return test_is_full() || strcmp(states[state], "interrupted") != 0; }

FOLDER_TEST(every_edit_is_found) {
    struct column columns[100];
    for (size_t i = 0; i < VW_ARRAY_COUNT(states); i++) {
        if (!is_edited(i)) continue;
        struct original original = record_original(*state, states[i]);
        bool has_scores = strcmp(states[i], "finished") == 0;
        uint32_t column_count = list_columns(original.file.path, columns, VW_ARRAY_COUNT(columns)), edit_count = 0;
        for (uint32_t c = 0; c < column_count; c++) {
            uint32_t done = edit_column(&original, &columns[c], c);
            bool at_the_end = strstr("score retraining payout_request", columns[c].table) != NULL;
            bool has_rows = has_scores || !at_the_end;
            if (has_rows && done == 0)
                fail_msg("%s ledger: no edit of %s.%s was tried", states[i], columns[c].table, columns[c].name);
            edit_count += done;
        }
        print_message("%s ledger: %u edits of %u columns found\n", states[i], edit_count, column_count);
    }
}

// ---- Rows removed, added and moved ----------------------------------------------------------------------------------

FOLDER_TEST(every_removed_row_is_found) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(states); i++) {
        if (!is_edited(i)) continue;
        struct original original = record_original(*state, states[i]);
        for (size_t t = 0; t < TABLE_COUNT; t++) {
            temporary_put_back(&original.file);
            int64_t count = count_rows(original.file.path, tables[t]);
            for (int64_t row = 0; row < count; row++) {
                temporary_put_back(&original.file);
                AUTO_FREE char *condition = row_at(original.file.path, tables[t], row);
                AUTO_FREE char *sql = vw_format_text("DELETE FROM %s WHERE %s", tables[t], condition);
                assert_true(tamper(original.file.path, tables[t], sql));
                assert_found(&original, sql, tables[t]);
            }
        }
    }
}

#define SHIFT(from, to)                                                                                                \
    "UPDATE step SET step = " to " WHERE step = " from ";"                                                             \
    "UPDATE view SET step = " to " WHERE step = " from ";"
#define REMOVE(which) "DELETE FROM step WHERE step " which "; DELETE FROM view WHERE step " which ";"

FOLDER_TEST(rows_moved_and_added_are_found) {
    static const struct {
        const char *what, *sql, *word;
        bool found_in_running; // else that is what the ledger of a run without an end cannot show
    } cases[] = {
        {"a step removed with all that is its own", REMOVE("= 5"), "step 5 is missing", true},
        {"the first step removed likewise", REMOVE("= 0"), "step 0 is missing", true},
        {"the last step removed likewise", REMOVE("= 10"), "last step", false},
        {"the last three steps removed likewise", REMOVE(">= 8"), "last step", false},
        {"all steps removed likewise", REMOVE(">= 0"), "last step", false},
        {"two steps swapped", SHIFT("3", "-1") SHIFT("6", "3") SHIFT("-1", "6"),
         "step 3 or one of its view rows was edited or moved", true},
        {"the last step renumbered", SHIFT("10", "11"), "step 10 is missing", true},
        {"all steps renumbered", "UPDATE step SET step = step + 100; UPDATE view SET step = step + 100",
         "step 0 is missing", true},
        {"two photos swapped", "UPDATE step SET image_id = 3 - image_id WHERE image_id IN (1, 2)", "was edited", true},
        {"two row hashes swapped",
         "UPDATE step SET row_hash = (SELECT row_hash FROM step AS other WHERE other.step = 7 - step.step) WHERE step "
         "IN (3, 4)",
         "step 3", true},
        {"a step added at the end",
         "INSERT INTO step SELECT run_id, 11, epoch, image_id, train_loss, val_psnr, val_psnr_pooled, val_l1,"
         " nonfinite, row_hash, clamped, floored FROM step WHERE step = 10",
         "step 11", true},
        {"a step added before the first",
         "INSERT INTO step SELECT run_id, -1, epoch, image_id, train_loss, val_psnr, val_psnr_pooled,"
         " val_l1, nonfinite, row_hash, clamped, floored FROM step WHERE step = 0",
         "step 0 is missing", true},
        {"a view row added to a step",
         "INSERT INTO view SELECT run_id, step, 3, mse, l1 FROM view WHERE step = 5 AND image_id = 4", "step 5", true},
        {"a view row added to a step without any",
         "INSERT INTO view SELECT run_id, 7, image_id, mse, l1 FROM view WHERE step = 5", "step 7", true},
        {"view rows of no step", "INSERT INTO view SELECT run_id, 99, image_id, mse, l1 FROM view WHERE step = 5",
         "step 99", true},
        {"view rows before all steps", "INSERT INTO view SELECT run_id, -1, image_id, mse, l1 FROM view WHERE step = 5",
         "table view", true},
        {"a view row whose step is a text",
         "INSERT INTO view SELECT run_id, 'x', image_id, mse, l1 FROM view WHERE step = 5", "table view", true},
        {"a view row of another run",
         "INSERT INTO view SELECT 'other', step, image_id, mse, l1 FROM view WHERE step = 5", "table view", true},
        {"a step of another run",
         "INSERT INTO step SELECT 'other', 0, 0, NULL, NULL, NULL, NULL, NULL, 0, row_hash, 0, 0 FROM run",
         "step 11 is missing", true},
        {"an image added",
         "INSERT INTO image SELECT 8, scene_hash, 'images/8.png', split, provider, sha256, ground_truth FROM image"
         " WHERE image_id = 1",
         "image row", true},
        {"an image of another scene",
         "INSERT INTO image SELECT 8, 'other', 'images/8.png', split, provider, sha256, ground_truth FROM image"
         " WHERE image_id = 1",
         "image row", true},
        {"a score added", "INSERT INTO score SELECT run_id, 3, 'dv_psnr', 9, 'dB', NULL, 1, NULL, NULL, 1, 1 FROM run",
         "score row", true},
        {"a score of another run",
         "INSERT INTO score VALUES ('other', 3, 'dv_psnr', 9, 'dB', NULL, 1, NULL, NULL, 1, 1)", "score row", true},
        {"a second run",
         "INSERT INTO run SELECT 'other', scene_hash, scene_path, seed, config_json, subset_hash, device, driver,"
         " shader_hash, version, started_utc, finished_utc, status, row_hash, final_hash, scene_options_json, "
         "effects_json, plan_json, field_sha256"
         " FROM run",
         "", true},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(states); i++) {
        struct original original = record_original(*state, states[i]);
        for (size_t c = 0; c < VW_ARRAY_COUNT(cases); c++) {
            temporary_put_back(&original.file);
            sql_change(original.file.path, cases[c].sql);
            if (cases[c].found_in_running || i > 0) assert_found(&original, cases[c].what, cases[c].word);
            else ASSERT_OK(verify(original.file.path));
        }
    }
}

// The rowids of scores hold the order of the methods, in which scores.csv, the report and the lists show them.
FOLDER_TEST(scores_moved_are_found) {
    static const char *const moves[] = {
        "UPDATE score SET rowid = -rowid",
        "UPDATE score SET rowid = 9 WHERE rowid = 1; UPDATE score SET rowid = 1 WHERE rowid = 3;"
        "UPDATE score SET rowid = 3 WHERE rowid = 9",
    };
    struct original original = record_original(*state, "finished");
    for (size_t i = 0; i < VW_ARRAY_COUNT(moves); i++) {
        temporary_put_back(&original.file);
        sql_change(original.file.path, moves[i]);
        assert_found(&original, moves[i], "score row was edited, removed, added or moved");
    }
    temporary_put_back(&original.file);
    sql_change(original.file.path, "UPDATE score SET rowid = rowid + 7; VACUUM"); // the same order
    ASSERT_OK(verify(original.file.path));
}

// ---- Files that only look like a ledger -----------------------------------------------------------------------------

// Uses a ledger in every way there is. Only that it ends, and without a crash, is asked.
static void use(const char *path) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    if (vw_ledger_open_to_append(path, &ledger)) return;
    sqlite3_exec(ledger->database.handle, "PRAGMA synchronous = OFF", NULL, NULL, NULL); // no power cut is played here
    struct vw_ledger_run run;
    const struct vw_ledger_image *images = NULL;
    AUTO_FREE struct vw_step_record *records = NULL;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    uint64_t record_count = 0;
    uint32_t image_count = 0, score_count = 0;
    char head[VW_HASH_HEX_BYTES];
    ASSERT_OK(vw_ledger_get_run(ledger, &run));
    (void)vw_ledger_get_images(ledger, &images, &image_count);
    (void)vw_ledger_get_steps(ledger, &records, &record_count);
    (void)vw_ledger_get_scores(ledger, &scores, &score_count);
    vw_ledger_chain_head(ledger, head);
    AUTO_FREE struct test_recording *recording = test_record(&test_four_epochs);
    uint64_t next = vw_ledger_next_step(ledger);
    (void)vw_ledger_compare(ledger, recording->records, STEP_COUNT, test_validation_views);
    struct vw_step_record more = {.step = next, .validated = true};
    (void)vw_ledger_extend(ledger, "{}");
    (void)vw_ledger_append(ledger, &more, 1, test_validation_views);
    (void)vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", test_scores, TEST_SCORE_COUNT);
}

// One flipped bit anywhere in the file: what verifies is still the same ledger. Rerun a failure by its number.
FOLDER_TEST(flipped_bits_do_no_harm) {
    enum { FLIPS = 400 };
    struct original original = record_original(*state, "finished");
    AUTO_FREE unsigned char *bytes = vw_allocate(original.file.size_bytes, 1);
    AUTO_FREE char *final_hash = sql_ask(original.file.path, SQL_FINAL_HASH);
    uint32_t found = 0;
    for (uint32_t i = 0; i < FLIPS; i++) {
        uint32_t words[4];
        vw_random_words(5, VW_RANDOM_JITTER, i, 0, 0, words);
        size_t place = words[0] % original.file.size_bytes;
        memcpy(bytes, original.file.bytes, original.file.size_bytes);
        bytes[place] ^= (unsigned char)(1u << words[1] % 8);
        temporary_write(original.file.path, bytes, original.file.size_bytes);
        struct vw_ledger *ledger = NULL;
        char head[VW_HASH_HEX_BYTES];
        if (vw_ledger_open(original.file.path, &ledger) || vw_ledger_verify(ledger)) {
            found++;
        } else {
            vw_ledger_chain_head(ledger, head);
            if (strcmp(head, final_hash) != 0) fail_msg("flip %u, of byte %zu: another head verifies", i, place);
        }
        vw_ledger_close(&ledger);
        use(original.file.path);
    }
    print_message("%u of %u flipped bits found, the others changed no row\n", found, (uint32_t)FLIPS);
    assert_true(found > 0);
}
