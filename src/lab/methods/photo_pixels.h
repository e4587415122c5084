// Measures of the pixels of one photo alone. Methods without training need them; all are measured here at once, so that
// the photo is decoded once.
#ifndef VIEWWORTH_LAB_METHODS_PHOTO_PIXELS_H
#define VIEWWORTH_LAB_METHODS_PHOTO_PIXELS_H

#include "image/image.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { VW_THUMBNAIL_COLUMNS = 8, VW_THUMBNAIL_ROWS = 6, VW_THUMBNAIL_VALUES = 3 * 8 * 6 };

// Transparent pixels are over the scene's background; masks are not obeyed.
struct vw_photo_pixels {
    struct vw_luminance luminance;
    float thumbnail[VW_THUMBNAIL_VALUES]; // RGB in [0,1], rows top to bottom: means of some pixels of every cell
};

enum vw_status vw_photo_pixels_measure(const struct vw_scene *scene, uint32_t view, struct vw_photo_pixels *pixels);

#endif
