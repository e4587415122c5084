// Photos at a small size, their neighbours, and the points that they track. Internal to src/check.
#ifndef VIEWWORTH_CHECK_PHOTOS_H
#define VIEWWORTH_CHECK_PHOTOS_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/scene.h"
#include "viewworth/status.h"

enum {
    VW_CHECK_SIDE_PX = 256, // longer side of a small photo, at most; a strip of few pixels may be longer
    VW_CHECK_OTHERS = 8     // nearest photos of a photo
};

// Luminance, rows top to bottom; NaN where a photo is masked. Position (0.5, 0.5) is the middle of the first pixel.
struct vw_plane {
    float *values; // owned
    uint32_t width_px, height_px;
};

struct vw_check_photo {
    const struct vw_view *view; // NULL: excluded
    struct vw_plane small;
    double small_per_px;                           // small pixels per pixel
    uint32_t others[VW_CHECK_OTHERS], other_count; // scene indices, the nearest first
    const uint32_t *points;                        // that it tracks; lent by vw_check_photos.tracked
    uint32_t point_count;
};

struct vw_check_photos {
    const struct vw_scene *scene;
    struct vw_check_photo *list; // owned; by scene index
    uint32_t count;
    double (*points)[3]; // owned; world
    uint32_t point_count;
    uint32_t *tracked; // owned; points, photo by photo
};

// A point and the photos that show it, before vw_check_photos has them.
enum { VW_CHECK_TRACKS = 1 + VW_CHECK_OTHERS };
struct vw_made_point {
    double position_world[3];
    uint32_t views[VW_CHECK_TRACKS], view_count;
};

// Decodes and reduces the photos, and finds neighbours; points are not yet taken. Close it also after a failure.
enum vw_status vw_check_photos_open(const struct vw_scene *scene, struct vw_check_photos *photos);
void vw_check_photos_close(struct vw_check_photos *photos);
// Finds places that photos show alike: by a corner of one photo, whose depth others agree on (a plane sweep: Collins,
// "A space-sweep approach to true multi-image matching", CVPR 1996). `*made` is owned by the caller.
enum vw_status vw_check_make_points(const struct vw_check_photos *photos, struct vw_made_point **made, uint32_t *count);
// Takes the scene's points, and these in addition; once.
enum vw_status vw_check_take_points(struct vw_check_photos *photos, const struct vw_made_point *made, uint32_t count);

// Computes where a photo sees a place, in small pixels, and its depth along the axis; false: it faces away, or
// farther off the axis than numbers go.
bool vw_check_project(const struct vw_check_photo *photo, const double place_world[3], double at_px[2], double *depth);
// Computes the place at a depth of a position in the small photo; false where the lens has no inverse.
bool vw_check_unproject(const struct vw_check_photo *photo, const double at_px[2], double depth, double place_world[3]);
// Returns the focal length in small pixels.
double vw_check_focal_px(const struct vw_check_photo *photo);

#endif
