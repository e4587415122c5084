// The report at the end of a command. See viewworth/report.h.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H

#include "viewworth/report.h"
#include "viewworth/status.h"

// Writes OUT/report.html from the files of OUT, which the caller has locked, with the bytes that vw_report_write()
// would write later. A failure is a warning. Returns the report's path, owned by the caller; NULL when there is none.
char *vw_report_folder_finish(const char *out, const struct vw_report_params *params);

#endif
