#include "ledger/merge.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text_stream.h"
#include "ledger/database_file.h"
#include "ledger/ledger_private.h"
#include "ledger/schema.h"

// In a series of its own: see vw_database_format.
enum { MERGED_VERSION = 3001 };

struct vw_merged_ledger {
    struct vw_database database;
    char *path, *part_path; // owned
    bool written;           // the transaction has begun
};

// ---- The schema: that of a ledger, with a key more ----------------------------------------------------------------

// Makes the statements that create the tables of a ledger with `job` as the first column and the first part of the key.
// They omit the ledger's own constraints, which the rows have already met. A table with rowids keeps them, because the
// rowids of scores record an order.
static const char tables_sql[] =
    "SELECT 'CREATE TABLE ' || t.name || ' (job TEXT NOT NULL'"
    " || (SELECT group_concat(', ' || name || ' ' || type, '')"
    "     FROM (SELECT * FROM pragma_table_info(t.name) ORDER BY cid)) || ', PRIMARY KEY (job'"
    " || (SELECT group_concat(', ' || name, '')"
    "     FROM (SELECT * FROM pragma_table_info(t.name) WHERE pk > 0 ORDER BY pk)) || '))'"
    " || iif(wr, ' WITHOUT ROWID;', ';')"
    " FROM pragma_table_list AS t JOIN sqlite_schema AS s ON s.name = t.name AND s.type = 'table' ORDER BY t.name";

// Writes the schema of a merged ledger; the caller owns it.
static enum vw_status write_schema(const char *path, char **schema_sql) {
    struct vw_database ledger;
    struct vw_text_stream text;
    sqlite3_stmt *tables = NULL;
    bool found = false;
    size_t size_bytes = 0;
    enum vw_status status = vw_database_open_memory(path, &vw_ledger_format, &ledger);
    FILE *stream = vw_text_stream_open(&text);
    if (!status) status = vw_database_prepare(&ledger, tables_sql, &tables);
    while (stream && !status && !(status = vw_database_next(&ledger, tables, &found)) && found)
        fputs((const char *)sqlite3_column_text(tables, 0), stream);
    sqlite3_finalize(tables);
    if (stream) fprintf(stream, "PRAGMA user_version = %d;", MERGED_VERSION);
    enum vw_status closed = vw_text_stream_close(&text, "the tables", schema_sql, &size_bytes);
    vw_database_close(&ledger);
    return status ? status : closed;
}

// ---- The file -----------------------------------------------------------------------------------------------------

static void remove_part(const struct vw_merged_ledger *merged) {
    char *journal = vw_format_text("%s-journal", merged->part_path);
    if (journal) unlink(journal);
    unlink(merged->part_path);
    free(journal);
}

static enum vw_status open_part(struct vw_merged_ledger *merged) {
    char *schema_sql = NULL;
    enum vw_status status = write_schema(merged->part_path, &schema_sql);
    const struct vw_database_format format = {
        .schema_sql = schema_sql, .version = MERGED_VERSION, .what = "merged ledgers"};
    if (!status) status = vw_database_open_or_create(merged->part_path, &format, &merged->database);
    if (!status) status = vw_database_begin(&merged->database);
    merged->written = !status;
    free(schema_sql);
    return status;
}

enum vw_status vw_merged_create(const char *path, struct vw_merged_ledger **merged) {
    struct vw_merged_ledger *created = vw_allocate(1, sizeof *created);
    if (!created) return VW_ERROR_MEMORY;
    created->path = vw_copy_text(path);
    created->part_path = vw_format_text("%s.part", path);
    enum vw_status status = created->path && created->part_path ? vw_database_check_free(path) : VW_ERROR_MEMORY;
    if (!status) {
        remove_part(created); // left by a merge that was killed
        status = open_part(created);
    }
    if (status) vw_merged_close(&created);
    else *merged = created;
    return status;
}

