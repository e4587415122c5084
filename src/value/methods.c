#include "value/methods.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// ---- The tables ----

#define DB "dB"
#define L1 "mean absolute error"

static const struct vw_value_method listed[] = {
    {"dv_psnr", DB, "sum of d", .additive = true, .has_zero = true},
    {"dv_loss", L1, "sum of d", .additive = true, .has_zero = true},
    {"momentum_psnr", DB, "sum of (d(t) - beta1 d(t - 1)) / (1 - beta1)", .additive = true, .has_zero = true},
    {"quality", "mean rank", "mean of the ranks of dv_loss and of minus the late training loss, each in [0,1]",
     .additive = false},
    {"train_fit", DB, "-10 log10 of the late training loss: how well the photo itself fits", .additive = false},
    {"lasting_psnr", DB, "sum over all steps on the photo of what the end of the training gains by the step",
     .additive = true},
    {"lasting_loss", L1, "the same for minus the mean absolute error", .additive = true},
    {"worth_psnr", DB, "what a training on all photos loses without the photo, by regression over retrainings",
     .additive = true, .has_zero = true},
};

const char vw_value_default_method[] = "dv_psnr";

const struct vw_value_method *vw_value_methods(uint32_t *count) {
    *count = VW_ARRAY_COUNT(listed);
    return listed;
}

const struct vw_value_method *vw_value_method_find(const char *name) {
    for (size_t i = 0; i < VW_ARRAY_COUNT(listed); i++)
        if (strcmp(listed[i].name, name) == 0) return &listed[i];
    return NULL;
}

// Sources: dv_psnr and dv_loss are the equation of Cheimariotis et al. (CAIP 2025). momentum_psnr is our own.
const struct vw_method vw_methods[] = {
    {"dv_psnr", DB, VW_MEASURE_PSNR, VW_FORM_STEP, NULL},
    {"dv_loss", L1, VW_MEASURE_L1, VW_FORM_STEP, NULL},
    {"momentum_psnr", DB, VW_MEASURE_PSNR, VW_FORM_DECONVOLVED, NULL},
};
const uint32_t vw_method_count = VW_ARRAY_COUNT(vw_methods);

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
