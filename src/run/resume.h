// Continuing the run that a folder holds (decision 11 of src/README.md).
#ifndef VIEWWORTH_RUN_RESUME_H
#define VIEWWORTH_RUN_RESUME_H

#include "run/run_private.h"

// Opens run->ledger and loads the newest usable checkpoint into run->trainer, or sets run->complete when no step is
// left. VW_ERROR_USAGE, naming what differs, when the ledger is of another run or holds more steps than are asked for;
// VW_ERROR_MISMATCH when it was edited.
enum vw_status vw_run_resume(struct vw_run *run);

#endif
