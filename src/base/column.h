// The columns of a table, each with the member of a struct that it shows or stores. One list of them makes the
// statements of a ledger's table (ledger/table.h), and CSV, JSON and text of any rows (base/rows.h).
#ifndef VIEWWORTH_BASE_COLUMN_H
#define VIEWWORTH_BASE_COLUMN_H

#include <stdbool.h>
#include <stddef.h>

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

#endif
