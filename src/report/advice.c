#include "report/advice.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "value/lasting_scores.h"
#include "viewworth/selection.h"
#include "viewworth/value.h"

const char *const vw_advice_words[VW_ADVICE_COUNT] = {"keep", "look", "unclear", "drop"};

static bool is_known(const struct vw_ledger_score *score, const char *method) {
    return strcmp(score->method, method) == 0 && isfinite(score->value) && score->visits > 0;
}

static bool has_known(const struct vw_results *results, const char *method) {
    uint32_t i = 0;
    while (i < results->score_count && !is_known(&results->scores[i], method)) i++;
    return i < results->score_count;
}

// Returns the advice on a photo; NULL for one that is not trained on.
static struct vw_photo_advice *find(struct vw_advice *advice, uint32_t image_id) {
    for (uint32_t i = 0; i < advice->count; i++)
        if (advice->photos[i].image->image_id == image_id) return &advice->photos[i];
    return NULL;
}

// ---- Photos to look at ---------------------------------------------------------------------------------------------

static enum vw_status mark_looks(const struct vw_results *results, struct vw_advice *advice) {
    struct vw_selection selection = {0};
    const struct vw_selection_params params = {.rule = VW_SELECT_OUTLIERS};
    enum vw_status status = vw_selection_make(results->scores, results->score_count, results->input.images,
                                              results->input.image_count, &params, &selection);
    for (uint32_t i = 0; i < selection.outlier_count; i++) {
        struct vw_photo_advice *photo = find(advice, selection.outliers[i].image_id);
        if (photo) photo->marks |= selection.outliers[i].lone ? VW_MARK_LONE : VW_MARK_LOOK;
    }
    vw_selection_free(&selection);
    for (uint32_t i = 0; i < advice->count; i++)
        if (advice->photos[i].description) advice->photos[i].marks |= VW_MARK_LOOK;
    return status == VW_ERROR_MEMORY ? status : VW_OK; // a ledger without train photos has no outliers
}

// ---- Photos that can be left out, and those that cannot ------------------------------------------------------------

// Returns 1 for the highest of the sorted values; equal values share the best rank.
static uint32_t rank_of(const double *sorted, uint32_t count, double value) {
    uint32_t low = 0, high = count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (sorted[middle] > value) high = middle;
        else low = middle + 1;
    }
    return count - low + 1;
}

static uint8_t judge_worth(const struct vw_ledger_score *score, uint32_t rank, uint32_t count, double removable_db) {
    if (score->ci_high <= 0 || score->ci_high < removable_db) return VW_MARK_REMOVABLE;
    return score->ci_low > 0 && rank <= (count + 9) / 10 ? VW_MARK_IRREPLACEABLE : 0;
}

static uint8_t judge_order(const struct vw_ledger_score *score, uint32_t rank, uint32_t count) {
    if (!score->rank_ci_low || !score->rank_ci_high) { // one training says little: its ends alone
        if (rank > count - count / 4) return VW_MARK_REMOVABLE;
        return rank <= (count + 9) / 10 ? VW_MARK_IRREPLACEABLE : 0;
    }
    if (score->rank_ci_low > (count + 1) / 2) return VW_MARK_REMOVABLE;
    return score->rank_ci_high <= (count + 3) / 4 ? VW_MARK_IRREPLACEABLE : 0;
}

// Returns the value below which an interval of worth has to end.
static double removable_below(const double *sorted, uint32_t count, double noise_db) {
    double median = vw_quantile_of_sorted(sorted, count, 0.5);
    return noise_db < median ? noise_db : isnan(noise_db) ? 0 : median;
}

static enum vw_status mark_worth(const struct vw_results *results, struct vw_advice *advice) {
    uint32_t count = 0;
    double *values = vw_allocate(results->score_count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < results->score_count; i++)
        if (is_known(&results->scores[i], advice->basis)) values[count++] = results->scores[i].value;
    vw_sort(values, count);
    for (uint32_t i = 0; i < results->score_count; i++) {
        const struct vw_ledger_score *score = &results->scores[i];
        if (!is_known(score, advice->basis)) continue;
        uint32_t rank = rank_of(values, count, score->value);
        uint8_t found = advice->by_order
                            ? judge_order(score, rank, count)
                            : judge_worth(score, rank, count, removable_below(values, count, results->worth.noise_db));
        struct vw_photo_advice *photo = find(advice, score->image_id);
        if (photo && (found != VW_MARK_REMOVABLE || !photo->marks)) photo->marks |= found;
    }
    free(values);
    return VW_OK;
}

