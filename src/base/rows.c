#include "base/rows.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "base/json.h"

// Returns the member of a cell; NULL where its pointer is.
static const void *member_of(const struct vw_rows *rows, uint32_t place, const struct vw_column *column) {
    const char *row = (const char *)rows->rows + (size_t)place * rows->row_bytes;
    if (column->via) row = *(const char *const *)(row + column->via - 1);
    return row ? row + column->offset : NULL;
}

bool vw_column_is_text(const struct vw_column *column) {
    return column->kind <= VW_COLUMN_NAME || column->kind == VW_COLUMN_CHARS;
}

static double real_of(const struct vw_column *column, const void *member) {
    double value = *(const double *)member;
    return column->kind == VW_COLUMN_CENTS_OR_NULL ? value / 100 : value;
}

static bool is_known(const struct vw_column *column, const void *member) {
    if (!member) return false;
    switch (column->kind) {
    case VW_COLUMN_OWNER:
    case VW_COLUMN_TEXT:
    case VW_COLUMN_TEXT_OR_NULL:
    case VW_COLUMN_NAME: return *(const char *const *)member;
    case VW_COLUMN_RANK: return *(const uint32_t *)member;
    case VW_COLUMN_CHARS: return *(const char *)member;
    case VW_COLUMN_REAL:
    case VW_COLUMN_REAL_OR_NULL:
    case VW_COLUMN_CENTS_OR_NULL: return !isnan(*(const double *)member);
    default: return true;
    }
}

// Writes a known cell; reals with `digits` after the point, below 0 with as many as read back to the same double.
static const char *write_cell(const struct vw_column *column, const void *member, int digits,
                              char text[VW_CELL_BYTES]) {
    switch (column->kind) {
    case VW_COLUMN_OWNER:
    case VW_COLUMN_TEXT:
    case VW_COLUMN_TEXT_OR_NULL:
    case VW_COLUMN_NAME: return *(const char *const *)member;
    case VW_COLUMN_CHARS: return member;
    case VW_COLUMN_FLAG: return *(const bool *)member ? "true" : "false";
    case VW_COLUMN_COUNT:
    case VW_COLUMN_RANK:
    case VW_COLUMN_IMAGE:
    case VW_COLUMN_IMAGE_OR_NULL: snprintf(text, VW_CELL_BYTES, "%" PRIu32, *(const uint32_t *)member); break;
    case VW_COLUMN_COUNT64: snprintf(text, VW_CELL_BYTES, "%" PRIu64, *(const uint64_t *)member); break;
    case VW_COLUMN_CENTS:
        snprintf(text, VW_CELL_BYTES, "%" PRIu64 ".%02" PRIu64, *(const uint64_t *)member / 100,
                 *(const uint64_t *)member % 100);
        break;
    case VW_COLUMN_CENTS_OR_NULL: digits = 2; // fall through
    case VW_COLUMN_REAL:
    case VW_COLUMN_REAL_OR_NULL:
        if (digits < 0) vw_csv_real_to_text(real_of(column, member), text);
        else snprintf(text, VW_CELL_BYTES, column->has_sign ? "%+.*f" : "%.*f", digits, real_of(column, member));
    }
    return text;
}

const char *vw_rows_cell(const struct vw_rows *rows, uint32_t place, const struct vw_column *column,
                         char text[VW_CELL_BYTES]) {
    const void *member = member_of(rows, place, column);
    return is_known(column, member) ? write_cell(column, member, column->digits, text) : NULL;
}

// ---- CSV -----------------------------------------------------------------------------------------------------------

// Returns the text of a cell in a CSV file.
static const char *csv_cell(const struct vw_rows *rows, uint32_t place, const struct vw_column *column,
                            char text[VW_CELL_BYTES]) {
    const void *member = member_of(rows, place, column);
    return is_known(column, member) ? write_cell(column, member, -1, text) : "";
}

void vw_rows_print_header(FILE *stream, const struct vw_rows *rows) {
    const char *separator = "";
    for (uint32_t c = 0; c < rows->column_count; c++) {
        if (rows->columns[c].left_out & VW_NOT_IN_CSV) continue;
        fprintf(stream, "%s%s", separator, rows->columns[c].name);
        separator = ",";
    }
    fputc('\n', stream);
}

