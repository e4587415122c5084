// Ledgers from someone who wants to harm: each is refused when it is opened or read, in bounded time, and names itself.
#include "support/ledger_sql.h"

#include <time.h>

#include "ledger/retraining.h"

enum { STEP_COUNT = 11, PAGE_BYTES = 4096 };

static char *record(const char *folder) {
    struct test_trainer trainer = test_four_epochs;
    trainer.epochs = 2;
    return test_ledger_record(folder, "ledger.db", &trainer, STEP_COUNT);
}

static void assert_refused(const char *path, const char *what) {
    struct vw_ledger *ledger = NULL;
    ASSERT_CASE_FAILS(what, vw_ledger_open(path, &ledger), VW_ERROR_INPUT, path);
    ASSERT_CASE_FAILS(what, vw_ledger_open_to_append(path, &ledger), VW_ERROR_INPUT, path);
    assert_null(ledger);
}

// ---- Schemas -------------------------------------------------------------------------------------------------------

// An index with all that a query needs answers it in place of the table. Its rows say what the forger wants; the table,
// which is verified, has the true ones.
FOLDER_TEST(rows_of_a_forged_index_are_not_read) {
    AUTO_FREE char *path = record(*state);
    sql_change(path, "UPDATE step SET val_psnr = val_psnr + 100;"
                     "CREATE INDEX forged ON step (run_id, step, epoch, image_id, train_loss, val_psnr, "
                     "val_psnr_pooled, val_l1, nonfinite, clamped, floored);"
                     "CREATE TABLE held AS SELECT * FROM sqlite_schema WHERE name = 'forged';"
                     "PRAGMA writable_schema = ON; DELETE FROM sqlite_schema WHERE name = 'forged';");
    sql_change(path, "UPDATE step SET val_psnr = val_psnr - 100; PRAGMA writable_schema = ON;"
                     "INSERT INTO sqlite_schema SELECT * FROM held; DELETE FROM sqlite_schema WHERE name = 'held';");
    assert_refused(path, "forged index");
}

