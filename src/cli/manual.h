// Man pages and bash completion, from the tables of commands and options.
#ifndef VIEWWORTH_CLI_MANUAL_H
#define VIEWWORTH_CLI_MANUAL_H

#include <stddef.h>

#include "cli/options.h"
#include "viewworth/status.h"

// Writes FOLDER/man/viewworth.1, FOLDER/man/viewworth-COMMAND.1 for every command, and FOLDER/completion/viewworth.
// Existing files are replaced. VW_ERROR_USAGE if `folder` is empty, VW_ERROR_IO if a file cannot be written.
enum vw_status vw_manual_write(const char *folder, const struct vw_command *commands, size_t count);

#endif
