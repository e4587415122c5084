#include "value/evaluation/agreement.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

uint32_t vw_agreement_keep(const double *a, const double *b, const bool *only, uint32_t count, double *kept_a,
                           double *kept_b) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!isfinite(a[i]) || !isfinite(b[i]) || (only && !only[i])) continue;
        kept_a[kept] = a[i];
        kept_b[kept++] = b[i];
    }
    return kept;
}

enum vw_status vw_agreement_of_pair(const double *a, const double *b, const bool *only, uint32_t count,
                                    struct vw_agreement *agreement) {
    double *kept = vw_allocate(count, 2 * sizeof *kept);
    if (!kept) return VW_ERROR_MEMORY;
    uint32_t photos = vw_agreement_keep(a, b, only, count, kept, kept + count);
    struct vw_agreement made = {.pearson = vw_pearson(kept, kept + count, photos), .photos = photos};
    enum vw_status status = vw_spearman(kept, kept + count, photos, &made.spearman);
    free(kept);
    if (!status) *agreement = made;
    return status;
}

void vw_agreement_add(double value, struct vw_agreement_summary *summary) {
    if (isnan(value)) return;
    summary->sum += value;
    summary->pairs++;
    summary->mean = summary->sum / summary->pairs;
    summary->lowest = fmin(summary->lowest, value); // which prefers a number to NaN
    summary->highest = fmax(summary->highest, value);
}

enum vw_status vw_agreement_of_runs(const double *values, uint32_t run_count, uint32_t photo_count,
                                    struct vw_agreement_summary *pearson, struct vw_agreement_summary *spearman) {
    enum vw_status status = VW_OK;
    *pearson = *spearman = VW_AGREEMENT_NONE;
    for (uint32_t a = 0; a < run_count; a++)
        for (uint32_t b = a + 1; b < run_count && !status; b++) {
            struct vw_agreement pair = {.pearson = NAN, .spearman = NAN};
            status = vw_agreement_of_pair(values + (size_t)a * photo_count, values + (size_t)b * photo_count, NULL,
                                          photo_count, &pair);
            vw_agreement_add(pair.pearson, pearson);
            vw_agreement_add(pair.spearman, spearman);
        }
    return status;
}
