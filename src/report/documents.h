// The files beside a folder's ledgers that its page shows: tables and comparisons.
#ifndef VIEWWORTH_REPORT_DOCUMENTS_H
#define VIEWWORTH_REPORT_DOCUMENTS_H

#include <stddef.h>

#include "report/page.h"
#include "viewworth/status.h"

// All zero before the first is added.
struct vw_report_documents {
    struct vw_report_document *list; // owned, and what they point to; names and bytes of thumbnails are borrowed
    size_t count, capacity;
};

// Adds providers.csv, payout.csv, duplicates.csv, tradeoff.csv, summary.csv, compare.json and the extra table (NULL:
// none) of a folder, those that are there and were not added yet. VW_ERROR_INPUT when one is not what it should be, or
// is a link: the page would contain a file from elsewhere, and be passed on with it. Free them also after a failure.
enum vw_status vw_report_documents_read(struct vw_report_documents *documents, const char *out,
                                        const struct vw_report_extra *extra);
// Adds a file that the command has just written, by its content (vw_rows_to_texts(), or a comparison), of which it
// takes the reference; NULL: memory was short. `file` is static.
enum vw_status vw_report_documents_take(struct vw_report_documents *documents, const char *out, const char *file,
                                        json_t *content);
// Returns NULL where the folder has no such document.
const struct vw_report_document *vw_report_documents_find(const struct vw_report_documents *documents, const char *out,
                                                          const char *file);
void vw_report_documents_free(struct vw_report_documents *documents);

#endif
