// Rows of structs as CSV, JSON and text, by one list of columns, each with the member of a struct that it shows or
// stores. The list also makes the statements of a ledger's table (ledger/table.h). What is unknown (NaN, a rank of 0, a
// NULL text or pointer) is an empty field, null, or "-".
#ifndef VIEWWORTH_BASE_ROWS_H
#define VIEWWORTH_BASE_ROWS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/csv.h"
#include "base/memory.h"

// The kind of a column, with the type of its member and the values that viewworth writes.
enum vw_column_kind {
    VW_COLUMN_OWNER,         // no member: a text that all inserted rows share, such as the run_id
    VW_COLUMN_TEXT,          // const char *: UTF-8 without control characters, as all texts of a ledger
    VW_COLUMN_TEXT_OR_NULL,  // const char *
    VW_COLUMN_NAME,          // const char *: a short one, which pages and tables show
    VW_COLUMN_FLAG,          // bool
    VW_COLUMN_COUNT,         // uint32_t
    VW_COLUMN_COUNT64,       // uint64_t below 2^63
    VW_COLUMN_RANK,          // uint32_t; 0: NULL
    VW_COLUMN_IMAGE,         // uint32_t: the id of an image of the ledger
    VW_COLUMN_IMAGE_OR_NULL, // uint32_t; VW_RECORD_UNTRAINED: NULL
    VW_COLUMN_REAL,          // double, finite
    VW_COLUMN_REAL_OR_NULL,  // double, finite; NaN: NULL
    // In rows alone, not in a ledger:
    VW_COLUMN_CHARS,        // char[]: a text in the row itself; "": NULL
    VW_COLUMN_CENTS,        // uint64_t: an amount, "12.34"
    VW_COLUMN_CENTS_OR_NULL // double: an amount, rounded; NaN: NULL
};

enum { VW_NOT_IN_CSV = 1, VW_NOT_IN_JSON = 2 };

struct vw_column {
    const char *name; // in SQL and in the header of a CSV file, and the key in JSON
    enum vw_column_kind kind;
    size_t offset;     // the place of the member in the struct of a row, or in what `via` points to
    size_t via;        // 1 more than the place of a pointer in the row, which may be NULL; 0: none
    unsigned left_out; // VW_NOT_IN_...: CSV or JSON lacks the column; text lacks every column without a title
    const char *title; // heading in text
    int digits;        // digits of a real in text
    bool has_sign;     // a real in text has its sign, also above 0
};

// The members of a column, for lists that set further ones: {VW_CELL("psnr", struct row, REAL, psnr), .title = "PSNR"}.
#define VW_CELL(column_name, row, column_kind, member)                                                                 \
    .name = (column_name), .kind = VW_COLUMN_##column_kind, .offset = offsetof(row, member)
// The same of a member of the struct `to`, to which `pointer` in the row points.
#define VW_CELL_VIA(column_name, row, pointer, column_kind, to, member)                                                \
    .name = (column_name), .kind = VW_COLUMN_##column_kind, .offset = offsetof(to, member),                            \
    .via = offsetof(row, pointer) + 1
#define VW_COLUMN_AS(column_name, row, column_kind, member)                                                            \
    { VW_CELL(column_name, row, column_kind, member) }
#define VW_COLUMN(row, column_kind, member) VW_COLUMN_AS(#member, row, column_kind, member)
#define VW_COLUMN_OF_OWNER(column_name)                                                                                \
    { .name = (column_name), .kind = VW_COLUMN_OWNER }

// All borrowed.
struct vw_rows {
    const struct vw_column *columns;
    uint32_t column_count;
    const void *rows;
    uint32_t count;
    size_t row_bytes;
};
// Rows of an array, by the array of their columns.
#define VW_ROWS(list, array, row_count)                                                                                \
    ((struct vw_rows){.columns = (list),                                                                               \
                      .column_count = (uint32_t)VW_ARRAY_COUNT(list),                                                  \
                      .rows = (array),                                                                                 \
                      .count = (row_count),                                                                            \
                      .row_bytes = sizeof *(array)})

// Prints the header of a CSV file, or the rows; each row begins with `before`, which is CSV itself.
void vw_rows_print_header(FILE *stream, const struct vw_rows *rows);
void vw_rows_print(FILE *stream, const struct vw_rows *rows, const char *before);
// Makes header and rows in memory; `path` is for the message. VW_ERROR_MEMORY.
enum vw_status vw_rows_make_csv(const char *path, const struct vw_rows *rows, struct vw_csv_text *made);
// Writes the same to a file, whole or not at all.
enum vw_status vw_rows_write_csv(const char *path, const struct vw_rows *rows);

// Returns an array of objects, an object, an object of an array per column, or {"header": [text], "rows": [[text]]}
// with the texts of the CSV file; NULL when memory is short.
json_t *vw_rows_to_json(const struct vw_rows *rows);
json_t *vw_row_to_json(const struct vw_rows *rows, uint32_t place);
json_t *vw_rows_to_arrays(const struct vw_rows *rows);
json_t *vw_rows_to_texts(const struct vw_rows *rows);

// Returns a cell as text shows it, with its column's digits: from `text`, or lent by the row. NULL: it is unknown.
enum { VW_CELL_BYTES = 48 };
const char *vw_rows_cell(const struct vw_rows *rows, uint32_t place, const struct vw_column *column,
                         char text[VW_CELL_BYTES]);
bool vw_column_is_text(const struct vw_column *column);

#endif
