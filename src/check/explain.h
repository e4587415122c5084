// Why a photo does not show what its pose sees: another pose, focal length or photo, or turned pixels. Internal to
// src/check.
#ifndef VIEWWORTH_CHECK_EXPLAIN_H
#define VIEWWORTH_CHECK_EXPLAIN_H

#include "check/evidence.h"
#include "check/expected.h"

// Fills turned_over*, found_in_place, turned_deg, moved_px, pose_found, zoom* and shows* of the evidence. `expected`
// has the points by the photo's pose and, afterwards, those by the best explanation, or the pose's own if there is
// none, with their marks. VW_ERROR_MEMORY.
enum vw_status vw_check_explain(const struct vw_check_photos *photos, uint32_t view, struct vw_expected *expected,
                                struct vw_photo_evidence *evidence);

#endif
