// The columns of a table, each with the member of a struct that it stores.
#ifndef VIEWWORTH_LEDGER_COLUMN_H
#define VIEWWORTH_LEDGER_COLUMN_H

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
    VW_COLUMN_REAL_OR_NULL   // double, finite; NaN: NULL
};

struct vw_column {
    const char *name;
    enum vw_column_kind kind;
    size_t offset; // the place of the member in the struct of a row
};
#define VW_COLUMN(row, column_kind, member) VW_COLUMN_AS(#member, row, column_kind, member)
#define VW_COLUMN_AS(column_name, row, column_kind, member)                                                            \
    { column_name, VW_COLUMN_##column_kind, offsetof(row, member) }
#define VW_COLUMN_OF_OWNER(column_name)                                                                                \
    { column_name, VW_COLUMN_OWNER, 0 }

#endif
