#include "viewworth/selection.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ledger/find_image.h"
#include "base/memory.h"
#include "viewworth/value.h"

// The methods with scores, separated by commas; owned by the caller, NULL if memory is short. The rows of a method are
// neighbours.
static char *list_methods(const struct vw_ledger_score *scores, uint32_t score_count) {
    char *list = vw_copy_text("");
    for (uint32_t i = 0; list && i < score_count; i++) {
        if (i > 0 && strcmp(scores[i].method, scores[i - 1].method) == 0) continue;
        char *longer = vw_format_text("%s%s%s", list, i > 0 ? ", " : "", scores[i].method);
        free(list);
        list = longer;
    }
    return list;
}

static enum vw_status refuse_method(const struct vw_ledger_score *scores, uint32_t score_count, const char *method) {
    if (score_count == 0)
        return vw_fail(VW_ERROR_INPUT,
                       "the ledger has no scores; value the photos first, with --epochs larger than --burn-in");
    char *methods = list_methods(scores, score_count);
    if (!methods) return VW_ERROR_MEMORY;
    enum vw_status status = vw_fail(VW_ERROR_USAGE, "method \"%s\" has no scores; use one of: %s", method, methods);
    free(methods);
    return status;
}

// Best first.
static int compare_scores(const void *left, const void *right) {
    const struct vw_ledger_score *a = *(const struct vw_ledger_score *const *)left,
                                 *b = *(const struct vw_ledger_score *const *)right;
    if (a->value != b->value) return a->value > b->value ? -1 : 1;
    return (a->image_id > b->image_id) - (a->image_id < b->image_id);
}

// The known scores of train photos by the method, best first.
static enum vw_status rank(const struct vw_ledger_score *scores, uint32_t score_count,
                           const struct vw_ledger_image *images, uint32_t image_count, const char *method,
                           const struct vw_ledger_score **ranked, uint32_t *ranked_count) {
    bool has_method = false;
    for (uint32_t i = 0; i < score_count; i++) {
        if (strcmp(scores[i].method, method) != 0) continue;
        has_method = true;
        const struct vw_ledger_image *image = vw_ledger_find_image(images, image_count, scores[i].image_id);
        if (!image)
            return vw_fail(VW_ERROR_INPUT,
                           "score of image %u, which is not in the image table; check the ledger with viewworth verify",
                           scores[i].image_id);
        bool known = isfinite(scores[i].value) && scores[i].visits > 0;
        if (known && strcmp(image->split, "train") == 0) ranked[(*ranked_count)++] = &scores[i];
    }
    if (!has_method) return refuse_method(scores, score_count, method);
    qsort(ranked, *ranked_count, sizeof *ranked, compare_scores);
    return VW_OK;
}

bool vw_selection_read_amount(const char *text, struct vw_selection_params *params) {
    char *end = NULL;
    if (!isdigit((unsigned char)text[0])) return false;
    params->amount = strtod(text, &end);
    params->percent = strcmp(end, "%") == 0;
    return params->percent || !*end;
}

static enum vw_status check_amount(const struct vw_selection_params *params) {
    if (params->rule != VW_SELECT_TOP && params->rule != VW_SELECT_DROP) return VW_OK;
    bool whole = params->amount >= 1 && params->amount <= UINT32_MAX && params->amount == floor(params->amount);
    if (params->percent ? params->amount > 0 && params->amount <= 100 : whole) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "cannot select by %g%s; give a whole number of photos, or a percentage above 0 and at most 100",
                   params->amount, params->percent ? " %" : "");
}

// The number of ranked photos that `amount` means.
static uint32_t share_of(const struct vw_selection_params *params, uint32_t ranked_count) {
    double share = params->percent ? round(ranked_count * params->amount / 100) : params->amount;
    return share < ranked_count ? (uint32_t)share : ranked_count;
}

// Whether a rule by value or interval keeps the score; the ends of the interval may be NaN.
static bool keeps(enum vw_selection_rule rule, const struct vw_ledger_score *score) {
    if (rule == VW_SELECT_NOT_HARMFUL) return !(score->ci_high < 0);
    return (rule == VW_SELECT_POSITIVE ? score->value : score->ci_low) > 0;
}

// Moves the kept photos to the front, in their order, and returns their number.
static uint32_t keep(const struct vw_selection_params *params, const struct vw_ledger_score **ranked,
                     uint32_t ranked_count) {
    uint32_t share = share_of(params, ranked_count), kept = 0;
    if (params->rule == VW_SELECT_TOP) return share > 0 || ranked_count == 0 ? share : 1;
    if (params->rule == VW_SELECT_DROP) return ranked_count - share;
    for (uint32_t i = 0; i < ranked_count; i++)
        if (keeps(params->rule, ranked[i])) ranked[kept++] = ranked[i];
    return kept;
}

static enum vw_status refuse_empty(const struct vw_selection_params *params, uint32_t ranked_count) {
    if (ranked_count == 0)
        return vw_fail(
            VW_ERROR_INPUT,
            "no train photo has a score by this method; value the photos with --epochs larger than --burn-in");
    if (params->rule == VW_SELECT_DROP)
        return vw_fail(VW_ERROR_INPUT, "all %u photos would be dropped; drop fewer", ranked_count);
    if (params->rule == VW_SELECT_NOT_HARMFUL)
        return vw_fail(VW_ERROR_INPUT, "the intervals of all %u scores are below zero; use --top instead",
                       ranked_count);
    return vw_fail(VW_ERROR_INPUT, "none of %u scores %s above zero; use --top instead", ranked_count,
                   params->rule == VW_SELECT_POSITIVE ? "is" : "has an interval");
}

static enum vw_status copy_ids(const struct vw_ledger_score *const *kept, uint32_t count, uint32_t scored_count,
                               struct vw_selection *selection) {
    uint32_t *image_ids = vw_allocate(count, sizeof *image_ids);
    if (!image_ids) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) image_ids[i] = kept[i]->image_id;
    *selection = (struct vw_selection){image_ids, count, scored_count};
    return VW_OK;
}

enum vw_status vw_selection_make(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count,
                                 const struct vw_selection_params *params, struct vw_selection *selection) {
    uint32_t ranked_count = 0, count = 0;
    enum vw_status status = check_amount(params);
    if (status) return status;
    const struct vw_ledger_score **ranked = vw_allocate(score_count, sizeof *ranked);
    if (!ranked) return VW_ERROR_MEMORY;
    const char *method = params->method ? params->method : vw_value_default_method;
    status = rank(scores, score_count, images, image_count, method, ranked, &ranked_count);
    if (!status) count = keep(params, ranked, ranked_count);
    if (!status && count == 0) status = refuse_empty(params, ranked_count);
    if (!status) status = copy_ids(ranked, count, ranked_count, selection);
    free(ranked);
    return status;
}

void vw_selection_free(struct vw_selection *selection) {
    free(selection->image_ids);
    *selection = (struct vw_selection){0};
}
