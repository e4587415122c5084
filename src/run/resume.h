// Going on with a run that a folder holds (decision 11).
#ifndef VIEWWORTH_RESUME_H
#define VIEWWORTH_RESUME_H

#include "run/training_run.h"

// Opens run->ledger and puts run->trainer where the newest usable checkpoint is, or sets run->complete when nothing is
// left to do. VW_ERROR_USAGE, naming what differs, when the ledger is of another run or holds more than is asked for;
// VW_ERROR_MISMATCH when it was edited.
enum vw_status vw_training_resume(struct vw_training_run *run);

#endif
