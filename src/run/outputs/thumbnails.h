// Small pictures of photos for a report: those of each scene are made once, whoever shows them.
#ifndef VIEWWORTH_RUN_OUTPUTS_THUMBNAILS_H
#define VIEWWORTH_RUN_OUTPUTS_THUMBNAILS_H

#include <stddef.h>
#include <stdint.h>

#include "base/hash.h"
#include "report/page.h"
#include "viewworth/report.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// Estimates the seconds that the thumbnails of all photos take, by timing one.
double vw_thumbnails_estimate_s(const struct vw_scene *scene);

// One per view of a scene, in its order, without bytes for excluded ones. All zero: none, as its photos cannot be read.
struct vw_thumbnails {
    char **names;
    struct vw_report_picture *pictures;
    uint32_t count;
};

struct vw_report_set {
    char hash[VW_HASH_HEX_BYTES]; // the hash of the scene
    struct vw_thumbnails thumbnails;
};

// All zero before the first is asked for.
struct vw_report_sets {
    struct vw_report_set *sets; // owned
    size_t count, capacity;
};

// Lends one thumbnail per image to a run until the sets are freed; none, with a warning for the first run of a scene,
// when there are none or when they do not match the images.
void vw_report_sets_of_run(struct vw_report_sets *sets, const struct vw_report_params *params, struct vw_results *run);
// Lends a comparison (a document "compare" of the page) thumbnails of the photos on which its lists disagree, unless a
// run of the page shows that scene. Its arrays are owned by the caller. VW_ERROR_MEMORY; what else fails is a warning.
enum vw_status vw_report_sets_of_comparison(struct vw_report_sets *sets, const struct vw_report_params *params,
                                            const struct vw_results *const *runs, size_t run_count,
                                            struct vw_report_document *document);
void vw_report_sets_free(struct vw_report_sets *sets);

#endif
