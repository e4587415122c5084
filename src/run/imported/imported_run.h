// Imported runs, whose steps another trainer took: how their ledgers record that.
#ifndef VIEWWORTH_RUN_IMPORTED_IMPORTED_RUN_H
#define VIEWWORTH_RUN_IMPORTED_IMPORTED_RUN_H

#include <stdbool.h>

#include "base/hash.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

extern const char vw_imported_device[]; // run.device of such a run

// Computes the run_id of an imported run: a hash of the log's hash and of the config fields that affect the scores.
void vw_imported_run_id(const char *log_sha256, const struct vw_config *config, char run_id[VW_HASH_HEX_BYTES]);

bool vw_is_imported(const struct vw_ledger_run *run);
// Returns run.config_json: only the config fields that affect the scores. Owned by the caller.
char *vw_imported_config_to_json(const struct vw_config *config);
// Reads them back, over the defaults.
enum vw_status vw_imported_config_from_json(const char *json, struct vw_config *config);
// Returns run.scene_options_json: the SHA-256 of the log, in hex, and validated_every of struct vw_step_log unless it
// is 0. Owned by the caller.
char *vw_imported_options_to_json(const char *log_sha256, uint64_t validated_every);
// Reads the hash back. VW_ERROR_INPUT.
enum vw_status vw_imported_log_sha256(const struct vw_ledger_run *run, char log_sha256[VW_HASH_HEX_BYTES]);

#endif
