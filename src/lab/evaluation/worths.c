// Metrics from the worths of photos: harm by kind of corruption, signs of scores, and their power to predict.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "lab/evaluation/evaluation.h"
#include "value/evaluation/resampling.h"
#include "value/evaluation/worth_regression.h"

const char vw_subset_worth_name[] = "subset_worth";

// ---- Harm ----

// Returns the mean worth of the clean photos less that of the photos of a kind.
static double harm_of(const struct vw_evaluation *evaluation, const char *kind, const double *worths) {
    double clean = 0, corrupted = 0;
    uint32_t clean_count = 0, corrupted_count = 0;
    for (uint32_t photo = 0; photo < evaluation->photo_count; photo++) {
        bool is_clean = vw_photo_is_clean(evaluation, photo);
        if (!is_clean && strcmp(evaluation->ground_truths[photo], kind) != 0) continue;
        *(is_clean ? &clean : &corrupted) += worths[photo];
        ++*(is_clean ? &clean_count : &corrupted_count);
    }
    return clean / clean_count - corrupted / corrupted_count;
}

static enum vw_status add_harm(const struct vw_evaluation *evaluation, const struct vw_worths *worths, const char *kind,
                               double *resampled, struct vw_metrics *metrics) {
    static const char retrainings_name[] = "retrainings";
    if (vw_metrics_find(metrics, "harm", kind, retrainings_name)) return VW_OK;
    struct vw_metric row = {.method = retrainings_name, .value = harm_of(evaluation, kind, worths->values)};
    for (uint32_t r = 0; r < VW_RESAMPLES; r++)
        resampled[r] = harm_of(evaluation, kind, worths->resampled + (size_t)(1 + r) * worths->photo_count);
    for (uint32_t photo = 0; photo < evaluation->photo_count; photo++)
        row.count += !strcmp(evaluation->ground_truths[photo], kind);
    vw_resampling_interval(resampled, &row.ci_low, &row.ci_high);
    return vw_metrics_add(metrics, "harm", kind, row);
}

enum vw_status vw_evaluate_harm(const struct vw_evaluation *evaluation, const struct vw_worths *worths,
                                struct vw_metrics *metrics) {
    double *resampled = vw_allocate(VW_RESAMPLES, sizeof *resampled);
    enum vw_status status = resampled ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t photo = 0; !status && photo < evaluation->photo_count; photo++)
        if (!vw_photo_is_clean(evaluation, photo))
            status = add_harm(evaluation, worths, evaluation->ground_truths[photo], resampled, metrics);
    free(resampled);
    return status;
}

// ---- Signs ----

static int known_sign(const struct vw_worths *worths, uint32_t photo) {
    return worths->ci_low[photo] > 0 ? 1 : worths->ci_high[photo] < 0 ? -1 : 0; // 0 also where they are NaN
}

// Photos, over all valued seeds, by the known sign of their worth (-1, 0, 1) and whether their score has it.
struct sign_counts {
    uint32_t harmful, harmful_found, helpful, helpful_found, called_harmful;
};

static struct sign_counts count_signs(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                      const struct vw_worths *worths) {
    struct sign_counts counts = {0};
    for (uint32_t i = 0; i < evaluation->seed_count * evaluation->photo_count; i++) {
        int sign = known_sign(worths, i % evaluation->photo_count);
        counts.harmful += sign < 0;
        counts.helpful += sign > 0;
        counts.called_harmful += scorer->scores[i] < 0;
        counts.harmful_found += sign < 0 && scorer->scores[i] < 0;
        counts.helpful_found += sign > 0 && scorer->scores[i] > 0;
    }
    return counts;
}

static enum vw_status add_share(const char *group, const char *name, const char *method, uint32_t part, uint32_t whole,
                                uint32_t count, struct vw_metrics *metrics) {
    return vw_metrics_add(metrics, group, name,
                          (struct vw_metric){.method = method,
                                             .value = whole ? (double)part / whole : NAN,
                                             .ci_low = NAN,
                                             .ci_high = NAN,
                                             .count = count});
}

enum vw_status vw_evaluate_signs(const struct vw_evaluation *evaluation, const struct vw_worths *worths,
                                 const char *name, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++) {
        const struct vw_scorer *scorer = &evaluation->scorers[i];
        if (!scorer->has_sign) continue;
        struct sign_counts counts = count_signs(evaluation, scorer, worths);
        uint32_t seeds = evaluation->seed_count, known = counts.harmful + counts.helpful;
        status = add_share("sign_accuracy", name, scorer->name, counts.harmful_found + counts.helpful_found, known,
                           known / seeds, metrics);
        if (!status)
            status = add_share("harmful_precision", name, scorer->name, counts.harmful_found, counts.called_harmful,
                               counts.called_harmful, metrics);
        if (!status)
            status = add_share("harmful_recall", name, scorer->name, counts.harmful_found, counts.harmful,
                               counts.harmful / seeds, metrics);
        if (!status)
            status = add_share("helpful_recall", name, scorer->name, counts.helpful_found, counts.helpful,
                               counts.helpful / seeds, metrics);
    }
    return status;
}

// ---- Accuracy ----

enum vw_status vw_evaluate_worths(const struct vw_worths *worths, const char *name, struct vw_metrics *metrics) {
    struct vw_metric row = {.method = vw_subset_worth_name,
                            .value = worths->pearson,
                            .ci_low = NAN,
                            .ci_high = NAN,
                            .count = worths->count};
    enum vw_status status = vw_metrics_add(metrics, "left_out_pearson", name, row);
    row.value = worths->r2;
    return status ? status : vw_metrics_add(metrics, "left_out_r2", name, row);
}
