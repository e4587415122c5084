// Advice on the photos: which can be left out, which are irreplaceable, and which need a look.
//
// A photo needs a look if it has a defect (base/defect.h), whatever its scores, or is an outlier, and is a lone view if
// only its credit is an outlier (viewworth/selection.h). The other two rest on worth_psnr where there is one, else on
// lasting_psnr; credit does not tell them (value/README.md). Where the reconstruction is too coarse to rank photos by
// (value/verdict.h), only looks are advised.
// - worth_psnr comes from retrainings. Unless the 95 % interval of its accuracy on left-out retrainings lies above 0
//   (value/worth.h), these have not shown that it tells photos apart, and it marks no photo. Otherwise
//   - a photo can be left out if its interval ends at or below 0, or below both the noise of a training (another seed
//     changes more) and the median worth (it adds less than an ordinary photo even then). A wide interval alone never
//     makes a photo removable. The median bounds the noise, which is large where trainings are short;
//   - a photo is irreplaceable if its interval is above 0 and it is among the most valuable tenth.
// - Of lasting_psnr only the order means something: a photo can probably be left out if its rank interval lies in the
//   lower half, and is irreplaceable if its rank interval lies in the upper quarter; without rank intervals: if it is
//   in the last quarter, and in the first tenth.
// A photo that needs a look, or a lone view, is never among those that can be left out: no validation photo may see
// what a lone view sees.
//
// The photo's advice follows from its marks: look at it, drop it (removable), keep it (irreplaceable, lone, or its
// score's interval is above 0), or it is unclear. Drop and keep need a basis that is trusted: worth that retrainings
// confirm, lasting credit that the gate does not refute, or credit, of a reconstruction that can rank photos by
// validation photos that others would agree with (vw_ranking_agreement_is_low()).
#ifndef VIEWWORTH_REPORT_ADVICE_H
#define VIEWWORTH_REPORT_ADVICE_H

#include "base/rows.h"
#include "report/results.h"
#include "viewworth/status.h"

extern const char *const vw_advice_words[VW_ADVICE_COUNT]; // "keep", "look", "unclear", "drop"

// Computes worth and advice from the other results. VW_ERROR_MEMORY.
enum vw_status vw_results_advise(struct vw_results *results);
// Returns the rows of advice.csv: name,advice,reason,score,ci_low,ci_high,unit,method,description and the evidence
// (struct vw_photo_finding), train_fit, quality; in JSON the first three.
struct vw_rows vw_advice_rows(const struct vw_advice *advice);

#endif
