// Points that a photo should show, and how many it shows. Internal to src/check.
#ifndef VIEWWORTH_CHECK_EXPECTED_H
#define VIEWWORTH_CHECK_EXPECTED_H

#include "check/patch.h"
#include "check/photos.h"

enum {
    VW_EXPECTED_CELLS = 16, // along a side; points are spread over them
    VW_EXPECTED_OF_CELL = 2,
    VW_EXPECTED_MOST = VW_EXPECTED_CELLS * VW_EXPECTED_CELLS * VW_EXPECTED_OF_CELL,
    VW_EXPECTED_FEW = 12 // fewer tell nothing of a photo
};

struct vw_expected_point {
    uint32_t point, references[2]; // two photos that show it alike, scene indices
    double at_px[2], depth;        // where the pose sees it, in small pixels
    double reference_px[2][2];     // where they see it, in their small pixels
    double magnification[2];       // its scale beside that of each, per small pixel
    struct vw_patch patch;         // the mean of how they show it, as the pose sees it
    bool known;                    // the photo has pixels there that are not masked
    bool shown, in_place;          // near there; and to less than IN_PLACE_PX
    bool between; // the photo was taken between two of those: hardly anything of the scene hides it there
};

// Owned by the caller, made once for many photos.
struct vw_expected {
    struct vw_expected_point list[VW_EXPECTED_MOST];
    uint32_t count;
    uint32_t *states; // owned; scratch, by point: what is known of it while they are listed
};

enum vw_status vw_expected_create(const struct vw_check_photos *photos, struct vw_expected **expected);
void vw_expected_destroy(struct vw_expected **expected); // accepts NULL

// Lists what a photo should show that has the pose, camera and neighbours of `photo`; `without`: a scene index that
// does not say so, even where it is a neighbour.
void vw_expected_list(const struct vw_check_photos *photos, const struct vw_check_photo *photo, uint32_t without,
                      struct vw_expected *expected);
// Marks the points that the pixels show, near their place and in place; returns the share of the latter, NaN for a few
// points.
double vw_expected_mark(const struct vw_plane *plane, struct vw_expected *expected);
// Returns the share of the photo in the largest region that shows none of the points it should, though others are shown
// elsewhere; NaN for a few points.
double vw_expected_hidden(const struct vw_check_photos *photos, const struct vw_check_photo *photo,
                          const struct vw_expected *expected);

#endif
