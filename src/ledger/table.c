#include "ledger/table.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/text_stream.h"
#include "viewworth/types.h"

// ---- Statements ----------------------------------------------------------------------------------------------------

static char *list_columns(const struct vw_table *table, bool as_placeholders) {
    char *list = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream text;
    FILE *stream = vw_text_stream_open(&text);
    for (int i = 0; stream && i < table->column_count; i++)
        fprintf(stream, "%s%s", i ? ", " : "", as_placeholders ? "?" : table->columns[i].name);
    if (stream && table->has_hash) fputs(as_placeholders ? ", ?" : ", row_hash", stream);
    return vw_text_stream_close(&text, "columns", &list, &size_bytes) ? NULL : list;
}

static enum vw_status prepare_insert(struct vw_database *database, const struct vw_table *table,
                                     sqlite3_stmt **statement) {
    char *names = list_columns(table, false), *places = list_columns(table, true), *sql = NULL;
    if (names && places)
        sql = vw_format_text("%s INTO %s (%s) VALUES (%s)", table->insert ? table->insert : "INSERT", table->name,
                             names, places);
    enum vw_status status = sql ? vw_database_prepare(database, sql, statement) : VW_ERROR_MEMORY;
    free(names);
    free(places);
    free(sql);
    return status;
}

// Prepares the query of all columns; `rest` follows the name of the table.
static enum vw_status prepare_query(struct vw_database *database, const struct vw_table *table, char *owned_rest,
                                    sqlite3_stmt **statement) {
    char *names = list_columns(table, false), *sql = NULL;
    if (names && owned_rest) sql = vw_format_text("SELECT %s FROM %s %s", names, table->name, owned_rest);
    enum vw_status status = sql ? vw_database_prepare(database, sql, statement) : VW_ERROR_MEMORY;
    free(names);
    free(owned_rest);
    free(sql);
    return status;
}

// ---- Inserting -----------------------------------------------------------------------------------------------------

static void add_or_null(struct vw_row *row, uint32_t value, uint32_t null) {
    if (value == null) vw_row_add_null(row);
    else vw_row_add_integer(row, value);
}

static void add_column(struct vw_row *row, const struct vw_column *column, const char *owner, const void *from) {
    const void *member = (const char *)from + column->offset;
    switch (column->kind) {
    case VW_COLUMN_OWNER: vw_row_add_text(row, owner); break;
    case VW_COLUMN_TEXT:
    case VW_COLUMN_TEXT_OR_NULL:
    case VW_COLUMN_NAME: vw_row_add_text(row, *(const char *const *)member); break;
    case VW_COLUMN_FLAG: vw_row_add_integer(row, *(const bool *)member); break;
    case VW_COLUMN_COUNT:
    case VW_COLUMN_IMAGE: vw_row_add_integer(row, *(const uint32_t *)member); break;
    case VW_COLUMN_COUNT64: vw_row_add_integer(row, *(const int64_t *)member); break;
    case VW_COLUMN_RANK: add_or_null(row, *(const uint32_t *)member, 0); break;
    case VW_COLUMN_IMAGE_OR_NULL: add_or_null(row, *(const uint32_t *)member, VW_RECORD_UNTRAINED); break;
    case VW_COLUMN_REAL:
    case VW_COLUMN_REAL_OR_NULL: vw_row_add_real(row, *(const double *)member); break;
    default: row->failed = true; // no kind of a ledger
    }
}

enum vw_status vw_insertion_begin(struct vw_database *database, const struct vw_table *table, const char *owner,
                                  struct vw_insertion *insertion) {
    *insertion = (struct vw_insertion){.database = database, .table = table, .owner = owner};
    return prepare_insert(database, table, &insertion->row.statement);
}

void vw_insertion_add_columns(struct vw_insertion *insertion, const void *row) {
    for (int i = 0; i < insertion->table->column_count; i++)
        add_column(&insertion->row, &insertion->table->columns[i], insertion->owner, row);
}

enum vw_status vw_insertion_write(struct vw_insertion *insertion, const char *row_hash) {
    struct vw_row row = insertion->row;
    row.hasher = NULL; // a hash does not cover itself
    if (row_hash) vw_row_add_text(&row, row_hash);
    insertion->row.column = 0;
    insertion->row.failed = false;
    return vw_row_write(&row, insertion->database, insertion->table->doing);
}

