// Scores in order: the best first, equal ones by image.
#ifndef VIEWWORTH_VALUE_RANKING_H
#define VIEWWORTH_VALUE_RANKING_H

#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Compares two struct vw_ledger_score for qsort.
int vw_score_compare(const void *left, const void *right);
// Copies the scores of a method, in order: an array for free(), whose texts are lent by `scores`.
enum vw_status vw_scores_rank(const struct vw_ledger_score *scores, uint32_t score_count, const char *method,
                              struct vw_ledger_score **ranked, uint32_t *ranked_count);

#endif
