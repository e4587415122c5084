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
