// Detection of corrupted photos by scores, and the agreement of scores with those of another seed.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/full_agreement.h"
#include "value/evaluation/resampling.h"

static const char clean[] = "clean";

bool vw_photo_is_clean(const struct vw_evaluation *evaluation, uint32_t photo) {
    return !strcmp(evaluation->ground_truths[photo], clean);
}

typedef bool kind_filter(const void *context, const char *kind);

// Returns the share of pairs of a corrupted photo, of a kind that `counts` admits (NULL: of any), and a clean one of
// which the clean one has the higher score, ties as half. NaN and no pairs where either is missing.
static double auc_of(const struct vw_evaluation *evaluation, const double *scores, kind_filter *counts,
                     const void *context, uint32_t *pairs) {
    double won = 0;
    *pairs = 0;
    for (uint32_t corrupted = 0; corrupted < evaluation->photo_count; corrupted++) {
        if (vw_photo_is_clean(evaluation, corrupted) ||
            (counts && !counts(context, evaluation->ground_truths[corrupted])))
            continue;
        for (uint32_t other = 0; other < evaluation->photo_count; other++) {
            if (!vw_photo_is_clean(evaluation, other)) continue;
            if (isnan(scores[other]) || isnan(scores[corrupted])) return NAN;
            won += scores[other] > scores[corrupted] ? 1 : scores[other] == scores[corrupted] ? 0.5 : 0;
            ++*pairs;
        }
    }
    return *pairs ? won / *pairs : NAN;
}

// Counts how often the clean photo of each pair has the higher score, mean over the valued seeds;
// wins[corrupted][clean].
static void find_wins(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer, double *wins) {
    uint32_t photos = evaluation->photo_count, seeds = evaluation->seed_count;
    for (uint32_t i = 0; i < photos; i++)
        for (uint32_t j = 0; j < photos; j++) {
            double sum = 0;
            for (uint32_t seed = 0; seed < seeds; seed++) {
                double corrupted = scorer->scores[(size_t)seed * photos + i];
                double clean_one = scorer->scores[(size_t)seed * photos + j];
                sum += clean_one > corrupted ? 1 : clean_one == corrupted ? 0.5 : 0;
            }
            wins[(size_t)i * photos + j] = sum / seeds;
        }
}

// Computes the AUC over the photos drawn.
static double auc_drawn(const struct vw_evaluation *evaluation, const double *wins, const bool *counted,
                        const uint16_t *times) {
    double won = 0, pairs = 0;
    for (uint32_t i = 0; i < evaluation->photo_count; i++) {
        if (!counted[i] || !times[i]) continue;
        for (uint32_t j = 0; j < evaluation->photo_count; j++) {
            if (!vw_photo_is_clean(evaluation, j)) continue;
            double weight = (double)times[i] * times[j];
            won += weight * wins[(size_t)i * evaluation->photo_count + j];
            pairs += weight;
        }
    }
    return pairs > 0 ? won / pairs : NAN;
}

// Takes the interval over resampled photos.
static enum vw_status set_auc_interval(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                       kind_filter *counts, const void *context, struct vw_metric *row) {
    uint32_t photos = evaluation->photo_count;
    double *wins = vw_allocate((size_t)photos * photos + VW_RESAMPLES, sizeof *wins);
    bool *counted = vw_allocate(photos, sizeof *counted);
    uint16_t *times = vw_resamples_draw(photos);
    enum vw_status status = wins && counted && times ? VW_OK : VW_ERROR_MEMORY;
    if (!status) {
        double *drawn = wins + (size_t)photos * photos;
        find_wins(evaluation, scorer, wins);
        for (uint32_t i = 0; i < photos; i++)
            counted[i] =
                !vw_photo_is_clean(evaluation, i) && (!counts || counts(context, evaluation->ground_truths[i]));
        for (uint32_t r = 0; r < VW_RESAMPLES; r++)
            drawn[r] = auc_drawn(evaluation, wins, counted, times + (size_t)(1 + r) * photos);
        vw_resampling_interval(drawn, &row->ci_low, &row->ci_high);
    }
    free(wins);
    free(counted);
    free(times);
    return status;
}

