// Printing of commands: all text for stdout passes through here, since names in it come from files of strangers.
#ifndef VIEWWORTH_CLI_OUTPUT_PRINT_H
#define VIEWWORTH_CLI_OUTPUT_PRINT_H

// Digits after the point of every score that is printed.
#define VW_SCORE_DIGITS ".4"

// Prints to stdout as printf does, but the text cannot control a terminal: it replaces what vw_text_make_line()
// replaces, except the line ends of `format`. main() reports a failure to write.
void vw_print(const char *format, ...) __attribute__((format(printf, 1, 2)));
// Prints a space and a path as a shell takes it: quoted where it must be, and not as an option.
void vw_print_shell_path(const char *path);

#endif
