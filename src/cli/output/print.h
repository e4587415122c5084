// Printing of commands: all text and JSON for stdout passes through here, since names in it come from files of
// strangers.
#ifndef VIEWWORTH_CLI_OUTPUT_PRINT_H
#define VIEWWORTH_CLI_OUTPUT_PRINT_H

#include <jansson.h>

#include "base/json.h"
#include "base/rows.h"
#include "viewworth/status.h"

// Digits after the point of every score that is printed.
#define VW_SCORE_DIGITS ".2"

// Prints to stdout as printf does, but the text cannot control a terminal: it replaces what vw_text_make_line()
// replaces, except the line ends of `format`. main() reports a failure to write.
void vw_print(const char *format, ...) __attribute__((format(printf, 1, 2)));
// Prints a space and a path as a shell takes it: quoted where it must be, and not as an option.
void vw_print_shell_path(const char *path);
// Prints the columns of rows that have a title and a known cell: a heading, then a line for each row. Numbers stand at
// the right of their column, texts at its left.
void vw_print_rows(const struct vw_rows *rows);

// Prints `root` and a line end, and drops the reference. NULL, which jansson returns when memory is short, is
// VW_ERROR_MEMORY; VW_ERROR_IO: stdout cannot be written.
enum vw_status vw_json_print(json_t *root);

#endif
