// Colours of the points of structure from motion, as the train photos show them.
#ifndef VIEWWORTH_SCENE_EXPOSURES_OBSERVATIONS_H
#define VIEWWORTH_SCENE_EXPOSURES_OBSERVATIONS_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

enum { EXPOSURE_CHANNELS = 3 };

// The colour that a train photo shows of a point.
struct observation {
    uint32_t view;
    double value[EXPOSURE_CHANNELS]; // in [0,1], as stored; NaN: unusable
};

// Observations of points by train photos, point by point; at most one of a point by a photo.
struct observations {
    struct observation *list; // owned
    uint32_t *ends;           // owned; by point: the first observation of the next
    uint32_t point_count, count, view_count;
};

// Reads the colours of all points in all train photos, which must have been decoded. A channel is unusable where a
// photo is masked or transparent, where it may be clipped, and of a point that no other photo shows in it. The caller
// releases them, also after a failure.
enum vw_status vw_observations_list(const struct vw_scene *scene, struct observations *observations);
void vw_observations_release(const struct observations *observations);

static inline uint32_t vw_observations_begin(const struct observations *observations, uint32_t point) {
    return point ? observations->ends[point - 1] : 0;
}

#endif
