// The sweep of a run that a folder holds.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_FOLDER_H
#define VIEWWORTH_RUN_LASTING_LASTING_FOLDER_H

#include "run/lasting/lasting_summary.h"
#include "viewworth/run.h"

struct vw_lasting_folder_params {
    const char *out;    // holds a finished run of value
    const char *device; // index or part of the name; NULL: the run's
    struct vw_lasting_wanted wanted;
    bool no_thumbnails;
    vw_run_progress *progress;
    void *context; // of progress
};
// Sweeps the run that a folder holds, and writes its tables and report again; does nothing when it has such a sweep.
// VW_ERROR_USAGE for a run that no sweep follows: imported, without validation, not finished, with halves.
enum vw_status vw_lasting_of_folder(const struct vw_lasting_folder_params *params);

#endif
