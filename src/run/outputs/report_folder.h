// The report at the end of a command. See viewworth/report.h.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_FOLDER_H

#include <jansson.h>

#include "report/documents.h"
#include "viewworth/report.h"
#include "viewworth/status.h"

// Writes report.html of a run that has ended into the folder that is its label and that the caller has locked, with the
// bytes that vw_report_write() would write later. `documents` are the tables that the command has made.
// `*path` is owned by the caller.
enum vw_status vw_report_of_run(struct vw_results *results, struct vw_report_documents *documents,
                                const struct vw_report_params *params, char **path);
// Writes the same of a folder without a list, which the caller has locked; `content` is that of the document `file`,
// which the command has just made and of which it takes the reference (report/documents.h); NULL: it made none. A
// failure is a warning. Returns the path; NULL when there is none.
char *vw_report_folder_finish(const char *out, const struct vw_report_params *params, const char *file,
                              json_t *content);

#endif
