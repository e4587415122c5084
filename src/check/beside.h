// Brightness, sharpness and noise of a photo beside others that show the same points. Internal to src/check.
#ifndef VIEWWORTH_CHECK_BESIDE_H
#define VIEWWORTH_CHECK_BESIDE_H

#include <stdbool.h>

#include "check/expected.h"

enum { VW_SHARPNESS_DIRECTIONS = 8, VW_SHARPNESS_LEVELS = 3 };

// The measures in a window around a point. Logarithms; all but the first without regard to contrast.
enum { VW_BESIDE_STOPS, VW_BESIDE_NOISE, VW_BESIDE_SHARPNESS };
enum { VW_BESIDE_COUNT = VW_BESIDE_SHARPNESS + VW_SHARPNESS_LEVELS * VW_SHARPNESS_DIRECTIONS };

// A photo's measure at a point, less that of another photo.
struct vw_beside {
    uint32_t other; // scene index
    bool shown;     // the photo shows the point
    float differences[VW_BESIDE_COUNT];
};

// Measures a photo at the points that it should show; room for 2 VW_EXPECTED_MOST. Returns the number made.
uint32_t vw_beside_measure(const struct vw_check_photos *photos, uint32_t view, const struct vw_expected *expected,
                           struct vw_beside *made);
// The level of a photo beside others, by its comparisons and theirs with it: their median and quarters. Where there are
// few the quarters are NaN, and the median is 0, so that it changes nobody else's.
struct vw_beside_level {
    double median, low, high;
};
// Solves for the levels of all photos, zeroed before: medians of the differences from others, given their medians (as
// in a median polish: Tukey, "Exploratory data analysis", 1977). A difference counts for both photos if both show
// the point, so that levels of photos that are compared only with each other do not run away together. VW_ERROR_MEMORY.
enum vw_status vw_beside_solve(struct vw_beside *const *made, const uint32_t *counts, uint32_t view_count,
                               struct vw_beside_level (*levels)[VW_BESIDE_COUNT]);

#endif
