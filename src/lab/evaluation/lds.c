// The linear datamodeling score (LDS): how well scores predict trainings on subsets of the photos (Park et al. 2023).
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "lab/evaluation/evaluation.h"
#include "value/evaluation/outcomes.h"
#include "value/evaluation/resampling.h"
#include "value/evaluation/worth_regression.h"

// The target of the predictions: one outcome of the subsets of a range.
struct study {
    const struct vw_evaluation *evaluation;
    const struct vw_subsets *subsets;
    const char *group, *mean_group, *gain_group, *name;
    bool by_mean; // members' scores are averaged, not summed
    struct vw_outcomes outcomes;
    uint16_t *times;     // counts in the resamples
    double *predictions; // scratch: [kept]
    double *values;      // scratch: [1 + VW_RESAMPLES]
    double *reference;   // scratch, too: the LDS of the reference scorer; NULL without one
};

static double predict(const struct study *study, const double *scores, uint32_t kept) {
    const struct vw_subsets *subsets = study->subsets;
    uint32_t subset = study->outcomes.kept[kept], size = vw_subset_size(subsets, subset);
    const uint32_t *places = subsets->places + subsets->offsets[subset];
    double sum = 0;
    for (uint32_t i = 0; i < size; i++) sum += scores[places[i]];
    return study->by_mean ? sum / size : sum;
}

// Adds the LDS of one set of scores, in every resample, to `values`.
static enum vw_status add_lds(const struct study *study, const double *scores, double weight, double *values) {
    const struct vw_outcomes *outcomes = &study->outcomes;
    for (uint32_t i = 0; i < outcomes->count; i++) study->predictions[i] = predict(study, scores, i);
    return vw_resampled_spearman_add(study->predictions, outcomes->means, study->times, outcomes->count, weight,
                                     values);
}

// Computes the mean LDS of the valued seeds, in every resample.
static enum vw_status find_lds(const struct study *study, const struct vw_scorer *scorer, double *values) {
    uint32_t seeds = study->evaluation->seed_count;
    enum vw_status status = VW_OK;
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) values[r] = 0;
    for (uint32_t seed = 0; !status && seed < seeds; seed++)
        status = add_lds(study, scorer->scores + (size_t)seed * study->evaluation->photo_count, 1.0 / seeds, values);
    return status;
}

static enum vw_status add_row(const struct study *study, const char *group, const char *method, double *values,
                              struct vw_metrics *metrics) {
    struct vw_metric row = {.method = method, .value = values[0], .count = study->outcomes.count};
    vw_resampling_interval(values + 1, &row.ci_low, &row.ci_high);
    return vw_metrics_add(metrics, group, study->name, row);
}

// Adds the row of an LDS, and of its gain over the reference scorer.
static enum vw_status add_rows(const struct study *study, const char *method, double *values,
                               struct vw_metrics *metrics) {
    double *gains = vw_allocate(1 + VW_RESAMPLES, sizeof *gains);
    if (!gains) return VW_ERROR_MEMORY;
    for (uint32_t r = 0; study->reference && r <= VW_RESAMPLES; r++) gains[r] = values[r] - study->reference[r];
    enum vw_status status = add_row(study, study->group, method, values, metrics);
    if (!status && study->reference) status = add_row(study, study->gain_group, method, gains, metrics);
    free(gains);
    return status;
}

// ---- Scores ----

static enum vw_status evaluate_mean(const struct study *study, const struct vw_scorer *scorer,
                                    struct vw_metrics *metrics) {
    double *mean = vw_allocate(study->evaluation->photo_count, sizeof *mean);
    if (!mean) return VW_ERROR_MEMORY;
    vw_mean_over_seeds(study->evaluation, scorer->scores, mean);
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) study->values[r] = 0;
    enum vw_status status = add_lds(study, mean, 1, study->values);
    if (!status) status = add_row(study, study->mean_group, scorer->name, study->values, metrics);
    free(mean);
    return status;
}

static enum vw_status evaluate_scorers(struct study *study, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = study->evaluation;
    const struct vw_scorer *reference = vw_find_scorer(evaluation, vw_reference_scorer);
    enum vw_status status = VW_OK;
    if (reference) status = find_lds(study, reference, study->reference);
    else study->reference = NULL;
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++) {
        if (evaluation->scorers[i].of_subsets) continue;
        status = find_lds(study, &evaluation->scorers[i], study->values);
        if (!status) status = add_rows(study, evaluation->scorers[i].name, study->values, metrics);
        if (!status) status = evaluate_mean(study, &evaluation->scorers[i], metrics);
    }
    return status;
}

