#include "ledger/database.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/memory.h"

void vw_database_close(struct vw_database *database) {
    int result = sqlite3_close(database->handle);
    assert(result == SQLITE_OK); // it fails if a statement is not finalized
    (void)result;
    free(database->path);
    *database = (struct vw_database){0};
}

enum vw_status vw_database_fail(struct vw_database *database, const char *doing) {
    const char *path = database->path;
    const char *message = sqlite3_errmsg(database->handle);
    if (sqlite3_extended_errcode(database->handle) == SQLITE_READONLY_ROLLBACK)
        return vw_fail(VW_ERROR_INPUT,
                       "%s: a program was killed while it wrote here; repeat its command with --resume, which finishes "
                       "or undoes that write, or make the folder anew",
                       path);
    switch (sqlite3_errcode(database->handle)) {
    case SQLITE_FULL:
        return vw_fail(VW_ERROR_IO, "%s: cannot %s: the disk is full; free some space and run again", path, doing);
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
        return vw_fail(VW_ERROR_IO, "%s: cannot %s: another program has locked it; close that program and run again",
                       path, doing);
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_CANTOPEN:
        return vw_fail(VW_ERROR_IO, "%s: cannot %s: %s; check that the folder exists and its permissions", path, doing,
                       message);
    case SQLITE_ERROR:
        return vw_fail(VW_ERROR_INPUT, "%s: cannot %s: %s; check that it is a viewworth ledger", path, doing, message);
    case SQLITE_NOTADB: return vw_fail(VW_ERROR_INPUT, "%s: not a viewworth ledger; check the path", path);
    case SQLITE_CORRUPT:
    case SQLITE_TOOBIG:
        return vw_fail(VW_ERROR_INPUT, "%s: damaged or hostile: %s; restore it from a copy", path, message);
    case SQLITE_INTERRUPT:
        return vw_fail(VW_ERROR_INPUT,
                       "%s: damaged or hostile: it takes more work than a file of its size can need; restore it from a "
                       "copy",
                       path);
    case SQLITE_NOMEM: return vw_fail(VW_ERROR_MEMORY, "%s: cannot %s: out of memory", path, doing);
    default:
        return vw_fail(VW_ERROR_IO, "%s: cannot %s: %s; check the disk and that no other run writes here", path, doing,
                       message);
    }
}

enum vw_status vw_database_run(struct vw_database *database, const char *sql) {
    if (sqlite3_exec(database->handle, sql, NULL, NULL, NULL) != SQLITE_OK)
        return vw_database_fail(database, "set up the ledger");
    return VW_OK;
}

enum vw_status vw_database_prepare(struct vw_database *database, const char *sql, sqlite3_stmt **statement) {
    if (sqlite3_prepare_v2(database->handle, sql, -1, statement, NULL) == SQLITE_OK) return VW_OK;
    return vw_database_fail(database, "query the ledger");
}

enum vw_status vw_database_next(struct vw_database *database, sqlite3_stmt *statement, bool *found) {
    int result = sqlite3_step(statement);
    if (result != SQLITE_ROW && result != SQLITE_DONE) return vw_database_fail(database, "read the ledger");
    *found = result == SQLITE_ROW;
    return VW_OK;
}

enum vw_status vw_database_begin(struct vw_database *database) {
    if (sqlite3_exec(database->handle, "BEGIN IMMEDIATE", NULL, NULL, NULL) == SQLITE_OK) return VW_OK;
    return vw_database_fail(database, "begin a transaction");
}

enum vw_status vw_database_begin_reading(struct vw_database *database) {
    if (sqlite3_exec(database->handle, "BEGIN DEFERRED", NULL, NULL, NULL) == SQLITE_OK) return VW_OK;
    return vw_database_fail(database, "begin to read");
}

enum vw_status vw_database_end(struct vw_database *database, enum vw_status status) {
    if (!status && sqlite3_exec(database->handle, "COMMIT", NULL, NULL, NULL) != SQLITE_OK)
        status = vw_database_fail(database, "commit a transaction");
    // SQLite rolls back on its own after some failures (a full disk). If the rollback fails too, the journal remains
    // and the next program that opens the file rolls back. The first failure is the one to report.
    if (!sqlite3_get_autocommit(database->handle)) sqlite3_exec(database->handle, "ROLLBACK", NULL, NULL, NULL);
    return status;
}

enum vw_status vw_database_read_number(struct vw_database *database, const char *sql, int64_t *number) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(database, sql, &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    if (!status) *number = found ? sqlite3_column_int64(statement, 0) : 0;
    sqlite3_finalize(statement);
    return status;
}

enum vw_status vw_database_run_with(struct vw_database *database, const char *sql, const char *first,
                                    const char *second, const char *doing) {
    struct vw_row row = {0};
    enum vw_status status = vw_database_prepare(database, sql, &row.statement);
    if (status) return status;
    vw_row_add_text(&row, first);
    if (second) vw_row_add_text(&row, second);
    status = vw_row_write(&row, database, doing);
    sqlite3_finalize(row.statement);
    return status;
}

