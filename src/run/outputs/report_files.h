// The files beside a folder's ledgers that its report shows.
#ifndef VIEWWORTH_REPORT_FILES_H
#define VIEWWORTH_REPORT_FILES_H

#include <stddef.h>

#include "report/page.h"
#include "viewworth/status.h"

// All zero before the first is added.
struct vw_report_files {
    struct vw_report_document *documents; // owned, and what they point to; names and bytes of thumbnails are borrowed
    size_t count, capacity;
};

// Adds providers.csv, payout.csv, duplicates.csv, benchmark.csv and compare.json of a folder, those that are there.
// VW_ERROR_INPUT when one is not what it should be. Free it also after a failure.
enum vw_status vw_report_files_add(struct vw_report_files *files, const char *out);
// A received folder may hold links: VW_ERROR_INPUT for a file that does not lie in the folder, since the
// report would contain that file, and be passed on with it.
enum vw_status vw_report_files_check(const char *out, const char *path);
void vw_report_files_free(struct vw_report_files *files);

#endif
