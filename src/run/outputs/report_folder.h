// The report at the end of a command. See viewworth/report.h.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H

#include "run/outputs/checksums.h"
#include "viewworth/report.h"
#include "viewworth/status.h"

// Writes OUT/report.html from the files of OUT, which the caller has locked, with the bytes that vw_report_write()
// would write later. Notes it in `made`, and fails when a file that it shows is not the one that is noted there.
// `*path` is owned by the caller.
enum vw_status vw_report_folder_make(const char *out, const struct vw_report_params *params, struct vw_checksums *made,
                                     char **path);
// Writes the same for a folder without a list. A failure is a warning. Returns the path; NULL when there is none.
char *vw_report_folder_finish(const char *out, const struct vw_report_params *params);

#endif
