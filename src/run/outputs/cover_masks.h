// Masks of what covers photos, by the trained field (cover_regions.h): files, and findings for advice.
#ifndef VIEWWORTH_RUN_OUTPUTS_COVER_MASKS_H
#define VIEWWORTH_RUN_OUTPUTS_COVER_MASKS_H

#include "base/defect.h"
#include "run/outputs/residuals.h"

// Photos are compared at no more than this height; below the other one they show too little.
enum { VW_COVER_HEIGHT_PX = 160, VW_COVER_HEIGHT_LEAST_PX = 48 };
// The rays that renders may take however short a run is: about a second on two cores.
#define VW_COVER_RAYS_LEAST (1 << 18)
// The share of a photo below which what covers it is not told.
#define VW_COVER_SHARE_LEAST 0.05

// All borrowed for the call.
struct vw_cover_params {
    struct vw_panes_params panes;
    double rays_most; // renders of all photos take no more, or VW_COVER_RAYS_LEAST; fewer pixels where they would
    const char *out;
};

// Writes OUT/masks/NAME.png (vw_mask_name()) for each photo of files that was trained on and of which a share of at
// least VW_COVER_SHARE_LEAST is covered, at the size of its file: black hides, white keeps, as in COLMAP and
// nerfstudio. What the mask hides that it was trained with is black, too; photos whose masks were given by --masks keep
// them. A mask that would keep less than a quarter is not written. Sets vw_photo_finding.covered, and the defect where
// none was found; counts masks of covered photos. Leaves out photos that show something else. VW_ERROR_MEMORY,
// VW_ERROR_IO.
enum vw_status vw_cover_masks_make(const struct vw_cover_params *params, struct vw_photo_finding *findings,
                                   uint32_t *mask_count);

#endif