enum vw_status vw_database_read_hash(struct vw_database *database, const char *sql, char hash[VW_HASH_HEX_BYTES]) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_database_prepare(database, sql, &statement);
    if (!status) status = vw_database_next(database, statement, &found);
    hash[0] = 0;
    if (!status && found) vw_row_copy_hash(statement, 0, hash);
    sqlite3_finalize(statement);
    return status;
}

void vw_row_add_integer(struct vw_row *row, int64_t value) {
    if (row->hasher) vw_hasher_add_integer(row->hasher, value);
    if (row->statement && sqlite3_bind_int64(row->statement, ++row->column, value) != SQLITE_OK) row->failed = true;
}

void vw_row_add_real(struct vw_row *row, double value) {
    if (isnan(value)) {
        vw_row_add_null(row);
        return;
    }
    double stored = value == 0 ? 0.0 : value;
    if (row->hasher) vw_hasher_add_real(row->hasher, stored);
    if (row->statement && sqlite3_bind_double(row->statement, ++row->column, stored) != SQLITE_OK) row->failed = true;
}

void vw_row_add_text(struct vw_row *row, const char *text) {
    if (row->hasher) vw_hasher_add_text(row->hasher, text);
    if (row->statement && sqlite3_bind_text(row->statement, ++row->column, text, -1, SQLITE_STATIC) != SQLITE_OK)
        row->failed = true;
}

void vw_row_add_null(struct vw_row *row) {
    if (row->hasher) vw_hasher_add_null(row->hasher);
    if (row->statement && sqlite3_bind_null(row->statement, ++row->column) != SQLITE_OK) row->failed = true;
}

enum vw_status vw_row_write(struct vw_row *row, struct vw_database *database, const char *doing) {
    if (!row->statement) return VW_OK;
    enum vw_status status = VW_OK;
    if (row->failed || sqlite3_step(row->statement) != SQLITE_DONE) status = vw_database_fail(database, doing);
    sqlite3_reset(row->statement); // repeats the failure of the step, if any
    sqlite3_clear_bindings(row->statement);
    row->column = 0;
    row->failed = false;
    return status;
}

double vw_row_read_real(sqlite3_stmt *statement, int column) {
    return sqlite3_column_type(statement, column) == SQLITE_NULL ? NAN : sqlite3_column_double(statement, column);
}

// Hashes all bytes of a text. viewworth never writes a text that contains a zero byte, and such a text must not have
// the same hash as the part before that byte.
static void hash_text(sqlite3_stmt *statement, int column, struct vw_hasher *hasher) {
    const char *text = (const char *)sqlite3_column_text(statement, column);
    size_t size_bytes = (size_t)sqlite3_column_bytes(statement, column);
    if (text && strlen(text) == size_bytes) vw_hasher_add_text(hasher, text);
    else vw_hasher_add_bytes(hasher, text, text ? size_bytes : 0);
}

void vw_row_hash(sqlite3_stmt *statement, int column_count, struct vw_hasher *hasher) {
    for (int i = 0; i < column_count; i++) {
        switch (sqlite3_column_type(statement, i)) {
        case SQLITE_INTEGER: vw_hasher_add_integer(hasher, sqlite3_column_int64(statement, i)); break;
        case SQLITE_FLOAT: vw_hasher_add_real(hasher, sqlite3_column_double(statement, i)); break;
        case SQLITE_TEXT: hash_text(statement, i, hasher); break;
        case SQLITE_BLOB:
            vw_hasher_add_bytes(hasher, sqlite3_column_blob(statement, i), (size_t)sqlite3_column_bytes(statement, i));
            break;
        default: vw_hasher_add_null(hasher);
        }
    }
}

void vw_row_copy_hash(sqlite3_stmt *statement, int column, char hash[VW_HASH_HEX_BYTES]) {
    bool is_text = sqlite3_column_type(statement, column) == SQLITE_TEXT;
    const char *text = is_text ? (const char *)sqlite3_column_text(statement, column) : NULL;
    bool is_hash = text && sqlite3_column_bytes(statement, column) == VW_HASH_HEX_BYTES - 1;
    memcpy(hash, is_hash ? text : "", is_hash ? VW_HASH_HEX_BYTES : 1);
}

void vw_row_begin_hash(struct vw_hasher *hasher, const char *table) {
    vw_hasher_begin(hasher);
    vw_hasher_add_text(hasher, table);
}

void vw_row_end_hash(struct vw_hasher *hasher, char hash[VW_HASH_HEX_BYTES]) {
    uint8_t bytes[VW_HASH_BYTES];
    vw_hasher_end(hasher, bytes);
    vw_hash_to_hex(bytes, hash);
}

bool vw_row_fits_hash(sqlite3_stmt *statement, int hash_column, const char *table) {
    struct vw_hasher hasher;
    char recorded[VW_HASH_HEX_BYTES], computed[VW_HASH_HEX_BYTES];
    vw_row_begin_hash(&hasher, table);
    vw_row_hash(statement, hash_column, &hasher);
    vw_row_end_hash(&hasher, computed);
    vw_row_copy_hash(statement, hash_column, recorded);
    return strcmp(recorded, computed) == 0;
}
