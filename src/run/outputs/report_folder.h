// The report at the end of a command. See viewworth/report.h.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H

#include "report/page.h"
#include "viewworth/report.h"
#include "viewworth/status.h"

// Writes OUT/report.html. `run` is the run of OUT as the caller has it already, without thumbnails; NULL: its ledger is
// read, if there is one. A failure is a warning. Returns the report's path, owned by the caller; NULL when there is
// none.
char *vw_report_folder_finish(const char *out, const struct vw_report_params *params, const struct vw_report_run *run);

#endif
