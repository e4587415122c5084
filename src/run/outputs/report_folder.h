// The report of what folders hold, whichever command filled them.
#ifndef VIEWWORTH_REPORT_FOLDER_H
#define VIEWWORTH_REPORT_FOLDER_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

struct vw_report_options {
    const struct vw_scene *scene; // that is open already, for the thumbnails of what was made of it; NULL: none
    const char *device;           // on which recipes that are not open are drawn again
    bool no_thumbnails;
};

// Of each folder: its run (ledger.db), those of its seeds (seed_<N>/ledger.db), providers.csv, payout.csv,
// duplicates.csv, benchmark.csv, and compare.json with its renders. One page of all is written to `to`, whole or not at
// all. Where the photos of a run cannot be read it warns in a line and leaves them out. A run that several folders hold
// is shown once. VW_ERROR_INPUT when a folder holds none of it, something broken, or a link that leads out of it.
enum vw_status vw_report_folders_write(const char *const *outs, uint32_t count, const char *to,
                                       const struct vw_report_options *options);
// The same of one folder, to OUT/report.html.
enum vw_status vw_report_folder_write(const char *out, const struct vw_report_options *options);
// The same at the end of a command that has done its work: a failure is a warning. The report's path, owned by the
// caller; NULL when there is none.
char *vw_report_folder_finish(const char *out, const struct vw_report_options *options);

#endif
