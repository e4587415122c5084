#include "base/csv.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/text_stream.h"

// Returns whether a spreadsheet would evaluate the text, with or without its leading apostrophes and quotes. Those of
// East Asia also take the signs in full width: U+FF1D, U+FF0B, U+FF0D, U+FF20.
static bool looks_like_formula(const char *text) {
    static const char *const wide[] = {"\xef\xbc\x9d", "\xef\xbc\x8b", "\xef\xbc\x8d", "\xef\xbc\xa0"};
    text += strspn(text, "'\"");
    for (size_t i = 0; i < VW_ARRAY_COUNT(wide); i++)
        if (!strncmp(text, wide[i], strlen(wide[i]))) return true;
    return *text && strchr("=+-@\t\r\n", *text);
}

// Returns the length of the part up to which a text is one cell everywhere: where a comma separates decimals, a
// semicolon separates cells, whatever quotes say.
static size_t cell_bytes(const char *text) {
    size_t length = strcspn(text, ";");
    return length + (text[length] == ';');
}

// Takes away the apostrophes that vw_csv_write_text() has put before cells.
static void drop_guards(char *text) {
    char *to = text;
    while (*text) {
        text += *text == '\'' && looks_like_formula(text);
        size_t length = cell_bytes(text);
        memmove(to, text, length);
        to += length;
        text += length;
    }
    *to = 0;
}

// ---- Reading ----

enum vw_status vw_csv_open(const char *path, size_t limit_bytes, struct vw_csv *csv) {
    void *text = NULL;
    size_t size_bytes = 0;
    *csv = (struct vw_csv){.path = path};
    enum vw_status status = vw_file_read(path, limit_bytes, &text, &size_bytes);
    return status ? status : vw_csv_take(path, text, size_bytes, csv);
}

enum vw_status vw_csv_take(const char *path, void *text, size_t size_bytes, struct vw_csv *csv) {
    static const char byte_order_mark[] = "\xef\xbb\xbf";
    *csv = (struct vw_csv){.path = path, .text = text, .size_bytes = size_bytes, .separator = ',', .next_line = 1};
    if (memchr(text, 0, size_bytes)) return vw_fail(VW_ERROR_INPUT, "%s: has a zero byte; give a text file", path);
    csv->next =
        csv->text + (strncmp(csv->text, byte_order_mark, strlen(byte_order_mark)) == 0 ? strlen(byte_order_mark) : 0);
    return VW_OK;
}

void vw_csv_close(struct vw_csv *csv) {
    free(csv->text);
    free(csv->fields);
    *csv = (struct vw_csv){0};
}

// Returns the number of bytes of the line end here; 0: no line end, or the end of the file.
static size_t line_end_bytes(const char *text) {
    return text[0] == '\n' ? 1 : text[0] == '\r' && text[1] == '\n' ? 2 : 0;
}

// Reads a field that begins after a quote, in place, and moves csv->next past the closing quote.
static enum vw_status take_quoted(struct vw_csv *csv) {
    char *from = csv->next, *to = csv->next;
    uint32_t line = csv->next_line;
    while (*from && (*from != '"' || from[1] == '"')) {
        csv->next_line += *from == '\n';
        from += *from == '"';
        *to++ = *from++;
    }
    if (!*from)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: a quote is not closed; close it, and double the quotes within the field",
                       csv->path, line);
    csv->next = from + 1;
    if (*csv->next && *csv->next != ',' && !line_end_bytes(csv->next))
        return vw_fail(VW_ERROR_INPUT, "%s:%u: text follows a closing quote; double the quotes within a quoted field",
                       csv->path, csv->next_line);
    *to = 0; // it cannot reach csv->next
    return VW_OK;
}

static enum vw_status take_plain(struct vw_csv *csv) {
    bool quotes = csv->separator == ',';
    while (*csv->next && *csv->next != csv->separator && !(quotes && *csv->next == '"') && !line_end_bytes(csv->next))
        csv->next++;
    if (!quotes || *csv->next != '"') return VW_OK;
    return vw_fail(VW_ERROR_INPUT,
                   "%s:%u: a quote within a field; put the whole field in quotes and double the quotes within it",
                   csv->path, csv->next_line);
}

