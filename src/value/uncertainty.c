#include "value/uncertainty.h"

#include <math.h>

#include "value/measure.h"

struct vw_interval vw_interval_of_sum(const double *by_epoch, uint32_t count) {
    struct vw_spread spread = {0};
    double sum = 0;
    for (uint32_t e = 0; e < count; e++) {
        if (isnan(by_epoch[e])) continue;
        vw_spread_add(&spread, by_epoch[e]);
        sum += by_epoch[e];
    }
    double error = sqrt(vw_spread_variance(&spread) * (double)spread.count);
    return (struct vw_interval){error, sum - 1.96 * error, sum + 1.96 * error};
}

enum vw_status vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        scores[i].rank_low = 1;
        scores[i].rank_high = count;
        for (uint32_t j = 0; j < count; j++) {
            scores[i].rank_low += scores[j].low > scores[i].high;
            scores[i].rank_high -= scores[j].high < scores[i].low;
        }
    }
    return VW_OK;
}
