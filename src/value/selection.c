#include "viewworth/selection.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"
#include "value/methods.h"
#include "viewworth/value.h"

// Lists the methods with scores, separated by commas; owned by the caller, NULL if memory is short. The rows of a
// method are neighbours.
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

static int compare_scores(const void *left, const void *right) {
    return vw_score_compare(*(const struct vw_ledger_score *const *)left,
                            *(const struct vw_ledger_score *const *)right);
}

// Lists the known scores of train photos by the method, best first.
static enum vw_status rank(const struct vw_ledger_score *scores, uint32_t score_count,
                           const struct vw_ledger_image *images, uint32_t image_count, const char *method,
                           const struct vw_ledger_score **ranked, uint32_t *ranked_count) {
    bool has_method = false;
    for (uint32_t i = 0; i < score_count; i++) {
        if (strcmp(scores[i].method, method) != 0) continue;
        has_method = true;
        const struct vw_ledger_image *image = NULL;
        enum vw_status status = vw_ledger_require_image(images, image_count, scores[i].image_id, &image);
        if (status) return vw_fail_context(status, "scores");
        bool known = isfinite(scores[i].value) && scores[i].visits > 0;
        if (known && strcmp(image->split, "train") == 0) ranked[(*ranked_count)++] = &scores[i];
    }
    if (!has_method) return refuse_method(scores, score_count, method);
    qsort(ranked, *ranked_count, sizeof *ranked, compare_scores);
    return VW_OK;
}

bool vw_selection_read_rule(const char *words, struct vw_selection_params *params) {
    static const char *const names[] = {[VW_SELECT_OUTLIERS] = "without-outliers",
                                        [VW_SELECT_POSITIVE] = "positive",
                                        [VW_SELECT_SIGNIFICANT] = "significant",
                                        [VW_SELECT_NOT_HARMFUL] = "not-harmful",
                                        [VW_SELECT_TOP] = "top:",
                                        [VW_SELECT_DROP] = "drop:"};
    size_t rule = 0, length = 0;
    for (; rule < VW_ARRAY_COUNT(names); rule++) {
        length = strlen(names[rule]);
        if (!strncmp(words, names[rule], length)) break;
    }
    if (rule == VW_ARRAY_COUNT(names)) return false;
    params->rule = (enum vw_selection_rule)rule;
    const char *amount = words + length;
    char *end = (char *)amount;
    if (rule == VW_SELECT_TOP || rule == VW_SELECT_DROP) {
        if (!isdigit((unsigned char)*amount)) return false;
        params->amount = strtod(amount, &end);
        params->percent = *end == '%';
        end += params->percent;
    }
    return !*end;
}

static enum vw_status check_amount(const struct vw_selection_params *params) {
    if (params->rule != VW_SELECT_TOP && params->rule != VW_SELECT_DROP) return VW_OK;
    bool whole = params->amount >= 1 && params->amount <= UINT32_MAX && params->amount == floor(params->amount);
    if (params->percent ? params->amount > 0 && params->amount <= 100 : whole) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "cannot select by %g%s; give a whole number of photos, or a percentage above 0 and at most 100",
                   params->amount, params->percent ? " %" : "");
}

// Returns the number of ranked photos that `amount` means.
static uint32_t share_of(const struct vw_selection_params *params, uint32_t ranked_count) {
    double share = params->percent ? round(ranked_count * params->amount / 100) : params->amount;
    return share < ranked_count ? (uint32_t)share : ranked_count;
}

// Returns whether a rule by value or interval keeps the score; the ends of the interval may be NaN.
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

static bool compares_with_zero(enum vw_selection_rule rule) {
    return rule == VW_SELECT_POSITIVE || rule == VW_SELECT_SIGNIFICANT || rule == VW_SELECT_NOT_HARMFUL;
}

// Refuses rules about zero for ranks and lasting credit, of which only differences have a meaning.
static enum vw_status check_zero(const char *method, enum vw_selection_rule rule) {
    const struct vw_value_method *about = vw_value_method_find(method);
    if (!compares_with_zero(rule) || !about || about->has_zero) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "method \"%s\" has a zero that means nothing: only differences do; use top:K or drop:K", method);
}

