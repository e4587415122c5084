// Advice on the photos: which can be left out, which are irreplaceable, and which need a look.
//
// A photo needs a look if it is an outlier, and is a lone view if only its credit is (viewworth/selection.h). The other
// two rest on worth_psnr where there is one, else on lasting_psnr; credit does not tell them (value/README.md).
// Where the reconstruction is too coarse to rank photos by (value/verdict.h), only looks are advised.
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
#ifndef VIEWWORTH_REPORT_ADVICE_H
#define VIEWWORTH_REPORT_ADVICE_H

#include <stdbool.h>
#include <stdint.h>

#include "value/verdict.h"
#include "value/worth.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

enum vw_advice_mark { VW_ADVICE_REMOVABLE = 1, VW_ADVICE_IRREPLACEABLE = 2, VW_ADVICE_LOOK = 4, VW_ADVICE_LONE = 8 };

struct vw_advice {
    const char *basis; // static: "worth_psnr" or "lasting_psnr"; NULL: neither is known, only looks are advised
    bool by_order;     // by ranks, since the basis has no zero
    bool tested;       // the basis is worth_psnr, whose accuracy is known to be above 0
    uint8_t *marks;    // owned; enum vw_advice_mark, one sum per image
};

// Makes the advice; `worth` says how far worth_psnr can be trusted. Free the advice also after a failure. Without
// scores no photo has a mark. VW_ERROR_MEMORY.
enum vw_status vw_advice_make(const struct vw_ledger_score *scores, uint32_t score_count,
                              const struct vw_ledger_image *images, uint32_t image_count,
                              const struct vw_worth_summary *worth, enum vw_verdict verdict, struct vw_advice *advice);
void vw_advice_free(struct vw_advice *advice);

#endif
