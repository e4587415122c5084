// Photos of a run that are known when places for the next ones are looked for.
#ifndef VIEWWORTH_RUN_NEXT_KNOWN_PHOTOS_H
#define VIEWWORTH_RUN_NEXT_KNOWN_PHOTOS_H

#include "run/next/depth_maps.h"
#include "scene/view_distance.h"

struct vw_trainer;

struct vw_known_photos {
    const struct vw_scene *scene;  // borrowed
    struct vw_depth_source depths; // renders any pose; its context is borrowed
    uint64_t seed;                 // the run's
    struct vw_view_scales scales;  // units of distances between poses
    uint32_t *views;               // owned, as all below; scene indices of photos trained on
    uint32_t count;
    struct vw_depth_map *maps; // one per photo, as the points
    struct vw_seen_points *points;
    double usual_seen_by; // other known photos that see a point of one: the median photo's median
    uint32_t *val_views;  // scene indices of validation photos, those of known errors alone
    double *val_mse;      // the field's squared error at each of them; 0 until it is measured
    uint32_t val_count;
    double usual_mse; // the median of these errors
};

// Looks at the photos of a scene. Destroy it also after a failure.
enum vw_status vw_known_photos_create(const struct vw_scene *scene, const struct vw_depth_source *depths, uint64_t seed,
                                      struct vw_known_photos *known);
// Measures the field's errors. Photos whose error is not finite are no longer in val_views.
enum vw_status vw_known_photos_measure(struct vw_known_photos *known, struct vw_trainer *trainer);
void vw_known_photos_destroy(struct vw_known_photos *known);

// Returns the photo at a place of `views`.
const struct vw_view *vw_known_photo(const struct vw_known_photos *known, uint32_t photo);
// Returns the place of the one whose focal length, as a share of its longer side, is in the middle.
uint32_t vw_known_photos_usual(const struct vw_known_photos *known);
// Returns the place of the one of the nearest position, of equal ones the first.
uint32_t vw_known_photos_nearest(const struct vw_known_photos *known, const struct vw_view *pose);

#endif
