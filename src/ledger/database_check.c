#include "ledger/database_file.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

// ---- Limits --------------------------------------------------------------------------------------------------------

enum {
    SQL_BYTES_MOST = 16384,        // a statement, also one in the schema
    SCHEMA_ROW_BYTES_MOST = 32768, // a row of the schema
    ROW_BYTES_MOST = 1 << 24,      // a row of a table; the longest list the photos of a run or retraining
    COLUMNS_MOST = 64,
    SCHEMA_WORK_MOST = 100000, // operations to read a schema; ours takes some hundred
    STEPS_PER_CALL = 1000,     // operations between two calls of spend_work
    WORK_PER_BYTE = 64         // operations to check a file; ours takes about one for every byte
};

enum vw_status vw_database_set_limits(struct vw_database *database) {
    sqlite3 *handle = database->handle;
    sqlite3_limit(handle, SQLITE_LIMIT_SQL_LENGTH, SQL_BYTES_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_LENGTH, ROW_BYTES_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_COLUMN, COLUMNS_MOST);
    sqlite3_limit(handle, SQLITE_LIMIT_ATTACHED, 0);
    // Ours have tables only. A file from elsewhere may have views that never end, or triggers that undo what is
    // written: these are disabled, and refused as soon as the schema is read.
    static const int off[] = {SQLITE_DBCONFIG_ENABLE_VIEW, SQLITE_DBCONFIG_ENABLE_TRIGGER,
                              SQLITE_DBCONFIG_TRUSTED_SCHEMA};
    bool failed = sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL) != SQLITE_OK;
    for (size_t i = 0; i < sizeof off / sizeof off[0]; i++)
        if (sqlite3_db_config(handle, off[i], 0, NULL) != SQLITE_OK) failed = true;
    if (failed) return vw_database_fail(database, "open");
    return vw_database_run(database, "PRAGMA cell_size_check = ON; PRAGMA mmap_size = 0; PRAGMA temp_store = MEMORY;");
}

// Counts operations, not seconds: the same file is refused or taken on every machine.
struct work {
    uint64_t left;
};

static int spend_work(void *context) {
    struct work *work = context;
    if (work->left < STEPS_PER_CALL) return 1;
    work->left -= STEPS_PER_CALL;
    return 0;
}

// ---- The schema ----------------------------------------------------------------------------------------------------

static enum vw_status compare_versions(const struct vw_database *database, const struct vw_database_format *format,
                                       int64_t found) {
    int64_t wanted = format->version, series = VW_DATABASE_VERSION_SERIES;
    const char *path = database->path;
    if (found == wanted) return VW_OK;
    if (found < 1 || found / series != wanted / series)
        return vw_fail(VW_ERROR_INPUT, "%s: not %s; check the path", path, format->what);
    return vw_fail(VW_ERROR_INPUT,
                   "%s: made by a newer viewworth (version %" PRId64 ", this viewworth reads %" PRId64
                   "); update viewworth",
                   path, found % series, wanted % series);
}

static bool is_same_text(sqlite3_stmt *ours, sqlite3_stmt *theirs, int column) {
    const char *expected = (const char *)sqlite3_column_text(ours, column);
    const char *found = (const char *)sqlite3_column_text(theirs, column);
    if (!expected || !found) return sqlite3_column_type(ours, column) == sqlite3_column_type(theirs, column);
    return sqlite3_column_type(theirs, column) == SQLITE_TEXT &&
           sqlite3_column_bytes(ours, column) == sqlite3_column_bytes(theirs, column) && strcmp(expected, found) == 0;
}

enum { SCHEMA_TEXTS = 4, SCHEMA_ROOT = 4 }; // columns
static const char schema_query[] =
    "SELECT type, name, tbl_name, sql, rootpage FROM sqlite_schema ORDER BY type, name, tbl_name, rowid";

