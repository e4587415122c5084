// The files beside a folder's ledgers that its report shows.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_FILES_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_FILES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "report/page.h"
#include "run/outputs/checksums.h"
#include "viewworth/status.h"

// All zero before the first is added.
struct vw_report_files {
    struct vw_report_document *documents; // owned, and what they point to; names and bytes of thumbnails are borrowed
    size_t count, capacity;
};

// Adds providers.csv, payout.csv, duplicates.csv, tradeoff.csv, summary.csv, compare.json and the extra table (NULL:
// none) of a folder, those that are there.
// VW_ERROR_INPUT when one is not what it should be, or is a link: the report would contain a file from elsewhere, and
// be passed on with it. Notes what it reads in `read`; NULL: nowhere. Free it also after a failure.
enum vw_status vw_report_files_add(struct vw_report_files *files, const char *out, const struct vw_report_extra *extra,
                                   struct vw_checksums *read);
void vw_report_files_free(struct vw_report_files *files);

// The JSON texts of a run's folder, owned; NULL where a file is missing.
struct vw_run_texts {
    char *map, *residuals, *reconstruction, *next;
};
// Reads map.json, reconstruction.json, next.json and residuals.json; with `no_photos` neither the last nor the pictures
// of next.json. VW_ERROR_INPUT as above, and when they are not of this scene and these images. Free the texts also
// after a failure.
enum vw_status vw_report_files_of_run(const char *out, const char *scene_hash, uint32_t image_count, bool no_photos,
                                      struct vw_checksums *read, struct vw_run_texts *texts);
void vw_run_texts_free(struct vw_run_texts *texts);

#endif
