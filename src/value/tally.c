#include "viewworth/tally.h"

#include <math.h>

enum { NONFINITE_BY_CHANCE = 20 };
const double vw_tally_nonfinite_share = 0.1;

struct vw_tally vw_tally_begin(void) {
    return (struct vw_tally){.first_val_psnr_db = NAN, .last_val_psnr_db = NAN};
}

void vw_tally_add(struct vw_tally *tally, const struct vw_step_record *record) {
    if (record->step == 0) tally->first_val_psnr_db = record->val_psnr;
    tally->steps = record->step;
    tally->nonfinite += record->nonfinite;
    tally->floored += record->floored_views > 0;
    tally->clamped += record->clamped_count;
    if (isfinite(record->val_psnr)) tally->last_val_psnr_db = record->val_psnr;
}

bool vw_tally_is_hopeless(const struct vw_tally *tally) {
    return tally->nonfinite > NONFINITE_BY_CHANCE && (double)tally->nonfinite > vw_tally_nonfinite_share * (double)tally->steps;
}
