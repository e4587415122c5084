// The thumbnails of a report: those of each scene are made once, whoever shows them.
#ifndef VIEWWORTH_RUN_OUTPUTS_REPORT_THUMBNAILS_H
#define VIEWWORTH_RUN_OUTPUTS_REPORT_THUMBNAILS_H

#include <stddef.h>

#include "base/hash.h"
#include "report/page.h"
#include "run/outputs/thumbnails.h"
#include "viewworth/ledger.h"
#include "viewworth/report.h"

// The thumbnails of one scene; none when its photos cannot be read.
struct vw_report_set {
    char hash[VW_HASH_HEX_BYTES];
    struct vw_thumbnails thumbnails;
};

// All zero before the first is asked for.
struct vw_report_sets {
    struct vw_report_set *sets; // owned
    size_t count, capacity;
};

// Lends one thumbnail per image of a run until the sets are freed. Returns NULL, with a warning for the first run of a
// scene, when there are none or when they do not match the images.
const struct vw_report_picture *vw_report_sets_of_run(struct vw_report_sets *sets,
                                                      const struct vw_report_params *params,
                                                      const struct vw_recorded_scene *recorded,
                                                      const struct vw_ledger_image *images, uint32_t image_count);
// Lends a comparison (a document "compare" of the page) thumbnails of the photos on which its lists disagree, unless a
// run of the page shows that scene. Its arrays are owned by the caller. VW_ERROR_MEMORY; what else fails is a warning.
enum vw_status vw_report_sets_of_comparison(struct vw_report_sets *sets, const struct vw_report_params *params,
                                            const struct vw_report_run *runs, size_t run_count,
                                            struct vw_report_document *document);
void vw_report_sets_free(struct vw_report_sets *sets);

#endif
