#include "run/checks.h"

#include <inttypes.h>

enum vw_status vw_check_scored_epochs(uint32_t epochs, uint32_t burn_in_epochs) {
    if (epochs > burn_in_epochs) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u to score; take more epochs", epochs,
                   burn_in_epochs);
}

enum vw_status vw_check_seeds(uint64_t first, uint64_t count) {
    if (!count || first <= (uint64_t)INT64_MAX - (count - 1)) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--seed %" PRIu64 ": the %" PRIu64 " seeds from it on pass %" PRId64
                   ", the largest; take a lower one",
                   first, count, INT64_MAX);
}