static enum vw_status add_auc(const struct vw_evaluation *evaluation, kind_filter *counts, const void *context,
                              const char *name, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++) {
        const struct vw_scorer *scorer = &evaluation->scorers[i];
        struct vw_metric row = {.method = scorer->name, .ci_low = NAN, .ci_high = NAN};
        for (uint32_t seed = 0; seed < evaluation->seed_count; seed++) {
            const double *scores = scorer->scores + (size_t)seed * evaluation->photo_count;
            row.value += auc_of(evaluation, scores, counts, context, &row.count) / evaluation->seed_count;
        }
        if (isfinite(row.value)) status = set_auc_interval(evaluation, scorer, counts, context, &row);
        if (!status) status = vw_metrics_add(metrics, "auc", name, row);
    }
    return status;
}

static bool is_kind(const void *context, const char *kind) { return !strcmp(kind, context); }

// Returns whether no photo before this one has its label.
static bool is_first_of_kind(const struct vw_evaluation *evaluation, uint32_t photo) {
    for (uint32_t i = 0; i < photo; i++)
        if (!strcmp(evaluation->ground_truths[i], evaluation->ground_truths[photo])) return false;
    return true;
}

enum vw_status vw_evaluate_detection(const struct vw_evaluation *evaluation, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t photo = 0; !status && photo < evaluation->photo_count; photo++)
        if (!vw_photo_is_clean(evaluation, photo) && is_first_of_kind(evaluation, photo))
            status = add_auc(evaluation, is_kind, evaluation->ground_truths[photo], evaluation->ground_truths[photo],
                             metrics);
    return status ? status : add_auc(evaluation, NULL, NULL, "corrupted", metrics);
}

static bool is_harmful(const void *context, const char *kind) {
    const struct vw_metric *harm = vw_metrics_find(context, "harm", kind, "retrainings");
    return harm && harm->ci_low > 0;
}

enum vw_status vw_evaluate_harmful(const struct vw_evaluation *evaluation, struct vw_metrics *metrics) {
    return add_auc(evaluation, is_harmful, metrics, "harmful", metrics);
}

static enum vw_status add_agreement(const char *method, const char *over, double pearson, double spearman,
                                    uint32_t count, struct vw_metrics *metrics) {
    struct vw_metric row = {.method = method, .value = pearson, .ci_low = NAN, .ci_high = NAN, .count = count};
    enum vw_status status = vw_metrics_add(metrics, "seed_pearson", over, row);
    row.value = spearman;
    return status ? status : vw_metrics_add(metrics, "seed_spearman", over, row);
}

static enum vw_status evaluate_seeds_of(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                        const bool *is_clean, struct vw_metrics *metrics) {
    struct vw_full_agreement agreement;
    const double *values = agreement.values;
    enum vw_status status = vw_full_agreement_of_pair(scorer->scores, scorer->scores + evaluation->photo_count,
                                                      is_clean, evaluation->photo_count, &agreement);
    if (!status)
        status = add_agreement(scorer->name, "all", values[VW_AGREEMENT_PEARSON], values[VW_AGREEMENT_SPEARMAN],
                               agreement.photos, metrics);
    if (!status)
        status = add_agreement(scorer->name, clean, values[VW_AGREEMENT_CLEAN_PEARSON],
                               values[VW_AGREEMENT_CLEAN_SPEARMAN], agreement.clean, metrics);
    return status;
}

enum vw_status vw_evaluate_seeds(const struct vw_evaluation *evaluation, struct vw_metrics *metrics) {
    if (evaluation->seed_count < 2) return VW_OK;
    bool *is_clean = vw_allocate(evaluation->photo_count, sizeof *is_clean);
    enum vw_status status = is_clean ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t photo = 0; !status && photo < evaluation->photo_count; photo++)
        is_clean[photo] = vw_photo_is_clean(evaluation, photo);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        if (!evaluation->scorers[i].of_subsets) // which no valued seed changes
            status = evaluate_seeds_of(evaluation, &evaluation->scorers[i], is_clean, metrics);
    free(is_clean);
    return status;
}
