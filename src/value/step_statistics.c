#include "value/step_statistics.h"

#include <math.h>

enum { NONFINITE_BY_CHANCE = 20 };
const double vw_step_statistics_nonfinite_max = 0.1;

struct vw_step_statistics vw_step_statistics_begin(void) {
    return (struct vw_step_statistics){.first_val_psnr_db = NAN, .last_val_psnr_db = NAN};
}

void vw_step_statistics_add(struct vw_step_statistics *statistics, const struct vw_step_record *record) {
    if (record->step == 0) statistics->first_val_psnr_db = record->val_psnr;
    statistics->steps = record->step;
    statistics->nonfinite += record->nonfinite;
    statistics->finite += record->step > 0 && !record->nonfinite;
    statistics->floored += record->floored_views > 0;
    statistics->clamped += record->clamped_count;
    if (isfinite(record->val_psnr)) statistics->last_val_psnr_db = record->val_psnr;
}

bool vw_step_statistics_are_void(const struct vw_step_statistics *statistics) {
    return statistics->steps > 0 && !statistics->finite;
}

bool vw_step_statistics_should_abort(const struct vw_step_statistics *statistics) {
    return statistics->nonfinite > NONFINITE_BY_CHANCE &&
           (double)statistics->nonfinite > vw_step_statistics_nonfinite_max * (double)statistics->steps;
}
