// Help texts on stdout, wrapped at 80 columns.
#ifndef VIEWWORTH_CLI_HELP_H
#define VIEWWORTH_CLI_HELP_H

#include <stdbool.h>

#include "cli/program.h"

// Prints the commands by group.
void vw_help_print_program(const struct vw_program *program);
// Prints a command's usage, its description, and its options by section: the common ones, or all.
void vw_help_print_command(const struct vw_program *program, const struct vw_command *command, bool all);

#endif
