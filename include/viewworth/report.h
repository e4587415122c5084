// The report: one HTML page of folders of results.
#ifndef VIEWWORTH_REPORT_H
#define VIEWWORTH_REPORT_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

struct vw_report_extra;

struct vw_report_options {
    bool no_thumbnails;  // leave the photos out
    uint32_t ply_degree; // least degree of the harmonics in field.ply, padded by zeros
};

struct vw_report_params {
    const struct vw_scene *scene; // an open scene, for thumbnails of the runs that used it; NULL: none
    const char *device;           // renders recipes that are not open; NULL: the preferred device
    struct vw_report_options options;
    const struct vw_report_extra *extra; // a further table (src/report/page.h of the source tree); NULL: none
};

// Writes one self-contained HTML page of all folders to the file `to`, whole or not at all. Shows of each folder its
// run (ledger.db), the runs of its seeds (seed_<N>/ledger.db), providers.csv, payout.csv,
// duplicates.csv, tradeoff.csv, summary.csv, and compare.json with its renders. A run that several
// folders hold is shown once. Photos that cannot be read are left out with a warning. VW_ERROR_INPUT when a folder
// has none of these, something broken, or a link that leads out of it. `params` may be NULL.
enum vw_status vw_report_write(const char *const *folders, uint32_t folder_count, const char *to,
                               const struct vw_report_params *params);

VW_PUBLIC_END

#endif
