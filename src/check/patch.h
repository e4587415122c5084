// Patches of small photos, and their normalised correlation. Internal to src/check.
#ifndef VIEWWORTH_CHECK_PATCH_H
#define VIEWWORTH_CHECK_PATCH_H

#include <stdbool.h>

#include "check/photos.h"

enum {
    VW_PATCH_REACH_PX = 5,
    VW_PATCH_SIDE = 2 * VW_PATCH_REACH_PX + 1,
    VW_PATCH_PIXELS = VW_PATCH_SIDE * VW_PATCH_SIDE
};

// Luminance less its mean, divided by its length.
struct vw_patch {
    float values[VW_PATCH_PIXELS];
};

// Reads a patch around a position, whose next column and row are so many pixels away, bilinearly. False: part of it is
// outside or masked, or it is flat.
bool vw_patch_read(const struct vw_plane *plane, const double at_px[2], const double steps_px[2][2],
                   struct vw_patch *patch);
// Returns whether the patch at the pixel of a position is in the plane, and no pixel of it is masked.
bool vw_patch_is_known(const struct vw_plane *plane, const double at_px[2]);
// Returns the correlation of two patches, -1 to 1.
float vw_patch_correlate(const struct vw_patch *a, const struct vw_patch *b);
// The rays of a position in a photo, and of those right of and below it: places along them, world units per depth.
struct vw_patch_rays {
    double origin_world[3], directions_world[3][3];
};
// Computes them; false where the lens has no inverse.
bool vw_patch_rays_of(const struct vw_check_photo *photo, const double at_px[2], struct vw_patch_rays *rays);
// Reads how `from` shows the patch around these rays at a depth; also where that is, in small pixels of `from`, and its
// depth there. False: `from` does not show it.
bool vw_patch_warp(const struct vw_patch_rays *rays, double depth, const struct vw_check_photo *from,
                   double there_px[2], double *there_depth, struct vw_patch *patch);
// Returns the greatest correlation with the patch at whole pixels that are at most so far away along either axis, and
// how far away the peak is, between pixels; -1 if nothing can be read there.
float vw_patch_find(const struct vw_plane *plane, const double at_px[2], const struct vw_patch *patch, int reach_px,
                    double away_px[2]);

#endif
