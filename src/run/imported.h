// Runs whose steps another trainer took: how their ledgers say so.
#ifndef VIEWWORTH_IMPORTED_H
#define VIEWWORTH_IMPORTED_H

#include <stdbool.h>

#include "base/hash.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

extern const char vw_imported_device[]; // run.device of such a run

// The run_id of such a run: a hash over the log's own and what of a configuration bears on the scores.
void vw_imported_run_id(const char *log_sha256, const struct vw_config *config, char run_id[VW_HASH_HEX_BYTES]);

bool vw_is_imported(const struct vw_ledger_run *run);
// run.config_json: what of a configuration bears on the scores, and nothing that only the other trainer knows. Owned by
// the caller.
char *vw_imported_config_to_json(const struct vw_config *config);
// The same back, over the defaults.
enum vw_status vw_imported_config_from_json(const char *json, struct vw_config *config);
// run.scene_options_json: what sha256sum says of the log, in hex. Owned by the caller.
char *vw_imported_options_to_json(const char *log_sha256);
// Reads it back, and sees that it and `config`, which is the run's, are those that its run_id was made of.
// VW_ERROR_INPUT, VW_ERROR_MISMATCH.
enum vw_status vw_imported_check(const struct vw_ledger_run *run, const struct vw_config *config,
                                 char log_sha256[VW_HASH_HEX_BYTES]);

#endif