void vw_rows_print(FILE *stream, const struct vw_rows *rows, const char *before) {
    for (uint32_t i = 0; i < rows->count; i++) {
        fputs(before, stream);
        const char *separator = "";
        for (uint32_t c = 0; c < rows->column_count; c++) {
            const struct vw_column *column = &rows->columns[c];
            char text[VW_CELL_BYTES];
            if (column->left_out & VW_NOT_IN_CSV) continue;
            fputs(separator, stream);
            if (vw_column_is_text(column)) vw_csv_write_text(stream, csv_cell(rows, i, column, text));
            else fputs(csv_cell(rows, i, column, text), stream);
            separator = ",";
        }
        fputc('\n', stream);
    }
}

static void print_all(FILE *stream, const void *rows) {
    vw_rows_print_header(stream, rows);
    vw_rows_print(stream, rows, "");
}

enum vw_status vw_rows_make_csv(const char *path, const struct vw_rows *rows, struct vw_csv_text *made) {
    return vw_csv_make_text(path, print_all, rows, made);
}

enum vw_status vw_rows_write_csv(const char *path, const struct vw_rows *rows) {
    return vw_csv_write_file(path, print_all, rows);
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

static json_t *cell_to_json(const struct vw_rows *rows, uint32_t place, const struct vw_column *column) {
    const void *member = member_of(rows, place, column);
    char text[VW_CELL_BYTES];
    if (!is_known(column, member)) return column->kind == VW_COLUMN_TEXT ? json_string("") : json_null();
    switch (column->kind) {
    case VW_COLUMN_FLAG: return json_boolean(*(const bool *)member);
    case VW_COLUMN_COUNT:
    case VW_COLUMN_RANK:
    case VW_COLUMN_IMAGE:
    case VW_COLUMN_IMAGE_OR_NULL: return json_integer(*(const uint32_t *)member);
    case VW_COLUMN_COUNT64: return json_integer((json_int_t) * (const uint64_t *)member);
    case VW_COLUMN_REAL:
    case VW_COLUMN_REAL_OR_NULL: return vw_json_real(*(const double *)member);
    default: return vw_json_string(write_cell(column, member, -1, text));
    }
}

json_t *vw_row_to_json(const struct vw_rows *rows, uint32_t place) {
    json_t *object = json_object();
    for (uint32_t c = 0; c < rows->column_count; c++)
        if (!(rows->columns[c].left_out & VW_NOT_IN_JSON))
            vw_json_set(&object, rows->columns[c].name, cell_to_json(rows, place, &rows->columns[c]));
    return object;
}

json_t *vw_rows_to_json(const struct vw_rows *rows) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < rows->count; i++) vw_json_append(&array, vw_row_to_json(rows, i));
    return array;
}

json_t *vw_rows_to_arrays(const struct vw_rows *rows) {
    json_t *object = json_object();
    for (uint32_t c = 0; c < rows->column_count; c++) {
        json_t *array = json_array();
        for (uint32_t i = 0; i < rows->count; i++) vw_json_append(&array, cell_to_json(rows, i, &rows->columns[c]));
        vw_json_set(&object, rows->columns[c].name, array);
    }
    return object;
}

json_t *vw_rows_to_texts(const struct vw_rows *rows) {
    json_t *header = json_array(), *array = json_array(), *table = json_object();
    char text[VW_CELL_BYTES];
    for (uint32_t c = 0; c < rows->column_count; c++)
        if (!(rows->columns[c].left_out & VW_NOT_IN_CSV)) vw_json_append(&header, json_string(rows->columns[c].name));
    for (uint32_t i = 0; i < rows->count; i++) {
        json_t *row = json_array();
        for (uint32_t c = 0; c < rows->column_count; c++)
            if (!(rows->columns[c].left_out & VW_NOT_IN_CSV))
                vw_json_append(&row, vw_json_string(csv_cell(rows, i, &rows->columns[c], text)));
        vw_json_append(&array, row);
    }
    vw_json_set(&table, "header", header);
    vw_json_set(&table, "rows", array);
    return table;
}