static enum vw_status refuse_empty(const struct vw_selection_params *params, uint32_t ranked_count) {
    if (ranked_count == 0)
        return vw_fail(
            VW_ERROR_INPUT,
            "no train photo has a score by this method; value the photos with --epochs larger than --burn-in");
    if (params->rule == VW_SELECT_DROP)
        return vw_fail(VW_ERROR_INPUT, "all %u photos would be dropped; drop fewer", ranked_count);
    if (params->rule == VW_SELECT_NOT_HARMFUL)
        return vw_fail(VW_ERROR_INPUT, "the intervals of all %u scores are below zero; use top:K instead",
                       ranked_count);
    return vw_fail(VW_ERROR_INPUT, "none of %u scores %s above zero; use top:K instead", ranked_count,
                   params->rule == VW_SELECT_POSITIVE ? "is" : "has an interval");
}

// ---- Without robust outliers ----

enum { OUTLIER_PHOTOS_LEAST = 5 }; // among fewer, median and spread say little

enum evidence { FIT, CREDIT_PSNR, CREDIT_LOSS, EVIDENCE_COUNT };
static const char *const evidence_methods[EVIDENCE_COUNT] = {"train_fit", "dv_psnr", "dv_loss"};

struct search {
    const struct vw_ledger_image *images;
    uint32_t image_count;
    bool *out, *listed; // per image: it is an outlier; it is listed, or an outlier
    double *z;          // per image and evidence; NaN: unknown
    const struct vw_ledger_score **ranked, **first;
    uint32_t first_count; // length of the credit's ranking
    struct vw_selection made;
};

static uint32_t place_of(const struct search *search, uint32_t image_id) {
    return (uint32_t)(vw_ledger_find_image(search->images, search->image_count, image_id) - search->images);
}

static void add_outlier(struct search *search, uint32_t place, const char *method, double z, bool lone) {
    search->made.outliers[search->made.outlier_count++] =
        (struct vw_selection_outlier){search->images[place].image_id, method, z, lone};
    search->out[place] = !lone;
}

// Measures how far each ranked score is from the median, in robust spreads; 0 where nothing can stand out.
static enum vw_status measure(struct search *search, uint32_t count, enum evidence evidence) {
    double *values = vw_allocate(count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) values[i] = search->ranked[i]->value;
    double median = vw_median(values, count), spread = vw_robust_spread(values, count);
    free(values);
    bool varies = count >= OUTLIER_PHOTOS_LEAST && spread > 0;
    for (uint32_t i = 0; i < count; i++)
        search->z[place_of(search, search->ranked[i]->image_id) * EVIDENCE_COUNT + evidence] =
            varies ? (search->ranked[i]->value - median) / spread : 0;
    return VW_OK;
}

// Adds the outliers of one method alone, worst first. Its ranking is best first.
static void find_outliers(struct search *search, uint32_t count, const char *method) {
    for (uint32_t i = count; i-- > 0;) {
        uint32_t place = place_of(search, search->ranked[i]->image_id);
        double z = search->z[place * EVIDENCE_COUNT];
        if (z < VW_SELECTION_OUTLIER_Z) add_outlier(search, place, method, z, false);
    }
}

// Adds the photos that their own fit and their credit show to be outliers, and the lone views, in the order of images.
static void judge(struct search *search) {
    for (uint32_t i = 0; i < search->image_count; i++) {
        const double *z = &search->z[i * EVIDENCE_COUNT];
        bool low_credit = fmax(z[CREDIT_PSNR], z[CREDIT_LOSS]) < VW_SELECTION_LOW_CREDIT_Z;
        bool out = (z[FIT] < VW_SELECTION_OUTLIER_Z && fmin(z[CREDIT_PSNR], z[CREDIT_LOSS]) < 0) ||
                   (z[FIT] < VW_SELECTION_LOW_FIT_Z && low_credit);
        bool lone = !out && low_credit && !isnan(z[FIT]);
        for (int e = 0; (out || lone) && e < EVIDENCE_COUNT; e++)
            if (!isnan(z[e])) add_outlier(search, i, evidence_methods[e], z[e], lone);
    }
}

static void list_photo(struct search *search, uint32_t place) {
    bool wanted = !search->out[place] && !search->listed[place];
    search->listed[place] = true;
    if (wanted) search->made.image_ids[search->made.count++] = search->images[place].image_id;
}

// Lists the photos of the ranking by the method, or by credit, then those without a score by it.
static void list_others(struct search *search) {
    for (uint32_t i = 0; i < search->first_count; i++) list_photo(search, place_of(search, search->first[i]->image_id));
    search->made.scored_count = search->first_count;
    for (uint32_t i = 0; i < search->image_count; i++)
        if (strcmp(search->images[i].split, "train") == 0) list_photo(search, i);
}

static bool has_scores(const struct vw_ledger_score *scores, uint32_t score_count, const char *method) {
    for (uint32_t i = 0; i < score_count; i++)
        if (strcmp(scores[i].method, method) == 0) return true;
    return false;
}