// Scores each subset as the fit without its fold predicts it.
static enum vw_status evaluate_worths(const struct study *study, const struct vw_worths *worths,
                                      struct vw_metrics *metrics) {
    const struct vw_outcomes *outcomes = &study->outcomes;
    for (uint32_t i = 0; i < outcomes->count; i++) study->predictions[i] = worths->predicted[outcomes->kept[i]];
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) study->values[r] = 0;
    enum vw_status status =
        vw_resampled_spearman_add(study->predictions, outcomes->means, study->times, outcomes->count, 1, study->values);
    return status ? status : add_rows(study, vw_subset_worth_name, study->values, metrics);
}

// Computes the LDS of random scores. With few photos it varies widely.
static enum vw_status evaluate_chance(const struct study *study, struct vw_metrics *metrics) {
    const struct vw_outcomes *outcomes = &study->outcomes;
    uint32_t photo_count = study->evaluation->photo_count;
    double *scores = vw_allocate(photo_count, sizeof *scores), *drawn = study->values + 1;
    enum vw_status status = scores ? VW_OK : VW_ERROR_MEMORY;
    study->values[0] = 0;
    for (uint32_t r = 0; !status && r < VW_RESAMPLES; r++) {
        for (uint32_t i = 0; i < photo_count; i++) scores[i] = vw_resampling_unit(r, i);
        for (uint32_t i = 0; i < outcomes->count; i++) study->predictions[i] = predict(study, scores, i);
        status = vw_spearman(study->predictions, outcomes->means, outcomes->count, &drawn[r]);
        study->values[0] += drawn[r] / VW_RESAMPLES;
    }
    free(scores);
    return status ? status : add_row(study, study->group, vw_chance_name, study->values, metrics);
}

// ---- All of it ----

static enum vw_status evaluate_study(struct study *study, const struct vw_worths *worths, struct vw_metrics *metrics) {
    const struct vw_outcomes *outcomes = &study->outcomes;
    study->times = vw_resamples_draw(outcomes->count);
    study->predictions = vw_allocate(outcomes->count, sizeof *study->predictions);
    study->values = vw_allocate(1 + VW_RESAMPLES, 2 * sizeof *study->values);
    if (!study->times || !study->predictions || !study->values) return VW_ERROR_MEMORY;
    study->reference = study->values + 1 + VW_RESAMPLES;
    enum vw_status status = evaluate_scorers(study, metrics);
    if (!status && worths) status = evaluate_worths(study, worths, metrics);
    if (!status)
        status = vw_evaluate_reliability(outcomes->values, outcomes->seed_count, outcomes->count, study->group,
                                         study->name, metrics);
    return status ? status : evaluate_chance(study, metrics);
}

static enum vw_status evaluate_range(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                     bool halves, enum vw_outcome outcome, const struct vw_worths *worths,
                                     struct vw_metrics *metrics) {
    struct study study = {.evaluation = evaluation,
                          .subsets = subsets,
                          .group = halves ? "lds" : "lds_sizes",
                          .mean_group = halves ? "lds_mean" : "lds_sizes_mean",
                          .gain_group = halves ? "lds_gain" : "lds_sizes_gain",
                          .name = vw_outcome_name(outcome),
                          .by_mean = !halves};
    enum vw_status status =
        vw_outcomes_of_subsets(subsets, halves ? subsets->halves : subsets->sizes, outcome, &study.outcomes);
    if (!status && study.outcomes.count > 2) status = evaluate_study(&study, worths, metrics);
    vw_outcomes_free(&study.outcomes);
    free(study.times);
    free(study.predictions);
    free(study.values);
    return status;
}

enum vw_status vw_evaluate_subsets(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                   const struct vw_worths *worths, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < VW_TRUTH_COUNT; i++) {
        const struct vw_worths *of_truth = worths ? &worths[i] : NULL;
        status = evaluate_range(evaluation, subsets, true, vw_truths[i], of_truth, metrics);
        if (!status) status = evaluate_range(evaluation, subsets, false, vw_truths[i], of_truth, metrics);
    }
    return status;
}
