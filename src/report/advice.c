#include "report/advice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "ledger/find_image.h"
#include "viewworth/selection.h"
#include "viewworth/value.h"

static bool is_known(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0 && isfinite(score->value) && score->visits > 0;
}

static bool has_known(const struct vw_ledger_score *scores, uint32_t score_count, const char *method) {
    uint32_t i = 0;
    while (i < score_count && !is_known(&scores[i], method)) i++;
    return i < score_count;
}

// ---- Photos to look at ---------------------------------------------------------------------------------------------

static void mark(const struct vw_ledger_image *images, uint32_t image_count, uint32_t image_id,
                 enum vw_advice_mark mark, struct vw_advice *advice) {
    const struct vw_ledger_image *image = vw_ledger_find_image(images, image_count, image_id);
    if (image) advice->marks[image - images] |= (uint8_t)mark;
}

static enum vw_status mark_looks(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count, struct vw_advice *advice) {
    struct vw_selection selection = {0};
    const struct vw_selection_params params = {.rule = VW_SELECT_OUTLIERS};
    enum vw_status status = vw_selection_make(scores, score_count, images, image_count, &params, &selection);
    for (uint32_t i = 0; i < selection.outlier_count; i++)
        mark(images, image_count, selection.outliers[i].image_id,
             selection.outliers[i].lone ? VW_ADVICE_LONE : VW_ADVICE_LOOK, advice);
    vw_selection_free(&selection);
    return status == VW_ERROR_MEMORY ? status : VW_OK; // a ledger without train photos has no outliers
}

// ---- Photos that can be left out, and those that cannot ------------------------------------------------------------

static int compare_values(const void *left, const void *right) {
    double a = *(const double *)left, b = *(const double *)right;
    return a > b ? -1 : a < b;
}

// Returns 1 for the highest; equal values share the best rank. `values` are the highest first.
static uint32_t rank_of(const double *values, uint32_t count, double value) {
    uint32_t low = 0, high = count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (values[middle] > value) low = middle + 1;
        else high = middle;
    }
    return low + 1;
}

static uint8_t judge_worth(const struct vw_ledger_score *score, uint32_t rank, uint32_t count, double removable_db) {
    if (score->ci_high <= 0 || score->ci_high < removable_db) return VW_ADVICE_REMOVABLE;
    return score->ci_low > 0 && rank <= (count + 9) / 10 ? VW_ADVICE_IRREPLACEABLE : 0;
}

static uint8_t judge_order(const struct vw_ledger_score *score, uint32_t rank, uint32_t count) {
    if (!score->rank_ci_low || !score->rank_ci_high) { // one training says little: its ends alone
        if (rank > count - count / 4) return VW_ADVICE_REMOVABLE;
        return rank <= (count + 9) / 10 ? VW_ADVICE_IRREPLACEABLE : 0;
    }
    if (score->rank_ci_low > (count + 1) / 2) return VW_ADVICE_REMOVABLE;
    return score->rank_ci_high <= (count + 3) / 4 ? VW_ADVICE_IRREPLACEABLE : 0;
}

// Returns the value below which an interval of worth has to end. `values` are the highest first.
static double removable_below(const double *values, uint32_t count, double noise_db) {
    double median = (values[(count - 1) / 2] + values[count / 2]) / 2;
    return noise_db < median ? noise_db : isnan(noise_db) ? 0 : median;
}

static enum vw_status mark_worth(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count, double noise_db,
                                 struct vw_advice *advice) {
    uint32_t count = 0;
    double *values = vw_allocate(score_count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < score_count; i++)
        if (is_known(&scores[i], advice->basis)) values[count++] = scores[i].value;
    qsort(values, count, sizeof *values, compare_values);
    for (uint32_t i = 0; i < score_count; i++) {
        if (!is_known(&scores[i], advice->basis)) continue;
        uint32_t rank = rank_of(values, count, scores[i].value);
        uint8_t found = advice->by_order
                            ? judge_order(&scores[i], rank, count)
                            : judge_worth(&scores[i], rank, count, removable_below(values, count, noise_db));
        const struct vw_ledger_image *image = vw_ledger_find_image(images, image_count, scores[i].image_id);
        if (!image || (found == VW_ADVICE_REMOVABLE && advice->marks[image - images])) continue;
        advice->marks[image - images] |= found;
    }
    free(values);
    return VW_OK;
}

enum vw_status vw_advice_make(const struct vw_ledger_score *scores, uint32_t score_count,
                              const struct vw_ledger_image *images, uint32_t image_count,
                              const struct vw_worth_summary *worth, enum vw_verdict verdict, struct vw_advice *advice) {
    *advice = (struct vw_advice){.marks = vw_allocate(image_count, sizeof *advice->marks)};
    if (!advice->marks) return VW_ERROR_MEMORY;
    if (!has_known(scores, score_count, "dv_psnr")) return VW_OK;
    const char *method = vw_value_main_method(scores, score_count);
    if (strcmp(method, vw_value_default_method) != 0) advice->basis = method;
    advice->by_order = advice->basis != vw_worth_method;
    advice->tested = !advice->by_order && worth->claim_count && worth->claims[0].accuracy.ci_low > 0;
    enum vw_status status = mark_looks(scores, score_count, images, image_count, advice);
    if (status || verdict == VW_VERDICT_TOO_COARSE || !advice->basis || !(advice->by_order || advice->tested))
        return status;
    return mark_worth(scores, score_count, images, image_count, worth->noise_db, advice);
}

void vw_advice_free(struct vw_advice *advice) {
    free(advice->marks);
    *advice = (struct vw_advice){0};
}
