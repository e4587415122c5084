// Leave-one-out: trainings without each photo in turn, as a truth that scores should agree with.
#include "value/evaluation/leave_one_out.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "value/evaluation/resampling.h"

static const char group[] = "leave_one_out", mean_group[] = "leave_one_out_mean";

// ---- Trainings ----

// Training on all photos but one, whose place is left_out; on all of them when it is the number of photos.
static struct vw_retrain_params retraining_without(const struct vw_evaluation *evaluation, uint32_t left_out,
                                                   uint64_t seed, uint32_t *views) {
    struct vw_retrain_params retraining = {.views = views, .seed = seed};
    for (uint32_t i = 0; i < evaluation->photo_count; i++)
        if (i != left_out) views[retraining.view_count++] = evaluation->photos[i];
    return retraining;
}

static void take_results(const struct vw_retrain_result *results, struct vw_left_out *left_out) {
    uint32_t photos = left_out->photo_count, of_seed = photos + 1;
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++)
        for (uint32_t seed = 0; seed < left_out->seed_count; seed++) {
            const struct vw_retrain_result *all = results + (size_t)seed * of_seed;
            for (uint32_t i = 0; i < photos; i++)
                left_out->worths[truth][(size_t)seed * photos + i] =
                    vw_quality_of(all, vw_truths[truth]) - vw_quality_of(all + 1 + i, vw_truths[truth]);
        }
}

enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint32_t seed_count, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, struct vw_left_out *left_out) {
    uint32_t photos = evaluation->photo_count, of_seed = photos + 1, count = seed_count * of_seed;
    uint32_t *views = vw_allocate((size_t)count * photos, sizeof *views);
    struct vw_retrain_params *retrainings = vw_allocate(count, sizeof *retrainings);
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status = views && retrainings && results ? VW_OK : VW_ERROR_MEMORY;
    *left_out = (struct vw_left_out){.seed_count = seed_count, .photo_count = photos};
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++)
        if (!(left_out->worths[truth] = vw_allocate((size_t)seed_count * photos, sizeof(double))))
            status = VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++) // of each seed first that on all photos
        retrainings[i] = retraining_without(evaluation, i % of_seed ? i % of_seed - 1 : photos,
                                            first_seed + i / of_seed, views + (size_t)i * photos);
    if (!status) status = retrain(context, retrainings, count, results);
    if (!status) take_results(results, left_out);
    free(views);
    free(retrainings);
    free(results);
    return status;
}

void vw_left_out_free(struct vw_left_out *left_out) {
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++) free(left_out->worths[truth]);
}

// ---- Agreement with scores ----

// What scores are held against: the mean worths of one truth.
struct target {
    const struct vw_evaluation *evaluation;
    const double *worths;
    const uint16_t *times;
    const char *name;
    double *values; // scratch: [1 + VW_RESAMPLES]
};

static enum vw_status add_row(const struct target *target, const char *of_group, const char *method,
                              struct vw_metrics *metrics) {
    struct vw_metric row = {.method = method, .value = target->values[0], .count = target->evaluation->photo_count};
    vw_resampling_interval(target->values + 1, &row.ci_low, &row.ci_high);
    return vw_metrics_add(metrics, of_group, target->name, row);
}

static enum vw_status add_spearman(const struct target *target, const double *scores, double weight) {
    return vw_resampled_spearman_add(scores, target->worths, target->times, target->evaluation->photo_count, weight,
                                     target->values);
}

static void clear(const struct target *target) {
    for (uint32_t r = 0; r <= VW_RESAMPLES; r++) target->values[r] = 0;
}

static enum vw_status evaluate_scorer(const struct target *target, const struct vw_scorer *scorer, double *mean,
                                      struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = target->evaluation;
    enum vw_status status = VW_OK;
    clear(target);
    for (uint32_t seed = 0; !status && seed < evaluation->seed_count; seed++)
        status =
            add_spearman(target, scorer->scores + (size_t)seed * evaluation->photo_count, 1.0 / evaluation->seed_count);
    if (!status) status = add_row(target, group, scorer->name, metrics);
    clear(target);
    vw_mean_over_seeds(evaluation, scorer->scores, mean);
    if (!status) status = add_spearman(target, mean, 1);
    return status ? status : add_row(target, mean_group, scorer->name, metrics);
}

static enum vw_status evaluate_chance(const struct target *target, double *scores, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    clear(target);
    for (uint32_t r = 0; !status && r < VW_RESAMPLES; r++) {
        for (uint32_t i = 0; i < target->evaluation->photo_count; i++) scores[i] = vw_resampling_unit(r, i);
        status = vw_spearman(scores, target->worths, target->evaluation->photo_count, &target->values[1 + r]);
        target->values[0] += target->values[1 + r] / VW_RESAMPLES;
    }
    return status ? status : add_row(target, group, vw_chance_name, metrics);
}

static enum vw_status evaluate_target(const struct target *target, double *scratch, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < target->evaluation->scorer_count; i++)
        status = evaluate_scorer(target, &target->evaluation->scorers[i], scratch, metrics);
    return status ? status : evaluate_chance(target, scratch, metrics);
}

enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const struct vw_left_out *left_out,
                                         struct vw_metrics *metrics) {
    uint32_t photos = evaluation->photo_count;
    uint16_t *times = vw_resamples_draw(photos);
    double *means = vw_allocate(photos, 2 * sizeof *means), *values = vw_allocate(1 + VW_RESAMPLES, sizeof *values);
    enum vw_status status = times && means && values ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++) {
        const struct target target = {evaluation, means, times, vw_quality_name(vw_truths[truth]), values};
        vw_mean_of_rows(left_out->worths[truth], left_out->seed_count, photos, means);
        if (!vw_all_finite(means, photos)) continue; // for instance without test photos
        status = evaluate_target(&target, means + photos, metrics);
        if (!status)
            status = vw_evaluate_reliability(left_out->worths[truth], left_out->seed_count, photos, group, target.name,
                                             metrics);
    }
    free(times);
    free(means);
    free(values);
    return status;
}
