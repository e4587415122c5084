// Copies of photos as a dishonest provider makes them, and which of them are found.
#ifndef VIEWWORTH_LAB_COPIED_PHOTOS_H
#define VIEWWORTH_LAB_COPIED_PHOTOS_H

#include "viewworth/scene.h"

// A way to copy a photo; fields left 0 change nothing.
struct vw_copying {
    const char *name;
    double crop, border;  // parts of the sides that are cut off, or added in black: half at each end
    bool corner;          // the crop is right and below alone
    uint32_t shift_px;    // distance to the left; the last column is repeated
    double gain, gamma;   // factor and exponent of the values as stored
    bool mirrored;        // left and right are exchanged
    bool halved;          // width and height are
    double masked, clear; // parts of the width, from the left, that a mask hides or that are transparent
    const char *jpeg;     // quality of the file, "jpeg:30"
    double turned_deg;    // turn about the up axis, of the pose that the copy claims
};

extern const struct vw_copying vw_copyings[];
extern const uint32_t vw_copying_count;

// Makes a copy with 8-bit pixels. It has the names of the original, which it borrows; pixels and mask are the caller's
// (vw_copied_photo_clear).
enum vw_status vw_copy_photo(const struct vw_view *original, const struct vw_copying *copying, struct vw_view *copy);
void vw_copied_photo_clear(struct vw_view *copy);

struct vw_copies_found {
    uint32_t photos, copies, found; // photos of the scene; their copies; those in one group with their originals
    uint32_t pairs, wrong;          // pairs of the scene's photos; those in one group
    double seconds;                 // time that the search took
};

// Copies up to 24 photos that are not excluded, and searches among all. `copying` NULL: copies none.
enum vw_status vw_find_copies(const struct vw_scene *scene, const struct vw_copying *copying,
                              struct vw_copies_found *found);

#endif