FOLDER_TEST(only_the_schema_of_a_ledger_is_read) {
    static const char *const changes[] = {
        "CREATE INDEX extra ON score (method)",
        "CREATE INDEX extra ON step (val_psnr) WHERE step > 3",
        "CREATE TABLE notes (text); INSERT INTO notes VALUES ('mine')",
        "CREATE TABLE numbered (a INTEGER PRIMARY KEY AUTOINCREMENT); INSERT INTO numbered VALUES (1)",
        "CREATE VIEW best AS SELECT * FROM score",
        "DROP TABLE score; CREATE VIEW score AS SELECT * FROM step",
        "CREATE TRIGGER undo AFTER INSERT ON step BEGIN DELETE FROM step; END",
        "CREATE VIRTUAL TABLE words USING fts4(a)",
        "ALTER TABLE run ADD COLUMN more TEXT",
        "ALTER TABLE run ADD COLUMN more TEXT AS (run_id)",
        "ALTER TABLE run RENAME COLUMN driver TO drivers",
        "ANALYZE",
        "DROP TABLE retraining",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, '''val'', ', '') WHERE "
        "name = 'image'",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'name TEXT', 'name TEXT COLLATE "
        "NOCASE') WHERE name = 'image'",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = replace(sql, 'CREATE TABLE', 'create table')",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = sql || char(0) || 'x' WHERE name = 'step'",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = (SELECT rootpage FROM sqlite_schema WHERE "
        "name = 'view') WHERE name = 'score'",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = 4000000000 WHERE name = 'view'",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET rootpage = -7 WHERE name = 'view'",
        "PRAGMA writable_schema = ON; WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 5000) "
        "INSERT INTO sqlite_schema SELECT 'table', 't' || i, 't' || i, 3, 'CREATE TABLE t' || i || '(a)' FROM n",
        "PRAGMA writable_schema = ON; UPDATE sqlite_schema SET sql = 'CREATE TABLE score (' || printf('%.100000c', "
        "'x') || ')' WHERE name = 'score'",
    };
    AUTO_FREE char *path = record(*state);
    const struct kept_file kept = temporary_keep(path);
    for (size_t i = 0; i < VW_ARRAY_COUNT(changes); i++) {
        temporary_put_back(&kept);
        sql_run(path, changes[i]);
        assert_refused(path, changes[i]);
    }
}

// ---- Bytes ---------------------------------------------------------------------------------------------------------

static void change_byte(const struct kept_file *kept, size_t at, int value) {
    AUTO_FREE unsigned char *changed = vw_allocate(kept->size_bytes, 1);
    memcpy(changed, kept->bytes, kept->size_bytes);
    changed[at] = (unsigned char)value;
    temporary_write(kept->path, changed, kept->size_bytes);
}

FOLDER_TEST(only_the_header_of_a_ledger_is_read) {
    static const struct {
        size_t at;
        int value;
        const char *what;
    } changes[] = {
        {0, 'X', "magic"},          {16, 0x08, "page size 2048"}, {18, 2, "write-ahead log (write)"},
        {19, 2, "write-ahead log"}, {20, 32, "reserved bytes"},   {21, 32, "payload fraction"},
        {63, 99, "version"},
    };
    AUTO_FREE char *path = record(*state);
    const struct kept_file kept = temporary_keep(path);
    for (size_t i = 0; i < VW_ARRAY_COUNT(changes); i++) {
        change_byte(&kept, changes[i].at, changes[i].value);
        assert_refused(path, changes[i].what);
    }
    temporary_write(path, kept.bytes, kept.size_bytes - PAGE_BYTES);
    assert_refused(path, "cut by a page");
    temporary_write(path, kept.bytes, 100);
    assert_refused(path, "a header alone");
}

// ---- Trees ---------------------------------------------------------------------------------------------------------

static void put_u16(unsigned char *at, uint32_t value) {
    at[0] = (unsigned char)(value >> 8);
    at[1] = (unsigned char)value;
}
static void put_u32(unsigned char *at, uint32_t value) {
    put_u16(at, value >> 16);
    put_u16(at + 2, value & 0xffff);
}

// Pages in a row, each with `children` cells that all lead to the next page, below the root of a table; the last page
// has the rows that the root had.
static void grow_tree(const char *path, const char *table, uint32_t levels, uint32_t children) {
    AUTO_FREE char *sql = vw_format_text("SELECT rootpage FROM sqlite_schema WHERE name = '%s'", table);
    AUTO_FREE char *answer = sql_ask(path, sql);
    uint32_t root = (uint32_t)atoi(answer);
    size_t size_bytes = 0;
    AUTO_FREE void *old = temporary_read(path, &size_bytes);
    uint32_t old_pages = (uint32_t)(size_bytes / PAGE_BYTES), pages = old_pages + levels;
    AUTO_FREE unsigned char *bytes = vw_allocate(pages, PAGE_BYTES);
    memcpy(bytes, old, size_bytes);
    put_u32(bytes + 28, pages);
    memcpy(bytes + (size_t)(pages - 1) * PAGE_BYTES, bytes + (size_t)(root - 1) * PAGE_BYTES, PAGE_BYTES); // the leaf
    for (uint32_t i = 0; i < levels; i++) {
        uint32_t at = i ? old_pages + i : root, next = old_pages + i + 1;
        unsigned char *page = bytes + (size_t)(at - 1) * PAGE_BYTES;
        memset(page, 0, PAGE_BYTES);
        page[0] = 5; // inside a table
        put_u16(page + 3, children - 1);
        put_u16(page + 5, PAGE_BYTES - 8 * children);
        put_u32(page + 8, next);
        for (uint32_t c = 0; c + 1 < children; c++) {
            unsigned char *cell = page + PAGE_BYTES - 8 * (c + 1);
            put_u16(page + 12 + 2 * c, PAGE_BYTES - 8 * (c + 1));
            put_u32(cell, next);
            cell[4] = (unsigned char)(c % 120 + 1); // a key
        }
    }
    ASSERT_OK(vw_file_write(path, bytes, (size_t)pages * PAGE_BYTES));
}

static double cpu_s(void) { return (double)clock() / CLOCKS_PER_SEC; }

// A file of some pages that has billions of rows: whoever counts or sorts them never ends.
FOLDER_TEST(a_tree_whose_pages_are_used_again_is_refused_at_once) {
    static const char *const tables[] = {"score", "run"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(tables); i++) {
        AUTO_FREE char *path = record(*state);
        grow_tree(path, tables[i], 6, 300);
        double began_s = cpu_s();
        assert_refused(path, "tree bomb");
        assert_true(cpu_s() - began_s < 1);
        unlink(path);
    }
}

// SQLite follows a long chain of pages until its stack is exhausted.
FOLDER_TEST(a_tree_that_is_too_deep_is_refused) {
    AUTO_FREE char *path = record(*state);
    grow_tree(path, "score", 25, 1);
    assert_refused(path, "deep tree");
    assert_non_null(strstr(vw_error_message(), "malformed")); // by a cursor, before quick_check
}

// ---- Rows ----------------------------------------------------------------------------------------------------------

static void assert_row_refused(const struct kept_file *kept, const char *sql) {
    uint64_t step_count = 0;
    temporary_put_back(kept);
    sql_change(kept->path, sql);
    ASSERT_CASE_FAILS(sql, test_ledger_read(kept->path, &step_count), VW_ERROR_INPUT, kept->path);
}

FOLDER_TEST(rows_that_no_run_writes_are_refused) {
    static const char *const changes[] = {
        "UPDATE run SET seed = -1",
        "UPDATE run SET device = 'a' || char(0) || 'b'",
        "UPDATE run SET device = x'00'",
        "UPDATE run SET status = 'verified'",
        "UPDATE run SET driver = 'llvmpipe' || char(27) || '[2J'",
        "UPDATE run SET device = printf('%.700c', 'x')",
        "UPDATE run SET config_json = printf('%.20000000c', 'x')",
        "UPDATE image SET image_id = -2 WHERE image_id = 2",
        "UPDATE image SET image_id = 4294967297 WHERE image_id = 2",
        "UPDATE image SET image_id = 4294967295 WHERE image_id = 2",
        "UPDATE image SET name = 'a' || char(0) WHERE image_id = 2",
        "INSERT INTO image SELECT image_id, 'x', name, split, provider, sha256, ground_truth FROM image",
        "DELETE FROM image WHERE image_id = 1",
        "UPDATE step SET step = 9223372036854775807 WHERE step = 10",
        "UPDATE step SET step = -1 WHERE step = 0",
        "UPDATE step SET step = 12 WHERE step = 10",
        "DELETE FROM step WHERE step = 4",
        "INSERT INTO step SELECT 'x', step, epoch, image_id, 0, 0, 0, 0, 0, '', 0, 0 FROM step",
        "UPDATE step SET epoch = -1 WHERE step = 3",
        "UPDATE step SET epoch = 4000000000 WHERE step = 3",
        "UPDATE step SET image_id = 77 WHERE step = 3",
        "UPDATE step SET image_id = -1 WHERE step = 3",
        "UPDATE step SET train_loss = 'x' WHERE step = 3",
        "UPDATE step SET val_psnr = 9e999 WHERE step = 3",
        "UPDATE step SET val_l1 = x'00' WHERE step = 3",
        "UPDATE step SET clamped = -1 WHERE step = 3",
        "UPDATE step SET floored = 4294967296 WHERE step = 3",
        "UPDATE step SET nonfinite = 2 WHERE step = 3",
        "UPDATE view SET image_id = 99 WHERE image_id = 4",
        "UPDATE view SET mse = -9e999",
        "UPDATE view SET l1 = 'x'",
        "UPDATE score SET image_id = 1000 WHERE image_id = 2",
        "UPDATE score SET visits = -1",
        "UPDATE score SET value = 9e999",
        "UPDATE score SET method = method || char(0)",
        "UPDATE score SET rank_ci_low = -1",
        "UPDATE score SET rank_ci_high = 'x'",
        "UPDATE retraining SET retraining = 5 WHERE retraining = 1",
        "DELETE FROM retraining WHERE retraining = 0",
        "UPDATE retraining SET seed = -1",
        "UPDATE retraining SET epochs = 4294967296",
        "UPDATE retraining SET val_psnr = 9e999",
    };
    // No list of photos that are in the ledger to train on, in order, once each.
    static const char *const image_ids[] = {"''",  "' 1'", "'1 '",         "'1  2'", "'01'",           "'2 1'", "'1 1'",
                                            "'0'", "'99'", "'4294967297'", "'-1'",   "'1' || char(0)", "x'31'"};
    AUTO_FREE char *path = record(*state);
    const struct kept_file kept = temporary_keep(path);
    uint64_t step_count = 0;
    ASSERT_OK(test_ledger_read(path, &step_count));
    for (size_t i = 0; i < VW_ARRAY_COUNT(changes); i++) assert_row_refused(&kept, changes[i]);
    for (size_t i = 0; i < VW_ARRAY_COUNT(image_ids); i++) {
        AUTO_FREE char *sql = vw_format_text("UPDATE retraining SET image_ids = %s", image_ids[i]);
        assert_row_refused(&kept, sql);
    }
}

// ---- Stores --------------------------------------------------------------------------------------------------------

FOLDER_TEST(stores_are_checked_likewise) {
    AUTO_FREE char *path = vw_path_join(*state, "retrainings.db");
    struct vw_retraining_store *retrainings = NULL;
    ASSERT_OK(vw_retraining_store_open(path, &retrainings));
    vw_retraining_store_close(&retrainings);
    ASSERT_OK(vw_retraining_store_open(path, &retrainings)); // as it was
    vw_retraining_store_close(&retrainings);
    sql_run(path, "CREATE INDEX forged ON retraining (retraining_id, val_psnr)");
    ASSERT_FAILS(vw_retraining_store_open(path, &retrainings), VW_ERROR_INPUT, path);
}
