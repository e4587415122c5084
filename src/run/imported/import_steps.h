// Makes a run in OUT of the step log of another trainer, and scores it.
#ifndef VIEWWORTH_RUN_IMPORTED_IMPORT_STEPS_H
#define VIEWWORTH_RUN_IMPORTED_IMPORT_STEPS_H

#include <stdint.h>

#include "value/series.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/types.h"

struct vw_import_params {
    const char *log;                // the CSV file
    const char *out;                // must not contain a run yet
    const struct vw_config *config; // burn_in_epochs and beta1 are read
};

struct vw_import_result {
    char *ledger_path, *scores_path; // owned
    char run_id[VW_HASH_HEX_BYTES], log_sha256[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    uint32_t photos, epochs, score_count;
    uint64_t validated_every; // as of struct vw_step_log
    struct vw_step_statistics statistics;
};

// Checks the whole log first, then writes OUT/ledger.db and OUT/scores.csv. Warns of steps without values of their
// own and of missing scores. VW_ERROR_INPUT names the line of the log; VW_ERROR_USAGE when OUT contains a run.
// `*result` is untouched on failure; free it by vw_import_result_free().
enum vw_status vw_import_make(const struct vw_import_params *params, struct vw_import_result *result);
void vw_import_result_free(struct vw_import_result *result);

#endif
