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

enum vw_status vw_json_print(json_t *root) {
    if (!root) return vw_fail(VW_ERROR_MEMORY, "out of memory for the JSON output");
    // In ASCII, so that no name in it controls a terminal.
    int failed = json_dumpf(root, stdout, JSON_INDENT(2) | JSON_ENSURE_ASCII);
    json_decref(root);
    if (failed || putchar('\n') == EOF)
        return vw_fail(VW_ERROR_IO, "stdout: cannot write the JSON output; check where it goes");
    return VW_OK;
}
