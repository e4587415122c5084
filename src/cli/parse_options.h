// The parser of command lines: it fills struct vw_options by the table of options.
#ifndef VIEWWORTH_CLI_PARSE_OPTIONS_H
#define VIEWWORTH_CLI_PARSE_OPTIONS_H

#include <stdbool.h>

#include "cli/options.h"
#include "cli/program.h"
#include "viewworth/status.h"

// Reads a command's arguments (argv[0] is the command's name) over the program's defaults; `options` begins a struct of
// program->options_bytes. VW_ERROR_USAGE names the option and what it takes or needs. With --help nothing
// is required.
enum vw_status vw_options_parse(const struct vw_program *program, const struct vw_program_command *command, int argc,
                                char **argv, struct vw_options *options);
// Returns true if the command line contains the option of that name (without dashes).
bool vw_options_have(const struct vw_options *options, const char *name);

#endif
