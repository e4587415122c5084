// Help texts on stdout, wrapped at 80 columns; man pages and bash completion. All follow from the tables of commands
// and options.
#ifndef VIEWWORTH_CLI_HELP_H
#define VIEWWORTH_CLI_HELP_H

#include <stdbool.h>

#include "cli/program.h"

// Prints the commands by group.
void vw_help_print_program(const struct vw_program *program);
// Prints a command's usage, its description, and its options by section: the common ones, or all.
void vw_help_print_command(const struct vw_program *program, const struct vw_program_command *command, bool all);

// Writes FOLDER/man/NAME.1, FOLDER/man/NAME-COMMAND.1 for every command, and FOLDER/completion/NAME.
// Existing files are replaced. VW_ERROR_USAGE if `folder` is empty, VW_ERROR_IO if a file cannot be written.
enum vw_status vw_manual_write(const struct vw_program *program, const char *folder);

#endif