enum vw_status vw_merged_finish(struct vw_merged_ledger *merged) {
    merged->written = false;
    enum vw_status status = vw_database_end(&merged->database, VW_OK);
    vw_database_close(&merged->database);
    if (!status) status = vw_database_check_free(merged->path);
    if (!status && rename(merged->part_path, merged->path))
        status = vw_fail(VW_ERROR_IO, "%s: cannot write: %s; check the folder and its permissions", merged->path,
                         strerror(errno));
    return status;
}

void vw_merged_close(struct vw_merged_ledger **merged) {
    struct vw_merged_ledger *closed = *merged;
    if (!closed) return;
    struct vw_saved_error why = vw_error_save();
    if (closed->written) (void)vw_database_end(&closed->database, VW_ERROR_INTERRUPTED);
    vw_database_close(&closed->database);
    if (closed->part_path) remove_part(closed);
    free(closed->path);
    free(closed->part_path);
    free(closed);
    vw_error_restore(&why);
    *merged = NULL;
}

// ---- Rows ---------------------------------------------------------------------------------------------------------

// Prepares "INSERT INTO TABLE VALUES (?, ...)" for a job and a ledger's columns.
static enum vw_status prepare_insert(struct vw_database *to, const char *table, int column_count,
                                     sqlite3_stmt **insert) {
    char sql[512];
    int used = snprintf(sql, sizeof sql, "INSERT INTO %s VALUES (?", table);
    for (int i = 0; i < column_count && used < (int)sizeof sql; i++)
        used += snprintf(sql + used, sizeof sql - (size_t)used, ", ?");
    if (used < (int)sizeof sql) snprintf(sql + used, sizeof sql - (size_t)used, ")");
    return vw_database_prepare(to, sql, insert);
}

static enum vw_status copy_row(struct vw_database *to, const char *job, sqlite3_stmt *row, sqlite3_stmt *insert) {
    bool failed = sqlite3_bind_text(insert, 1, job, -1, SQLITE_STATIC) != SQLITE_OK;
    for (int i = 0; i < sqlite3_column_count(row); i++)
        failed |= sqlite3_bind_value(insert, i + 2, sqlite3_column_value(row, i)) != SQLITE_OK;
    failed = failed || sqlite3_step(insert) != SQLITE_DONE;
    enum vw_status status = failed ? vw_database_fail(to, "merge ledgers") : VW_OK;
    sqlite3_reset(insert);
    return status;
}

// Copies the rows in the order of the table: by its key, or by its rowids.
static enum vw_status copy_table(struct vw_database *from, const char *table, struct vw_database *to, const char *job) {
    sqlite3_stmt *rows = NULL, *insert = NULL;
    bool found = false;
    char *sql = vw_format_text("SELECT * FROM %s", table);
    enum vw_status status = sql ? vw_database_prepare(from, sql, &rows) : VW_ERROR_MEMORY;
    if (!status) status = prepare_insert(to, table, sqlite3_column_count(rows), &insert);
    while (!status && !(status = vw_database_next(from, rows, &found)) && found)
        status = copy_row(to, job, rows, insert);
    sqlite3_finalize(rows);
    sqlite3_finalize(insert);
    free(sql);
    return status;
}

static enum vw_status copy_tables(struct vw_database *from, struct vw_database *to, const char *job) {
    sqlite3_stmt *tables = NULL;
    bool found = false;
    enum vw_status status =
        vw_database_prepare(from, "SELECT name FROM sqlite_schema WHERE type = 'table' ORDER BY name", &tables);
    while (!status && !(status = vw_database_next(from, tables, &found)) && found)
        status = copy_table(from, (const char *)sqlite3_column_text(tables, 0), to, job);
    sqlite3_finalize(tables);
    return status;
}

// Verifies and copies the same rows: a ledger of up to a GiB is a copy in memory (database_open.c).
enum vw_status vw_merged_add(struct vw_merged_ledger *merged, const char *job, struct vw_ledger *ledger) {
    struct vw_database *from = &ledger->database;
    enum vw_status status = vw_ledger_verify(ledger);
    if (!status) status = vw_database_begin_reading(from);
    return status ? status : vw_database_end(from, copy_tables(from, &merged->database, job));
}
