// The evidence of effects: one number per effect and scene, which decide.c compares with a threshold. It is
// deterministic and uses the photos of the splits train and val only, so that test photos decide nothing (except that
// the lenses of test photos count as well). NaN: the scene cannot tell.
#ifndef VIEWWORTH_DETECT_EVIDENCE_H
#define VIEWWORTH_DETECT_EVIDENCE_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// What the pilot run found (pilot_run.h); NaN without one.
struct pilot_findings {
    double gain_spread; // as evidence_appearance, of photos compared with renders
    double empty_share; // of the box's cells, by density
};

struct survey {
    const struct vw_scene *scene;
    bool masks; // masked pixels are left out, as in a training with the effect `masks`
    struct pilot_findings pilot;
};

// The only failure of these functions is VW_ERROR_MEMORY.

// The largest shift of a photo's corner by its lens, in pixels, over all photos. No photo resolves a hundredth of a
// pixel.
enum vw_status evidence_distortion(const struct survey *survey, double *evidence);

// The share of photos that have transparent pixels.
enum vw_status evidence_background(const struct survey *survey, double *evidence);

// The share of photos that have a mask file. Any share calls for the effect.
enum vw_status evidence_masks(const struct survey *survey, double *evidence);

// The range of depths that a photo sees: the ratio of the 95th to the 5th percentile of the depths of its SfM points,
// median over photos. Samples spaced evenly between near and far resolve far content by that factor better than near
// content.
enum vw_status evidence_unbounded(const struct survey *survey, double *evidence);

// Open sky. A photo has 8 x 8 cells. A cell is open if it is smooth and not black, and no SfM point of the whole cloud
// lies in it or in a cell above it. Evidence is the share of open cells among those whose rays rise above the middle of
// their photo, less the share among the other cells, which are followed down instead of up: a turntable in front of a
// backdrop is as empty below as above. Rays that meet nothing render black anyway. "Above" is by the mean of the
// cameras' up axes. Depths of points cannot replace this test, since they do not know rays without points (two
// in-the-wild scenes have smaller depth ratios than a room).
enum vw_status evidence_sky(const struct survey *survey, double *evidence);

// The robust spread of exposure over photos. For each SfM point and channel, the log of its colour in a photo minus the
// median of that in the other photos that see it; the median over a photo's points is the photo's log gain. Evidence is
// 1.4826 times the median absolute deviation of log gains over photos and channels. Fewer than half of the photos
// cannot move it far by being corrupted. The pilot run replaces it if there are too few points.
enum vw_status evidence_appearance(const struct survey *survey, double *evidence);

// The spread of colours that a gain and a bias per photo and channel do not explain. They are fitted (least absolute
// deviations) from the points' medians in other photos to their colours in the photo; a photo's spread is 1.4826 times
// the median of |residual| / fitted colour. Evidence is the median over photos and channels. Matching errors alone give
// 0.058 in a real room (fox); photos in the wild give 0.093 and more.
enum vw_status evidence_appearance_code(const struct survey *survey, double *evidence);

// The share of the box that the pilot run found empty.
enum vw_status evidence_occupancy(const struct survey *survey, double *evidence);

// ---- For the files of the evidence ----------------------------------------------------------------------------------

// Whether a photo counts: it is of train or val.
bool survey_uses_view(const struct survey *survey, uint32_t view);
// Whether a pixel would be trained or validated on.
bool survey_keeps(const struct survey *survey, uint32_t view, uint32_t x_px, uint32_t y_px);
// The same for the pixel where a photo sees a point; false beyond the photo's border.
bool survey_keeps_track(const struct survey *survey, const struct vw_track *track);

// Beyond these a channel says little of the exposure.
#define EVIDENCE_DARK 0.06
#define EVIDENCE_SATURATED 0.94

#endif
