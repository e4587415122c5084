#include "lab/evaluation/photo_values.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/memory.h"
#include "value/evaluation/resampling.h"

struct target {
    const struct vw_evaluation *evaluation;
    const struct vw_photo_values *values;
    char mean_group[VW_METRIC_BYTES], pearson_group[VW_METRIC_BYTES];
    uint16_t *times;   // how often each photo is in a resample
    double *truth;     // [photo]: mean over the retraining seeds
    double *scores;    // scratch: [photo]
    double *resampled; // scratch: [1 + VW_RESAMPLES]
};

static enum vw_status add_row(const struct target *target, const char *group, const char *method,
                              struct vw_metrics *metrics) {
    struct vw_metric row = {.method = method, .value = target->resampled[0], .count = target->evaluation->photo_count};
    vw_resampling_interval(target->resampled + 1, &row.ci_low, &row.ci_high);
    return vw_metrics_add(metrics, group, target->values->name, row);
}

static enum vw_status add_spearman(const struct target *target, const double *scores, double weight) {
    return vw_resampled_spearman_add(scores, target->truth, target->times, target->evaluation->photo_count, weight,
                                     target->resampled);
}

static void clear(const struct target *target) {
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) target->resampled[r] = 0;
}

static enum vw_status add_pearson(const struct target *target, const struct vw_scorer *scorer,
                                  struct vw_metrics *metrics) {
    uint32_t photos = target->evaluation->photo_count, seeds = target->evaluation->seed_count;
    struct vw_metric row = {.method = scorer->name, .ci_low = NAN, .ci_high = NAN, .count = photos};
    for (uint32_t seed = 0; seed < seeds; seed++)
        row.value += vw_pearson(scorer->scores + (size_t)seed * photos, target->truth, photos) / seeds;
    return vw_metrics_add(metrics, target->pearson_group, target->values->name, row);
}

static enum vw_status evaluate_scorer(const struct target *target, const struct vw_scorer *scorer,
                                      struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = target->evaluation;
    enum vw_status status = VW_OK;
    clear(target);
    for (uint32_t seed = 0; !status && seed < evaluation->seed_count; seed++)
        status =
            add_spearman(target, scorer->scores + (size_t)seed * evaluation->photo_count, 1.0 / evaluation->seed_count);
    if (!status) status = add_row(target, target->values->group, scorer->name, metrics);
    clear(target);
    vw_mean_over_seeds(evaluation, scorer->scores, target->scores);
    if (!status) status = add_spearman(target, target->scores, 1);
    if (!status) status = add_row(target, target->mean_group, scorer->name, metrics);
    return status ? status : add_pearson(target, scorer, metrics);
}

static enum vw_status evaluate_chance(const struct target *target, struct vw_metrics *metrics) {
    uint32_t photos = target->evaluation->photo_count;
    enum vw_status status = VW_OK;
    clear(target);
    for (uint32_t r = 0; !status && r < VW_RESAMPLES; r++) {
        for (uint32_t i = 0; i < photos; i++) target->scores[i] = vw_resampling_unit(r, i);
        status = vw_spearman(target->scores, target->truth, photos, &target->resampled[1 + r]);
        target->resampled[0] += target->resampled[1 + r] / VW_RESAMPLES;
    }
    return status ? status : add_row(target, target->values->group, vw_chance_name, metrics);
}

static enum vw_status evaluate_target(const struct target *target, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = target->evaluation;
    const struct vw_photo_values *values = target->values;
    enum vw_status status = VW_OK;
    if (!vw_all_finite(target->truth, evaluation->photo_count)) return VW_OK; // for instance without test photos
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        status = evaluate_scorer(target, &evaluation->scorers[i], metrics);
    if (!status)
        status = vw_evaluate_reliability(values->values, values->seed_count, evaluation->photo_count, values->group,
                                         values->name, metrics);
    return status ? status : evaluate_chance(target, metrics);
}

enum vw_status vw_evaluate_photo_values(const struct vw_evaluation *evaluation, const struct vw_photo_values *values,
                                        struct vw_metrics *metrics) {
    uint32_t photos = evaluation->photo_count;
    struct target target = {.evaluation = evaluation,
                            .values = values,
                            .times = vw_resamples_draw(photos),
                            .truth = vw_allocate(photos, sizeof *target.truth),
                            .scores = vw_allocate(photos, sizeof *target.scores),
                            .resampled = vw_allocate(1 + VW_RESAMPLES, sizeof *target.resampled)};
    bool enough = target.times && target.truth && target.scores && target.resampled;
    enum vw_status status = enough ? VW_OK : VW_ERROR_MEMORY;
    snprintf(target.mean_group, sizeof target.mean_group, "%s_mean", values->group);
    snprintf(target.pearson_group, sizeof target.pearson_group, "%s_pearson", values->group);
    if (!status) {
        vw_mean_of_rows(values->values, values->seed_count, photos, target.truth);
        status = evaluate_target(&target, metrics);
    }
    free(target.times);
    free(target.truth);
    free(target.scores);
    free(target.resampled);
    return status;
}
