// What a run was and gave, as text and JSON on stdout.
#ifndef VIEWWORTH_CLI_OUTPUT_RUN_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_RUN_OUTPUT_H

#include <stdbool.h>

#include "run/run.h"

// Of a run that was finished: with its scores unless it trained only.
enum vw_status vw_run_print(const struct vw_run *run, bool trained_only, bool json);

#endif
