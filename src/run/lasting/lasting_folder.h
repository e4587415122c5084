// Lasting credit of a run that a folder contains.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_FOLDER_H
#define VIEWWORTH_RUN_LASTING_LASTING_FOLDER_H

#include "viewworth/run.h"

// Computes lasting credit for the run in params->out and writes its tables and report again; does nothing when the
// folder has the result already. The run's ledger tells scene and config; of the params, device (NULL: the run's),
// lasting, report, progress and context count. VW_ERROR_USAGE for a run that no backward pass can follow: imported,
// without validation, not finished, with halves.
enum vw_status vw_lasting_of_folder(const struct vw_run_params *params);

#endif