static enum vw_status compare_rows(struct vw_database *database, sqlite3_stmt *ours, struct vw_database *expected,
                                   sqlite3_stmt *theirs, struct vw_database_trees *trees) {
    bool more = true, found = true, same = true;
    enum vw_status status = VW_OK;
    while (!status && more && same) {
        status = vw_database_next(expected, ours, &more);
        if (!status) status = vw_database_next(database, theirs, &found);
        same = more == found;
        for (int i = 0; !status && more && same && i < SCHEMA_TEXTS; i++) same = is_same_text(ours, theirs, i);
        if (!status && more && same) {
            sqlite3_int64 root = sqlite3_column_int64(theirs, SCHEMA_ROOT);
            status = vw_database_trees_check(trees, root < 0 || root > UINT32_MAX ? 0 : (uint32_t)root);
        }
    }
    if (status || same) return status;
    return vw_fail(VW_ERROR_INPUT,
                   "%s: damaged or hostile: it has a table, index, view or trigger that viewworth does not make, or "
                   "lacks one; restore it from a copy",
                   database->path);
}

static enum vw_status compare_schema(struct vw_database *database, struct vw_database *expected,
                                     struct vw_database_trees *trees) {
    sqlite3_stmt *ours = NULL, *theirs = NULL;
    enum vw_status status = vw_database_prepare(expected, schema_query, &ours);
    if (!status) status = vw_database_prepare(database, schema_query, &theirs);
    if (!status) status = compare_rows(database, ours, expected, theirs, trees);
    sqlite3_finalize(ours);
    sqlite3_finalize(theirs);
    return status;
}

static enum vw_status check_schema(struct vw_database *database, struct vw_database *expected,
                                   struct vw_database_trees *trees) {
    struct work work = {SCHEMA_WORK_MOST};
    sqlite3_limit(database->handle, SQLITE_LIMIT_LENGTH, SCHEMA_ROW_BYTES_MOST);
    sqlite3_progress_handler(database->handle, STEPS_PER_CALL, spend_work, &work);
    enum vw_status status = vw_database_trees_check(trees, 1);
    if (!status) status = compare_schema(database, expected, trees);
    sqlite3_progress_handler(database->handle, 0, NULL, NULL);
    sqlite3_limit(database->handle, SQLITE_LIMIT_LENGTH, ROW_BYTES_MOST);
    return status;
}

// ---- The contents --------------------------------------------------------------------------------------------------

// Finds rows that an index lacks or has beside those of its table, so that every way to a row leads to the same row;
// and values that a column cannot store.
static enum vw_status check_contents(struct vw_database *database, uint32_t page_count) {
    struct work work = {WORK_PER_BYTE * (uint64_t)VW_DATABASE_PAGE_BYTES * page_count};
    static const char out_of_memory[] = "error code=7";
    sqlite3_stmt *statement = NULL;
    bool found = false;
    sqlite3_progress_handler(database->handle, STEPS_PER_CALL, spend_work, &work);
    enum vw_status status = vw_database_prepare(database, "PRAGMA integrity_check(1)", &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    const char *answer = !status && found ? (const char *)sqlite3_column_text(statement, 0) : NULL;
    // If memory is short, the check lists unread parts as a fault of the file: "... error code=7".
    if (answer && strstr(answer, out_of_memory))
        status = vw_fail(VW_ERROR_MEMORY, "%s: out of memory to check the file; close other programs", database->path);
    if (!status && (!answer || strcmp(answer, "ok") != 0))
        status = vw_fail(VW_ERROR_INPUT, "%s: damaged or hostile: %s; restore it from a copy", database->path,
                         answer ? answer : "it cannot be checked");
    sqlite3_finalize(statement);
    sqlite3_progress_handler(database->handle, 0, NULL, NULL);
    return status;
}

static enum vw_status check_locked(struct vw_database *database, const struct vw_database_format *format,
                                   struct vw_database *expected) {
    int64_t version = 0;
    struct vw_database_trees trees = {0};
    // The first query: it takes the lock, and rolls back when the file is open to append. It reads no schema yet.
    enum vw_status status = vw_database_read_number(database, "PRAGMA user_version", &version);
    if (!status) status = vw_database_check_header(database, format->what, true); // as it is after a rollback
    if (!status) status = compare_versions(database, format, version);
    if (!status) status = vw_database_trees_begin(database, &trees);
    if (!status) status = check_schema(database, expected, &trees);
    if (!status) status = check_contents(database, trees.page_count);
    free(trees.visited);
    return status;
}

enum vw_status vw_database_check(struct vw_database *database, const struct vw_database_format *format,
                                 struct vw_database *expected) {
    enum vw_status status = vw_database_check_header(database, format->what, false);
    if (!status) status = vw_database_begin_reading(database);
    return status ? status : vw_database_end(database, check_locked(database, format, expected));
}
