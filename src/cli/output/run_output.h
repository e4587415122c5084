// Description and results of a run, as text and JSON on stdout.
#ifndef VIEWWORTH_CLI_OUTPUT_RUN_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_RUN_OUTPUT_H

#include <stdbool.h>

#include "run/run.h"

// Prints a finished run, with its scores unless it trained only.
enum vw_status vw_run_print(const struct vw_run *run, bool trained_only, bool json);

#endif
