// Man pages and bash completion, from the tables of commands and options.
#ifndef VIEWWORTH_CLI_MANUAL_H
#define VIEWWORTH_CLI_MANUAL_H

#include "cli/program.h"
#include "viewworth/status.h"

// Writes FOLDER/man/NAME.1, FOLDER/man/NAME-COMMAND.1 for every command, and FOLDER/completion/NAME.
// Existing files are replaced. VW_ERROR_USAGE if `folder` is empty, VW_ERROR_IO if a file cannot be written.
enum vw_status vw_manual_write(const struct vw_program *program, const char *folder);

#endif
