// PruNeRF-like scores (Jung et al., "PruNeRF: segment-centric dataset pruning via 3D spatial consistency", ICML 2024):
// how much of a photo the trained field misses where it shows the same places well in other photos. Such pixels are of
// passers-by, of a wrong pose or exposure: of what the photo alone claims.
//
// Simplified: residuals of the trained field stand for PruNeRF's influence functions; SfM points stand for its depths,
// and pixels for its segments. A photo sees a point that its tracks list, or that its camera projects into it with no
// much nearer point beside. Its score is minus the share of these points where its own residual is an outlier, and the
// median residual of the point in the other photos that list it (at least two) is not. An outlier is more than
// median + 3 robust spreads of all listed residuals. Without such points, the score is minus the share of all its
// pixels whose residual is an outlier, and no other photo has a say.
#ifndef VIEWWORTH_LAB_METHODS_CONSISTENT_RESIDUAL_H
#define VIEWWORTH_LAB_METHODS_CONSISTENT_RESIDUAL_H

#include <stdbool.h>
#include <stdint.h>

#include "run/session.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

extern const char vw_consistent_residual_name[]; // "consistent_residual"

// The residuals of a photo on a grid of pixels that covers it evenly.
struct vw_residuals {
    uint32_t columns, rows;
    double *values; // owned; mean absolute error over the channels, rows top to bottom; NaN: a pixel that is not used
};

// Scores each photo by its residuals (`photos`: scene indices, ascending). NaN for a photo without a usable pixel.
// VW_ERROR_MEMORY.
enum vw_status vw_consistent_residual_score(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                            const struct vw_residuals *residuals, double *scores);

// The same from a finished field, which renders every photo on at most 64 x 64 pixels. Where validation fits a gain and
// a bias to each view, which a render does not have, the scores are NaN.
struct vw_finished_field {
    const struct vw_session *session; // open, its effects decided
    const struct vw_config *config;   // config of its run
    const char *path;                 // field.vwf of the run; NULL: the run's training is repeated
};
enum vw_status vw_consistent_residual_find(const struct vw_finished_field *finished, const uint32_t *photos,
                                           uint32_t photo_count, double *scores);

#endif
