// A program from its command line to its exit code.
#ifndef VIEWWORTH_CLI_RUN_PROGRAM_H
#define VIEWWORTH_CLI_RUN_PROGRAM_H

#include "cli/program.h"

// Runs what the command line says. Prints errors to stderr, and returns the exit code.
int vw_program_run(const struct vw_program *program, int argc, char **argv);

#endif
