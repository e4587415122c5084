#include "cli/output/print.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

enum { TEXT_BYTES = 1024 };

static size_t count_line_ends(const char *text) {
    size_t count = 0;
    for (; *text; text++) count += *text == '\n';
    return count;
}

// Prints text with the line ends of its format. More of them come from a name, which could forge a line; then only the
// last one stays.
static void print_harmless(const char *format, char *text) {
    size_t length = strlen(text);
    bool own_line_ends = count_line_ends(text) == count_line_ends(format);
    bool ends_line = length > 0 && text[length - 1] == '\n' && format[strlen(format) - 1] == '\n';
    if (own_line_ends) {
        vw_text_make_lines(text);
        fputs(text, stdout);
        return;
    }
    if (ends_line) text[length - 1] = 0;
    vw_text_make_line(text);
    fputs(text, stdout);
    if (ends_line) putchar('\n');
}

// Prints a text, cut if it is long and there is no memory for it.
void vw_print(const char *format, ...) {
    char text[TEXT_BYTES], *longer = NULL;
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(text, sizeof text, format, arguments);
    if (length >= TEXT_BYTES) longer = malloc((size_t)length + 1);
    if (longer) vsnprintf(longer, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    print_harmless(format, longer ? longer : text);
    free(longer);
}

// Prints the path for a shell. Each quote in it ends the quoted text, follows a backslash, and opens the text again.
void vw_print_shell_path(const char *path) {
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./+,:=@%";
    const char *folder = path[0] == '-' ? "./" : ""; // else it would be an option
    if (*path && !path[strspn(path, plain)]) {
        vw_print(" %s%s", folder, path);
        return;
    }
    vw_print(" '%s", folder);
    for (const char *end; *path; path = end) {
        size_t length = strcspn(path, "'");
        vw_print("%.*s%s", (int)length, path, path[length] ? "'\\''" : "");
        end = path + length + (path[length] == '\'');
    }
    vw_print("'");
}

// ---- Tables --------------------------------------------------------------------------------------------------------

// Returns the width of a column in bytes; 0 if it is not shown.
static size_t width_of(const struct vw_rows *rows, const struct vw_column *column) {
    char text[VW_CELL_BYTES];
    size_t width = 0;
    bool known = false;
    if (!column->title) return 0;
    for (uint32_t i = 0; i < rows->count; i++) {
        const char *cell = vw_rows_cell(rows, i, column, text);
        known |= cell != NULL;
        if (cell && strlen(cell) > width) width = strlen(cell);
    }
    return !known ? 0 : width > strlen(column->title) ? width : strlen(column->title);
}

// Prints a cell after those before it; `blanks` are left to print, so that no line ends with any.
static void print_cell(const struct vw_column *column, const char *cell, size_t width, size_t *blanks) {
    size_t padding = width > strlen(cell) ? width - strlen(cell) : 0;
    bool right = !vw_column_is_text(column);
    if (*cell) vw_print("%*s%s", (int)(*blanks + (right ? padding : 0)), "", cell);
    *blanks = (*cell ? (right ? 0 : padding) : *blanks + width) + 2;
}

void vw_print_rows(const struct vw_rows *rows) {
    for (uint32_t line = 0; line <= rows->count; line++) {
        size_t blanks = 0;
        for (uint32_t c = 0; c < rows->column_count; c++) {
            const struct vw_column *column = &rows->columns[c];
            size_t width = width_of(rows, column);
            char text[VW_CELL_BYTES];
            const char *cell = line && width ? vw_rows_cell(rows, line - 1, column, text) : column->title;
            if (width) print_cell(column, cell ? cell : vw_column_is_text(column) ? "" : "-", width, &blanks);
        }
        vw_print("\n");
    }
}

// ---- JSON ----------------------------------------------------------------------------------------------------------

enum vw_status vw_json_print(json_t *root) {
    if (!root) return vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON output");
    // In ASCII, so that no name in it controls a terminal.
    int failed = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_ENSURE_ASCII);
    json_decref(root);
    if (failed || putchar('\n') == EOF)
        return vw_fail(VW_ERROR_IO, "stdout: cannot write the JSON output; check where it goes");
    return VW_OK;
}