static enum vw_status mark(const struct vw_results *results, struct vw_advice *advice) {
    if (!has_known(results, vw_value_default_method)) return mark_looks(results, advice);
    const char *method = vw_value_main_method(results->scores, results->score_count);
    const struct vw_worth_summary *worth = &results->worth;
    if (strcmp(method, vw_value_default_method) != 0) advice->basis = method;
    advice->by_order = advice->basis != vw_worth_method;
    advice->tested = !advice->by_order && worth->claim_count && worth->claims[0].accuracy.ci_low > 0;
    enum vw_status status = mark_looks(results, advice);
    bool coarse = vw_verdict_judge(&results->reconstruction) == VW_VERDICT_TOO_COARSE;
    if (status || coarse || !advice->basis || !(advice->by_order || advice->tested)) return status;
    return mark_worth(results, advice);
}

// ---- Words and reasons ---------------------------------------------------------------------------------------------

static bool is_trusted(const struct vw_results *results, const struct vw_advice *advice) {
    if (vw_verdict_judge(&results->reconstruction) == VW_VERDICT_TOO_COARSE) return false;
    if (!advice->basis) return !vw_ranking_agreement_is_low(&results->agreement);
    if (!advice->by_order) return advice->tested;
    const struct vw_lasting_pass *lasting = &results->input.lasting;
    return !lasting->check_count || vw_lasting_gate(lasting, false) >= vw_lasting_gate_least;
}

// Returns whether a score's zero means something and lies outside its interval.
static bool differs_from_zero(const struct vw_ledger_score *score) {
    const struct vw_value_method *method = score ? vw_value_method_find(score->method) : NULL;
    return method && method->has_zero && (score->ci_low > 0 || score->ci_high < 0);
}

static bool helps(const struct vw_ledger_score *score) { return differs_from_zero(score) && score->value > 0; }

// Says why a photo is neither kept nor dropped: `by_credit` where the advice rests on credit.
static const char *why_unclear(const struct vw_results *results, const struct vw_ledger_score *score, bool by_credit) {
    if (!by_credit || !differs_from_zero(score)) return "within noise";
    if (vw_verdict_judge(&results->reconstruction) == VW_VERDICT_TOO_COARSE) return "too coarse to tell";
    return vw_ranking_agreement_is_low(&results->agreement) ? "other views may differ" : "negative credit";
}

static void judge(const struct vw_results *results, bool trusted, struct vw_photo_advice *photo) {
    bool lone = photo->marks & VW_MARK_LONE, best = trusted && photo->marks & VW_MARK_IRREPLACEABLE;
    photo->advice = photo->marks & VW_MARK_LOOK                     ? VW_ADVICE_LOOK
                    : lone                                          ? VW_ADVICE_KEEP
                    : trusted && (photo->marks & VW_MARK_REMOVABLE) ? VW_ADVICE_DROP
                    : best || (trusted && helps(photo->score))      ? VW_ADVICE_KEEP
                                                                    : VW_ADVICE_UNCLEAR;
    photo->word = vw_advice_words[photo->advice];
    switch (photo->advice) {
    case VW_ADVICE_LOOK: photo->reason = photo->description ? photo->finding->word : "fits badly"; break;
    case VW_ADVICE_DROP: photo->reason = "adds little"; break;
    case VW_ADVICE_KEEP: photo->reason = lone ? "lone view" : best ? "among the best" : "helps"; break;
    default: photo->reason = why_unclear(results, photo->score, !results->advice.basis);
    }
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static double find_score(const struct vw_results *results, uint32_t image_id, const char *method) {
    for (uint32_t i = 0; i < results->score_count; i++)
        if (results->scores[i].image_id == image_id && is_known(&results->scores[i], method))
            return results->scores[i].value;
    return NAN;
}

static enum vw_status list_photos(const struct vw_results *results, struct vw_advice *advice) {
    const struct vw_value_input *input = &results->input;
    const char *method = results->score_count ? vw_value_main_method(results->scores, results->score_count) : "";
    *advice = (struct vw_advice){.photos = vw_allocate(input->image_count, sizeof *advice->photos)};
    if (!advice->photos) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->image_count; i++) {
        const struct vw_photo_finding *finding = results->findings ? &results->findings[i] : NULL;
        if (strcmp(input->images[i].split, "train") != 0) continue;
        advice->photos[advice->count++] = (struct vw_photo_advice){
            .image = &input->images[i],
            .finding = finding,
            .description = finding && finding->word ? finding->description : NULL,
            .train_fit = find_score(results, input->images[i].image_id, "train_fit"),
            .quality = find_score(results, input->images[i].image_id, "quality"),
        };
    }
    for (uint32_t i = 0; i < results->score_count; i++) {
        const struct vw_ledger_score *score = &results->scores[i];
        struct vw_photo_advice *photo = is_known(score, method) ? find(advice, score->image_id) : NULL;
        if (photo) photo->score = score;
    }
    return VW_OK;
}

