// Checks of what several commands are asked for.
#ifndef VIEWWORTH_RUN_CHECKS_H
#define VIEWWORTH_RUN_CHECKS_H

#include <stdint.h>

#include "viewworth/status.h"

// VW_ERROR_USAGE where burn-in leaves no epoch to score.
enum vw_status vw_check_scored_epochs(uint32_t epochs, uint32_t burn_in_epochs);
// VW_ERROR_USAGE where the `count` seeds from `first` on pass the largest.
enum vw_status vw_check_seeds(uint64_t first, uint64_t count);

#endif
