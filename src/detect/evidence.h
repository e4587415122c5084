// What a scene shows of each effect: one number per effect, which decide.c compares with a threshold.
// Deterministic, from the photos of the splits train and val alone, so that what is tested on decides nothing (lenses
// apart: those of tests are undone too). NaN where the scene cannot tell.
#ifndef VIEWWORTH_DETECT_EVIDENCE_H
#define VIEWWORTH_DETECT_EVIDENCE_H

#include "viewworth/scene.h"
#include "viewworth/status.h"

// What the pilot run found (pilot_run.h); NaN where there was none.
struct pilot_findings {
    double gain_spread; // as evidence_appearance, of rendered against actual pixels
    double empty_share; // of the box's cells, by density
};

struct survey {
    const struct vw_scene *scene;
    bool masks; // masked pixels are not looked at, as in a training with the effect `masks`
    struct pilot_findings pilot;
};

// VW_ERROR_MEMORY is the only failure of all these.

// Pixels: the largest shift of a photo's corner by its lens, over all photos. A hundredth of a pixel is less than any
// photo resolves.
enum vw_status evidence_distortion(const struct survey *survey, double *evidence);

// The share of photos that have transparent pixels.
enum vw_status evidence_background(const struct survey *survey, double *evidence);

// The share of photos that have a mask file. Masks are obeyed exactly where there are some, so any share calls for it.
enum vw_status evidence_masks(const struct survey *survey, double *evidence);

// How deep a photo sees: the ratio of the 95th to the 5th percentile of the depths of the SfM points that it sees,
// median over photos. Samples that lie evenly between near and far resolve far content by that factor better than near
// one.
enum vw_status evidence_unbounded(const struct survey *survey, double *evidence);

// Open sky: of cells of 1/8 x 1/8 of a photo, the share that shows no SfM point of the whole cloud, nor does any cell
// above it in the photo, and that is smooth and not black; among the cells whose rays rise above the middle of their
// photo, less the share among the others, whose columns are followed down instead: a turntable in front of a backdrop
// is as empty below as above. Black is what rays that meet nothing render as anyway. "Above" is by the mean of the
// cameras' up axes. This is the test of unboundedness for rays: depth percentiles of points cannot be, since they know
// nothing of rays without points (two in-the-wild scenes have smaller ones than a room).
enum vw_status evidence_sky(const struct survey *survey, double *evidence);

// Robust spread over photos of their exposure: of each SfM point and channel, the log of its colour in a photo less the
// median of that in the other photos that see it; its median over the photo's points is the photo's log gain; 1.4826
// times the median absolute deviation over photos and channels. Half of the photos would have to be corrupted to move
// it far. Without enough points: from the pilot run.
enum vw_status evidence_appearance(const struct survey *survey, double *evidence);

// What is left when each photo's gain and bias per channel are taken out: they are fitted (least absolute deviations)
// to the points' colours in the photo by their medians in the others; 1.4826 times the median of |residual| / fitted
// colour is the photo's, and the median over photos and channels the scene's. Errors of matching alone make 0.058 in a
// real room (fox); photos in the wild make 0.093 and more.
enum vw_status evidence_appearance_code(const struct survey *survey, double *evidence);

// The share of the box that the pilot run found empty.
enum vw_status evidence_occupancy(const struct survey *survey, double *evidence);

// ---- For the files of the evidence ----------------------------------------------------------------------------------

// A photo that decides: of train or val.
bool survey_uses_view(const struct survey *survey, uint32_t view);
// Whether a pixel would be trained or validated on.
bool survey_keeps(const struct survey *survey, uint32_t view, uint32_t x_px, uint32_t y_px);
// The same for where a photo sees a point; false also beyond the photo's border.
bool survey_keeps_track(const struct survey *survey, const struct vw_track *track);

// Beyond these a channel says little of the exposure.
#define EVIDENCE_DARK 0.06
#define EVIDENCE_SATURATED 0.94

#endif
