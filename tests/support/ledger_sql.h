// The ledger as raw SQL sees it, without our code, for those who look into it and those who tamper with it.
#ifndef VIEWWORTH_TESTS_SUPPORT_LEDGER_SQL_H
#define VIEWWORTH_TESTS_SUPPORT_LEDGER_SQL_H

#include <sqlite3.h>

#include "support/ledger_fixture.h"

static inline sqlite3 *sql_open(const char *path) {
    sqlite3 *raw = NULL;
    assert_int_equal(sqlite3_open_v2(path, &raw, SQLITE_OPEN_READWRITE, NULL), SQLITE_OK);
    return raw;
}

static inline sqlite3_stmt *sql_query(sqlite3 *raw, const char *sql, int64_t value) {
    sqlite3_stmt *statement = NULL;
    if (sqlite3_prepare_v2(raw, sql, -1, &statement, NULL) != SQLITE_OK) fail_msg("%s: %s", sql, sqlite3_errmsg(raw));
    if (sqlite3_bind_parameter_count(statement)) sqlite3_bind_int64(statement, 1, value);
    return statement;
}

// Returns the first column of the first row as text, "NULL" for NULL; to be freed.
static inline char *sql_ask(const char *path, const char *sql) {
    sqlite3 *raw = sql_open(path);
    sqlite3_stmt *statement = sql_query(raw, sql, 0);
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    const char *text = (const char *)sqlite3_column_text(statement, 0);
    char *answer = vw_copy_text(text ? text : "NULL");
    sqlite3_finalize(statement);
    sqlite3_close(raw);
    return answer;
}

static inline void assert_answer(const char *path, const char *sql, const char *expected) {
    char *answer = sql_ask(path, sql);
    if (strcmp(answer, expected) != 0) fail_msg("%s gave %s, not %s", sql, answer, expected);
    free(answer);
}

// All hashes of the chain, and the final hash.
#define SQL_CHAIN                                                                                                      \
    "SELECT group_concat(row_hash) FROM (SELECT row_hash FROM run UNION ALL SELECT row_hash FROM (SELECT row_hash "    \
    "FROM step ORDER BY "                                                                                              \
    "step))"
#define SQL_FINAL_HASH "SELECT final_hash FROM run"

// Runs statements without regard to constraints and gives how many rows they changed.
static inline int sql_run(const char *path, const char *sql) {
    sqlite3 *raw = sql_open(path);
    sqlite3_exec(raw, "PRAGMA ignore_check_constraints = ON; PRAGMA synchronous = OFF", NULL, NULL, NULL);
    if (sqlite3_exec(raw, sql, NULL, NULL, NULL) != SQLITE_OK) fail_msg("%s: %s", sql, sqlite3_errmsg(raw));
    int changes = sqlite3_total_changes(raw);
    sqlite3_close(raw);
    return changes;
}

// Runs statements likewise. Fails the test when no row was changed: it would show nothing.
static inline void sql_change(const char *path, const char *sql) {
    if (sql_run(path, sql) == 0) fail_msg("%s: changed nothing", sql);
}

#endif
