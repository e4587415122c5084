#include "value/ranking.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

int vw_score_compare(const void *left, const void *right) {
    const struct vw_ledger_score *a = left, *b = right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return (a->image_id > b->image_id) - (a->image_id < b->image_id);
}

enum vw_status vw_scores_rank(const struct vw_ledger_score *scores, uint32_t score_count, const char *method,
                              struct vw_ledger_score **ranked, uint32_t *ranked_count) {
    *ranked_count = 0;
    *ranked = vw_allocate(score_count, sizeof **ranked);
    if (!*ranked) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, method) == 0) (*ranked)[(*ranked_count)++] = scores[i];
    if (*ranked_count) qsort(*ranked, *ranked_count, sizeof **ranked, vw_score_compare);
    return VW_OK;
}