static enum vw_status summarise_worth(struct vw_results *results) {
    const struct vw_worth_input input = {.retrainings = results->retrainings,
                                         .retraining_count = results->retraining_count,
                                         .images = results->input.images,
                                         .image_count = results->input.image_count,
                                         .scores = results->scores,
                                         .score_count = results->score_count};
    return results->retraining_count ? vw_worth_summarise(&input, &results->worth) : VW_OK;
}

enum vw_status vw_results_advise(struct vw_results *results) {
    struct vw_advice *advice = &results->advice;
    enum vw_status status = summarise_worth(results);
    if (!status) status = list_photos(results, advice);
    if (!status) status = mark(results, advice);
    bool trusted = is_trusted(results, advice);
    for (uint32_t i = 0; !status && i < advice->count; i++) judge(results, trusted, &advice->photos[i]);
    return status;
}

#define OF_PHOTO(name, member)                                                                                         \
    { VW_CELL(name, struct vw_photo_advice, TEXT, member) }
#define OF_SCORE(name, kind, member)                                                                                   \
    {                                                                                                                  \
        VW_CELL_VIA(name, struct vw_photo_advice, score, kind, struct vw_ledger_score, member),                        \
            .left_out = VW_NOT_IN_JSON                                                                                 \
    }
#define OF_FINDING(name, member)                                                                                       \
    {                                                                                                                  \
        VW_CELL_VIA(name, struct vw_photo_advice, finding, REAL_OR_NULL, struct vw_photo_finding, member),             \
            .left_out = VW_NOT_IN_JSON                                                                                 \
    }
static const struct vw_column columns[] = {
    {VW_CELL_VIA("name", struct vw_photo_advice, image, TEXT, struct vw_ledger_image, name)},
    OF_PHOTO("advice", word),
    OF_PHOTO("reason", reason),
    OF_SCORE("score", REAL_OR_NULL, value),
    OF_SCORE("ci_low", REAL_OR_NULL, ci_low),
    OF_SCORE("ci_high", REAL_OR_NULL, ci_high),
    OF_SCORE("unit", TEXT, unit),
    OF_SCORE("method", TEXT, method),
    {VW_CELL("description", struct vw_photo_advice, TEXT_OR_NULL, description), .left_out = VW_NOT_IN_JSON},
    OF_FINDING("in_place", in_place),
    OF_FINDING("hidden_share", hidden),
    OF_FINDING("turned_deg", turned_deg),
    OF_FINDING("stops", stops),
    OF_FINDING("sharpness", sharpness),
    OF_FINDING("noise", noise),
    OF_FINDING("covered_share", covered),
    {VW_CELL("train_fit", struct vw_photo_advice, REAL_OR_NULL, train_fit), .left_out = VW_NOT_IN_JSON},
    {VW_CELL("quality", struct vw_photo_advice, REAL_OR_NULL, quality), .left_out = VW_NOT_IN_JSON},
};

struct vw_rows vw_advice_rows(const struct vw_advice *advice) {
    return VW_ROWS(columns, advice->photos, advice->count);
}
