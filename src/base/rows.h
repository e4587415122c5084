// Rows of structs as CSV, JSON and text, by one list of columns (base/column.h). What is unknown (NaN, a rank of 0, a
// NULL text or pointer) is an empty field, null, or "-".
#ifndef VIEWWORTH_BASE_ROWS_H
#define VIEWWORTH_BASE_ROWS_H

#include <jansson.h>
#include <stdint.h>
#include <stdio.h>

#include "base/column.h"
#include "base/csv.h"
#include "base/memory.h"

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
