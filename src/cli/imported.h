// Runs whose steps another trainer took: how their ledgers say so.
#ifndef VIEWWORTH_CLI_IMPORTED_H
#define VIEWWORTH_CLI_IMPORTED_H

#include <stdbool.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

extern const char vw_imported_device[]; // run.device of such a run

bool vw_is_imported(const struct vw_ledger_run *run);
// run.config_json: what of a configuration bears on the scores, and nothing that only the other trainer knows. Owned by the caller.
char *vw_imported_config_to_json(const struct vw_config *config);
// The same back, over the defaults.
enum vw_status vw_imported_config_from_json(const char *json, struct vw_config *config);

#endif
