// Help texts on stdout, wrapped at 80 columns.
#ifndef VIEWWORTH_CLI_HELP_H
#define VIEWWORTH_CLI_HELP_H

#include <stdbool.h>
#include <stddef.h>

#include "cli/options.h"

// The commands by group.
void vw_help_print_program(const struct vw_command *commands, size_t count);
// A command's usage, what it does, and its options by section: the common ones, or all.
void vw_help_print_command(const struct vw_command *command, bool all);
const char *vw_command_group_title(enum vw_command_group group);

#endif
