// SQLite with every result checked: an open file, statements, transactions, and rows whose values are bound and hashed
// by the same call.
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

// The format of a file. Each kind of file numbers its user_version in a range of its own, so that none is mistaken for
// another.
enum { VW_DATABASE_VERSION_SERIES = 1000 };
struct vw_database_format {
    const char *schema_sql; // makes the tables and sets user_version
    int64_t version;        // that user_version
    const char *what;       // "a viewworth ledger", for messages
};

enum vw_database_access {
    VW_DATABASE_READ,  // changes nothing: neither the file nor its folder
    VW_DATABASE_APPEND // durable transactions; first finishes what a killed program has left half done
};

// ---- database_open.c: files, which may come from someone who wants to harm, and new ones ----

// Opens a file that exists and checks all of it. VW_ERROR_INPUT if it is not exactly of this format.
enum vw_status vw_database_open(const char *path, const struct vw_database_format *format,
                                enum vw_database_access access, struct vw_database *database);
// Creates a new database in memory with the tables of the format; messages name `path`.
enum vw_status vw_database_open_memory(const char *path, const struct vw_database_format *format,
                                       struct vw_database *database);
// Writes a database in memory as a new file of its path. VW_ERROR_USAGE if that exists.
enum vw_status vw_database_create_file(struct vw_database *database);
// Opens a file to append, and makes it with empty tables if it is missing.
enum vw_status vw_database_open_or_create(const char *path, const struct vw_database_format *format,
                                          struct vw_database *database);
// Closes the database; call it also after a failure of these.
void vw_database_close(struct vw_database *database);

// ---- database.c: statements ----

// Records a message for SQLite's last failure, with the remedy.
enum vw_status vw_database_fail(struct vw_database *database, const char *doing);

// Runs statements that return no rows and have no parameters.
enum vw_status vw_database_run(struct vw_database *database, const char *sql);
// Prepares a statement; the caller ends it with sqlite3_finalize.
enum vw_status vw_database_prepare(struct vw_database *database, const char *sql, sqlite3_stmt **statement);
// Advances to the next row; `*found` is false after the last one.
enum vw_status vw_database_next(struct vw_database *database, sqlite3_stmt *statement, bool *found);

// Reads the integer in the first column of a query's first row; 0 if the query returns no rows.
enum vw_status vw_database_read_number(struct vw_database *database, const char *sql, int64_t *number);

// Runs a statement that returns no rows, with texts for its one or two parameters; `second` is NULL if it has one.
enum vw_status vw_database_run_with(struct vw_database *database, const char *sql, const char *first,
                                    const char *second, const char *doing);
// Reads the hash in the first column of a query's first row; "", which equals no hash, if there is none.
enum vw_status vw_database_read_hash(struct vw_database *database, const char *sql, char hash[VW_HASH_HEX_BYTES]);

enum vw_status vw_database_begin(struct vw_database *database);
// Begins a reading transaction: all queries until its end see the same state of the file.
enum vw_status vw_database_begin_reading(struct vw_database *database);
// Ends a transaction: commits if `status` is VW_OK, otherwise rolls back and returns `status`. A failed commit is
// rolled back too.
enum vw_status vw_database_end(struct vw_database *database, enum vw_status status);

// A row that is written with a statement. Each value is bound to the next column and added to `hasher`, so that the
// stored and the hashed values cannot differ. Either may be NULL: without a statement, the row is only hashed.
// vw_row_write reports a failure to bind.
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
// Runs the statement and resets it for the next row.
enum vw_status vw_row_write(struct vw_row *row, struct vw_database *database, const char *doing);

// Returns the number in a column; NaN for NULL.
double vw_row_read_real(sqlite3_stmt *statement, int column);
// Adds the first `column_count` columns of the current row of a query, as the vw_row_add functions do.
void vw_row_hash(sqlite3_stmt *statement, int column_count, struct vw_hasher *hasher);
// Copies the hash in a column; "", which equals no hash, if the column has something else.
void vw_row_copy_hash(sqlite3_stmt *statement, int column, char hash[VW_HASH_HEX_BYTES]);
// Begins the hash of a single row, for tables without a chain. The hash covers the name and version of the table, so
// that a row of another table has another hash, and then the columns. The hash column follows the hashed columns.
void vw_row_begin_hash(struct vw_hasher *hasher, const char *table);
void vw_row_end_hash(struct vw_hasher *hasher, char hash[VW_HASH_HEX_BYTES]);
bool vw_row_fits_hash(sqlite3_stmt *statement, int hash_column, const char *table);

#endif
