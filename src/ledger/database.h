// SQLite with every result checked: an open file, statements, transactions, and rows that are bound and hashed in one
// motion.
#ifndef VIEWWORTH_LEDGER_DATABASE_H
#define VIEWWORTH_LEDGER_DATABASE_H

#include <sqlite3.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/hash.h"
#include "viewworth/status.h"

struct vw_database {
    sqlite3 *handle;
    char *path; // owned, for messages
};

// Opens a file that exists, or one that `create` makes, with durable transactions. Close it also after a failure.
enum vw_status vw_database_open(const char *path, bool create, struct vw_database *database);
void vw_database_close(struct vw_database *database);

// Records what SQLite says of its last failure, and what to do about it.
enum vw_status vw_database_fail(struct vw_database *database, const char *doing);

// Runs statements that give no rows and take no values.
enum vw_status vw_database_run(struct vw_database *database, const char *sql);
// The statement is to be ended with sqlite3_finalize.
enum vw_status vw_database_prepare(struct vw_database *database, const char *sql, sqlite3_stmt **statement);
// Moves on to the next row; `*found` is false after the last one.
enum vw_status vw_database_next(struct vw_database *database, sqlite3_stmt *statement, bool *found);

// Runs `schema_sql`, which sets user_version to `version`, on a file without tables: an empty one is what a process
// leaves that was killed before its first transaction. VW_ERROR_INPUT when the file is of another version, and so not
// `what`.
enum vw_status vw_database_make_tables(struct vw_database *database, const char *schema_sql, int64_t version,
                                       const char *what);

enum vw_status vw_database_begin(struct vw_database *database);
// Begins to read: all queries up to the end see one state of the file, which nobody else can change meanwhile.
enum vw_status vw_database_begin_reading(struct vw_database *database);
// Commits when `status` is VW_OK, else rolls back and returns `status`; a commit that fails is rolled back too.
enum vw_status vw_database_end(struct vw_database *database, enum vw_status status);

// A row on its way into a statement. Each value is bound to the next column and added to `hasher`, so that what is
// stored and what is hashed cannot differ. Either may be NULL: a row without a statement is only hashed. A failure to
// bind is kept and reported by vw_row_write.
struct vw_row {
    sqlite3_stmt *statement;
    struct vw_hasher *hasher;
    int column;
    bool failed;
};

void vw_row_add_integer(struct vw_row *row, int64_t value);
void vw_row_add_real(struct vw_row *row, double value);     // NaN becomes NULL, -0 becomes 0, as SQLite stores them
void vw_row_add_text(struct vw_row *row, const char *text); // borrowed until vw_row_write
void vw_row_add_null(struct vw_row *row);
// Runs the statement and makes it ready for the next row.
enum vw_status vw_row_write(struct vw_row *row, struct vw_database *database, const char *doing);

// A column of numbers, NaN for NULL.
double vw_row_read_real(sqlite3_stmt *statement, int column);
// Adds the first `column_count` columns of the current row of a query, as the vw_row_add functions would.
void vw_row_hash(sqlite3_stmt *statement, int column_count, struct vw_hasher *hasher);
// Copies a column that holds a hash; anything else gives "", which equals no hash.
void vw_row_copy_hash(sqlite3_stmt *statement, int column, char hash[VW_HASH_HEX_BYTES]);
// A row's own hash, for tables without a chain: begun with the table's name and version, so that it is that of no other
// table, then the columns. It fits where the column behind all that are hashed holds what they give.
void vw_row_begin_hash(struct vw_hasher *hasher, const char *table);
void vw_row_end_hash(struct vw_hasher *hasher, char hash[VW_HASH_HEX_BYTES]);
bool vw_row_fits_hash(sqlite3_stmt *statement, int hash_column, const char *table);

#endif