static enum vw_status search_outliers(struct search *search, const struct vw_ledger_score *scores, uint32_t score_count,
                                      const char *only) {
    const char *const *methods = only ? &only : evidence_methods;
    for (uint32_t i = 0; i < EVIDENCE_COUNT * search->image_count; i++) search->z[i] = NAN;
    uint32_t used = 0;
    for (int e = 0; e < (only ? 1 : EVIDENCE_COUNT); e++) {
        uint32_t count = 0;
        if (!has_scores(scores, score_count, methods[e])) continue;
        enum vw_status status =
            rank(scores, score_count, search->images, search->image_count, methods[e], search->ranked, &count);
        if (!status) status = measure(search, count, e);
        if (status) return status;
        if (only) find_outliers(search, count, only);
        if ((!only && e == FIT) || used++) continue;
        memcpy(search->first, search->ranked, score_count * sizeof *search->first);
        search->first_count = count;
    }
    if (!used) return refuse_method(scores, score_count, methods[only ? FIT : CREDIT_PSNR]);
    if (!only) judge(search);
    list_others(search);
    return search->made.count ? VW_OK : vw_fail(VW_ERROR_INPUT, "the ledger has no photo to train on");
}

static enum vw_status leave_outliers_out(const struct vw_ledger_score *scores, uint32_t score_count,
                                         const struct vw_ledger_image *images, uint32_t image_count, const char *method,
                                         struct vw_selection *selection) {
    struct search search = {.images = images,
                            .image_count = image_count,
                            .out = vw_allocate(image_count, sizeof *search.out),
                            .listed = vw_allocate(image_count, sizeof *search.listed),
                            .z = vw_allocate(image_count, EVIDENCE_COUNT * sizeof *search.z),
                            .ranked = vw_allocate(score_count, sizeof *search.ranked),
                            .first = vw_allocate(score_count, sizeof *search.first),
                            .made = {.method = method,
                                     .image_ids = vw_allocate(image_count, sizeof *search.made.image_ids),
                                     .outliers = vw_allocate(score_count, sizeof *search.made.outliers)}};
    bool whole = search.out && search.listed && search.z && search.ranked && search.first && search.made.image_ids &&
                 search.made.outliers;
    enum vw_status status = whole ? search_outliers(&search, scores, score_count, method) : VW_ERROR_MEMORY;
    free(search.out);
    free(search.listed);
    free(search.z);
    free(search.ranked);
    free(search.first);
    if (status) vw_selection_free(&search.made);
    else *selection = search.made;
    return status;
}

// ---- All rules ----

static enum vw_status copy_ids(const struct vw_ledger_score *const *kept, uint32_t count, uint32_t scored_count,
                               struct vw_selection *selection) {
    uint32_t *image_ids = vw_allocate(count, sizeof *image_ids);
    if (!image_ids) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < count; i++) image_ids[i] = kept[i]->image_id;
    *selection = (struct vw_selection){.image_ids = image_ids, .count = count, .scored_count = scored_count};
    return VW_OK;
}

static const char *choose_method(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_selection_params *params) {
    const char *main_method = vw_value_main_method(scores, score_count);
    if (params->method) return params->method;
    return compares_with_zero(params->rule) && !vw_value_method_find(main_method)->has_zero ? vw_value_default_method
                                                                                            : main_method;
}

enum vw_status vw_selection_make(const struct vw_ledger_score *scores, uint32_t score_count,
                                 const struct vw_ledger_image *images, uint32_t image_count,
                                 const struct vw_selection_params *params, struct vw_selection *selection) {
    uint32_t ranked_count = 0, count = 0;
    const char *method = choose_method(scores, score_count, params);
    enum vw_status status = check_amount(params);
    if (!status) status = check_zero(method, params->rule);
    if (status) return status;
    if (params->rule == VW_SELECT_OUTLIERS)
        return leave_outliers_out(scores, score_count, images, image_count, params->method, selection);
    const struct vw_ledger_score **ranked = vw_allocate(score_count, sizeof *ranked);
    if (!ranked) return VW_ERROR_MEMORY;
    status = rank(scores, score_count, images, image_count, method, ranked, &ranked_count);
    if (!status) count = keep(params, ranked, ranked_count);
    if (!status && count == 0) status = refuse_empty(params, ranked_count);
    if (!status) status = copy_ids(ranked, count, ranked_count, selection);
    if (!status) selection->method = method;
    free(ranked);
    return status;
}

void vw_selection_free(struct vw_selection *selection) {
    free(selection->image_ids);
    free(selection->outliers);
    *selection = (struct vw_selection){0};
}