enum vw_status vw_insertion_add(struct vw_insertion *insertion, const void *row) {
    struct vw_hasher hasher;
    char hash[VW_HASH_HEX_BYTES];
    const char *hashed_as = insertion->table->hashed_as;
    if (hashed_as) {
        insertion->row.hasher = &hasher;
        vw_row_begin_hash(&hasher, hashed_as);
    }
    vw_insertion_add_columns(insertion, row);
    if (hashed_as) {
        vw_row_end_hash(&hasher, hash);
        insertion->row.hasher = NULL; // one that the caller set serves its other rows, too
    }
    return vw_insertion_write(insertion, hashed_as ? hash : NULL);
}

void vw_insertion_end(struct vw_insertion *insertion) {
    sqlite3_finalize(insertion->row.statement);
    *insertion = (struct vw_insertion){0};
}

enum vw_status vw_table_insert(struct vw_database *database, const struct vw_table *table, const char *owner,
                               const void *rows, uint64_t count, struct vw_hasher *hasher) {
    struct vw_insertion insertion;
    enum vw_status status = vw_insertion_begin(database, table, owner, &insertion);
    insertion.row.hasher = hasher;
    for (uint64_t i = 0; !status && i < count; i++)
        status = vw_insertion_add(&insertion, (const char *)rows + i * table->row_bytes);
    vw_insertion_end(&insertion);
    return status;
}

bool vw_table_accepts(const struct vw_table *table, const void *rows, uint64_t count) {
    for (int c = 0; c < table->column_count; c++) {
        const struct vw_column *column = &table->columns[c];
        bool nullable = column->kind == VW_COLUMN_REAL_OR_NULL;
        if (!nullable && column->kind != VW_COLUMN_REAL) continue;
        for (uint64_t i = 0; i < count; i++) {
            double value = *(const double *)((const char *)rows + i * table->row_bytes + column->offset);
            if (nullable ? isinf(value) : !isfinite(value)) return false;
        }
    }
    return true;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

enum vw_status vw_table_select(struct vw_database *database, const struct vw_table *table, const char *order,
                               sqlite3_stmt **statement) {
    return prepare_query(database, table, vw_format_text("ORDER BY %s", order ? order : table->order), statement);
}

enum vw_status vw_table_hash(struct vw_database *database, const struct vw_table *table, struct vw_hasher *hasher) {
    sqlite3_stmt *statement = NULL;
    bool found = false;
    enum vw_status status = vw_table_select(database, table, NULL, &statement);
    while (!status && !(status = vw_database_next(database, statement, &found)) && found)
        vw_row_hash(statement, table->column_count, hasher);
    sqlite3_finalize(statement);
    return status;
}

static void fill_reals(const struct vw_table *table, sqlite3_stmt *statement, void *row) {
    for (int i = 0; i < table->column_count; i++) {
        const struct vw_column *column = &table->columns[i];
        if (column->kind == VW_COLUMN_REAL || column->kind == VW_COLUMN_REAL_OR_NULL)
            *(double *)((char *)row + column->offset) = vw_row_read_real(statement, i);
    }
}

enum vw_status vw_table_find(struct vw_database *database, const struct vw_table *table, const char *owner, void *row,
                             enum vw_found *found) {
    const struct vw_column *columns = table->columns;
    struct vw_row key = {0};
    bool there = false;
    char *where = table->key_count == 1 ? vw_format_text("WHERE %s = ?", columns[0].name)
                                        : vw_format_text("WHERE %s = ? AND %s = ?", columns[0].name, columns[1].name);
    enum vw_status status = prepare_query(database, table, where, &key.statement);
    for (int i = 0; i < table->key_count; i++) add_column(&key, &columns[i], owner, row);
    if (!status && key.failed) status = vw_database_fail(database, "find a row");
    if (!status) status = vw_database_next(database, key.statement, &there);
    if (!status) *found = VW_ROW_ABSENT;
    if (!status && there) {
        bool intact = vw_row_fits_hash(key.statement, table->column_count, table->hashed_as);
        *found = intact ? VW_ROW_FOUND : VW_ROW_EDITED;
        if (intact) fill_reals(table, key.statement, row);
    }
    sqlite3_finalize(key.statement);
    return status;
}

// ---- Lists ---------------------------------------------------------------------------------------------------------

char *vw_table_list_ids(const uint32_t *ids, uint32_t count) {
    char *text = NULL;
    size_t size_bytes = 0;
    struct vw_text_stream list;
    FILE *stream = vw_text_stream_open(&list);
    for (uint32_t i = 0; stream && i < count; i++) fprintf(stream, "%s%" PRIu32, i ? " " : "", ids[i]);
    return vw_text_stream_close(&list, "photos of a retraining", &text, &size_bytes) ? NULL : text;
}