// Reads one field; `*more`: another field follows in the record. The separator is overwritten by the field's end.
static enum vw_status take_field(struct vw_csv *csv, bool *more) {
    if (csv->field_count == VW_CSV_FIELDS_MAX)
        return vw_fail(VW_ERROR_INPUT, "%s:%u: more than %d fields; give a table with fewer columns", csv->path,
                       csv->line, VW_CSV_FIELDS_MAX);
    enum vw_status status =
        vw_grow((void **)&csv->fields, &csv->field_capacity, csv->field_count + (size_t)1, sizeof *csv->fields);
    if (status) return status;
    bool quoted = csv->separator == ',' && *csv->next == '"';
    csv->next += quoted;
    csv->fields[csv->field_count++] = csv->next;
    status = quoted ? take_quoted(csv) : take_plain(csv);
    if (status) return status;
    char *end = csv->next;
    size_t end_bytes = line_end_bytes(end);
    *more = *end == csv->separator;
    csv->next += *more ? 1 : end_bytes;
    csv->next_line += end_bytes > 0;
    *end = 0;
    if (csv->separator == ',') drop_guards(csv->fields[csv->field_count - 1]);
    return VW_OK;
}

enum vw_status vw_csv_next(struct vw_csv *csv, bool *found) {
    for (size_t bytes; (bytes = line_end_bytes(csv->next)); csv->next += bytes) csv->next_line++;
    csv->field_count = 0;
    csv->line = csv->next_line;
    *found = *csv->next != 0;
    enum vw_status status = VW_OK;
    for (bool more = *found; !status && more;) status = take_field(csv, &more);
    return status;
}

// ---- Writing ----

void vw_csv_write_text(FILE *stream, const char *text) {
    if (!text) return;
    bool quoted = strpbrk(text, ",;\"\r\n");
    if (quoted) fputc('"', stream);
    while (*text) {
        if (looks_like_formula(text)) fputc('\'', stream);
        for (size_t left = cell_bytes(text); left; left--, text++) {
            if (*text == '"') fputc('"', stream);
            fputc(*text, stream);
        }
    }
    if (quoted) fputc('"', stream);
}

void vw_csv_real_to_text(double value, char text[VW_CSV_REAL_BYTES]) {
    char shortest[VW_CSV_REAL_BYTES] = "";
    if (value == 0) value = 0; // a ledger keeps no -0: a table made again from it must be the same
    for (int digits = 15; digits <= 17 && !isnan(value); digits++) {
        snprintf(shortest, sizeof shortest, "%.*g", digits, value);
        if (strtod(shortest, NULL) == value) break;
    }
    memcpy(text, shortest, sizeof shortest);
}

void vw_csv_write_real(FILE *stream, double value) {
    char text[VW_CSV_REAL_BYTES];
    vw_csv_real_to_text(value, text);
    fputs(text, stream);
}

void vw_csv_print(FILE *stream, const char *pattern, ...) {
    va_list fields;
    va_start(fields, pattern);
    for (; *pattern; pattern++) {
        switch (*pattern) {
        case 't': vw_csv_write_text(stream, va_arg(fields, const char *)); break;
        case 'r': vw_csv_write_real(stream, va_arg(fields, double)); break;
        case 'u': fprintf(stream, "%u", va_arg(fields, unsigned)); break;
        default: fputc(*pattern, stream);
        }
    }
    va_end(fields);
}

enum vw_status vw_csv_make_text(const char *path, vw_csv_printer *print, const void *context,
                                struct vw_csv_text *made) {
    struct vw_text_stream table;
    if (vw_text_stream_open(&table)) print(table.stream, context);
    return vw_text_stream_close(&table, path, &made->text, &made->size_bytes);
}

enum vw_status vw_csv_write_file(const char *path, vw_csv_printer *print, const void *context) {
    struct vw_csv_text text = {0};
    enum vw_status status = vw_csv_make_text(path, print, context, &text);
    if (!status) status = vw_file_write(path, text.text, text.size_bytes);
    free(text.text);
    return status;
}

// ---- A name a line ----

static char *trim(char *line) {
    while (isspace((unsigned char)*line)) line++;
    char *end = line + strlen(line);
    while (end > line && isspace((unsigned char)end[-1])) end--;
    *end = 0;
    return line;
}

static const size_t NAMES_LIMIT_BYTES = (size_t)1 << 26;

enum vw_status vw_names_read(const char *path, vw_name_taker *take_each, void *context, uint32_t *count) {
    void *text;
    size_t size_bytes;
    *count = 0;
    enum vw_status status = vw_file_read(path, NAMES_LIMIT_BYTES, &text, &size_bytes);
    if (status) return status;
    char *rest = text;
    for (int line = 1; !status && rest; line++) {
        char *name = trim(strsep(&rest, "\n"));
        if (!*name) continue;
        status = take_each(context, line, name);
        ++*count;
    }
    free(text);
    return status;
}
