// Output of the command `worth`.
#ifndef VIEWWORTH_CLI_OUTPUT_WORTH_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_WORTH_OUTPUT_H

#include <stdbool.h>

#include "experiment/worth.h"

enum vw_status vw_worth_print(const struct vw_worth_run *result, double until_accuracy, bool json);

#endif
