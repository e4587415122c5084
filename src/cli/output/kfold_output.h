// Results of trainings on folds, for people or as JSON.
#ifndef VIEWWORTH_CLI_OUTPUT_KFOLD_OUTPUT_H
#define VIEWWORTH_CLI_OUTPUT_KFOLD_OUTPUT_H

#include <stdbool.h>

#include "experiment/kfold.h"
#include "viewworth/status.h"

// Prints what `value --kfold` prints.
enum vw_status vw_kfold_print(const struct vw_kfold *kfold, bool json);

#endif
