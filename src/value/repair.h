// Repair curves: what becomes of the change that a step on a photo makes, over the steps that follow.
//
// A step t on photo i changes validation PSNR by PSNR(t) - PSNR(t - 1): that is what its credit counts. h steps later,
// that step among them, the change is
//     gain(t, h) = PSNR(t + h - 1) - PSNR(t - 1)     [dB]
// It contains what the following steps add, too, whichever photos they are on. So the trend is taken out: the mean of
// gain(., h) over all steps of the same epoch. What is left, averaged over the photo's visits after burn-in, is
//     excess(i, h) = mean over visits t of photo i of (gain(t, h) - mean over the steps s of t's epoch of gain(s, h))
// Negative at h = 1 and near 0 later: the next steps repair what the photo does, and its credit counts more damage than
// lasts. Near 0 at h = 1 and negative later: damage that credit misses.
//
// A gain is unknown where one of its two PSNRs is (a flagged step, the end of the run) and is left out.
// The standard error is that of the mean over the visits, as if they were independent; for large h neighbouring visits
// share steps with other photos, and it is too small where these are in the same order.
#ifndef VIEWWORTH_VALUE_REPAIR_H
#define VIEWWORTH_VALUE_REPAIR_H

#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/value.h"

// h = 1, 2, 3, 5, 8, 12, 20, 30, 50, ... 1200, up to the number of train photos, which is that of the steps of an
// epoch.
enum { VW_REPAIR_HORIZONS_MAX = 16 };

// A mean over visits at each h; NaN where no visit is known.
struct vw_repair_curve {
    double excess_db[VW_REPAIR_HORIZONS_MAX];
    double stderr_db[VW_REPAIR_HORIZONS_MAX]; // NaN below two visits
    uint32_t visits[VW_REPAIR_HORIZONS_MAX];  // known
};

// The mean of the curves of all train photos with one ground-truth label, and the error of that mean, from the photos'
// own; `visits` is their sum. Photos whose excess is unknown are left out.
enum { VW_REPAIR_KINDS_MAX = 32 }; // photos with further labels are in no kind
struct vw_repair_kind {
    const char *ground_truth; // borrowed from the images
    uint32_t photo_count;     // with a visit
    struct vw_repair_curve curve;
};

struct vw_repair_curves {
    uint32_t horizons[VW_REPAIR_HORIZONS_MAX], horizon_count; // 0: no photo has a visit after burn-in
    struct vw_repair_curve *photos;                           // owned; one per image
    struct vw_repair_kind *kinds; // owned; in the order of the images; none without ground-truth labels
    uint32_t kind_count;
};

// Makes the curves. Steps on photos that are not among the images are left out of the photos, but not of the means of
// their epoch. Free the result also after a failure. VW_ERROR_MEMORY.
enum vw_status vw_repair_curves_make(const struct vw_value_input *input, struct vw_repair_curves *curves);
void vw_repair_curves_free(struct vw_repair_curves *curves);

#endif
