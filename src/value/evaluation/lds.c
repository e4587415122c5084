// The linear datamodeling score (LDS): how well scores predict trainings on subsets of the photos (Park et al. 2023).
// And the harm that each kind of corruption does in these trainings.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "value/evaluation/evaluation.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

static const uint64_t RESAMPLING_SEED = 0x626f6f74; // of no training
enum { RESAMPLES = 1000 };
static const double TAIL = 0.025;

static const char noise_ceiling_name[] = "noise ceiling", chance_name[] = "chance", agreement_name[] = "outcomes",
                  retrainings_name[] = "retrainings";

// A quality of retrainings that scores should predict.
struct target {
    const char *name;
    size_t offset;
};
static const struct target targets[] = {
    {"val_psnr", offsetof(struct vw_retrain_result, val_psnr)},
    {"test_psnr", offsetof(struct vw_retrain_result, test_psnr)},
};

// The subsets whose trainings have a value, and these values.
struct study {
    const struct vw_evaluation *evaluation;
    const struct vw_subsets *subsets;
    uint32_t *kept, count; // which of the subsets
    double *outcomes;      // [seed][kept]
    double *means;         // [kept]
    uint16_t *times;       // [resample][kept]: how often it was drawn; resample 0 is the study itself
    struct vw_ordered *ordered_means;
    double *ranks; // scratch: [2][kept]
};

static double outcome_of(const struct vw_subsets *subsets, const struct target *target, uint32_t subset,
                         uint32_t seed) {
    const struct vw_retrain_result *result = &subsets->results[(size_t)subset * VW_SUBSET_SEEDS + seed];
    return *(const double *)((const char *)result + target->offset);
}

static void close_study(struct study *study) {
    free(study->kept);
    free(study->outcomes);
    free(study->times);
    free(study->ordered_means);
}

static void keep_subsets(const struct target *target, struct study *study) {
    const struct vw_subsets *subsets = study->subsets;
    for (uint32_t i = 0; i < subsets->count; i++) {
        double mean = 0;
        for (uint32_t seed = 0; seed < VW_SUBSET_SEEDS; seed++)
            mean += outcome_of(subsets, target, i, seed) / VW_SUBSET_SEEDS;
        if (!isfinite(mean)) continue;
        for (uint32_t seed = 0; seed < VW_SUBSET_SEEDS; seed++)
            study->outcomes[(size_t)seed * subsets->count + study->count] = outcome_of(subsets, target, i, seed);
        study->means[study->count] = mean;
        study->kept[study->count++] = i;
    }
}

static void draw_resamples(struct study *study) {
    for (uint32_t r = 0; r <= RESAMPLES; r++)
        for (uint32_t i = 0; i < study->count; i++) {
            uint32_t words[4];
            vw_random_words(RESAMPLING_SEED, VW_RANDOM_ORDER, r, i, 0, words);
            study->times[(size_t)r * study->count + (r ? vw_random_below(words[0], study->count) : i)]++;
        }
}

static enum vw_status open_study(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                 const struct target *target, struct study *study) {
    size_t most = subsets->count;
    *study = (struct study){.evaluation = evaluation, .subsets = subsets};
    study->kept = vw_allocate(most, sizeof *study->kept);
    study->times = vw_allocate((1 + RESAMPLES) * most, sizeof *study->times);
    study->ordered_means = vw_allocate(most, sizeof *study->ordered_means);
    study->outcomes = vw_allocate(most, (VW_SUBSET_SEEDS + 3) * sizeof *study->outcomes);
    if (!study->kept || !study->times || !study->ordered_means || !study->outcomes) return VW_ERROR_MEMORY;
    study->means = study->outcomes + VW_SUBSET_SEEDS * most;
    study->ranks = study->means + most;
    keep_subsets(target, study);
    draw_resamples(study);
    vw_order(study->means, study->count, study->ordered_means);
    return VW_OK;
}

static double sum_over_subset(const struct study *study, const double *scores, uint32_t kept) {
    const uint32_t *places = study->subsets->places + (size_t)study->kept[kept] * study->subsets->size;
    double sum = 0;
    for (uint32_t i = 0; i < study->subsets->size; i++) sum += scores[places[i]];
    return sum;
}

// Sets low and high to the middle 95 % of a statistic's resamples; those that have no value are left out.
static void set_interval(double *resampled, struct vw_metric *row) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < RESAMPLES; i++)
        if (isfinite(resampled[i])) resampled[count++] = resampled[i];
    row->ci_low = row->ci_high = NAN;
    if (!count) return;
    vw_sort(resampled, count);
    row->ci_low = vw_quantile_of_sorted(resampled, count, TAIL);
    row->ci_high = vw_quantile_of_sorted(resampled, count, 1 - TAIL);
}

// ---- Scores ----

// The rank of each value among those drawn; equal ones share the mean of their ranks.
static void rank_drawn(const struct vw_ordered *ordered, const uint16_t *times, uint32_t count, double *ranks) {
    double below = 0;
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        double level = times[ordered[begin].place];
        for (end = begin + 1; end < count && ordered[end].value == ordered[begin].value; end++)
            level += times[ordered[end].place];
        for (uint32_t i = begin; i < end; i++) ranks[ordered[i].place] = below + 0.5 * (level + 1);
        below += level;
    }
}

// Spearman's correlation over the subsets drawn: Pearson's of their ranks, each as often as it was drawn. The mean of
// all ranks is known.
static double correlate_drawn(const double *a, const double *b, const uint16_t *times, uint32_t count) {
    double mean = 0.5 * (count + 1), aa = 0, bb = 0, ab = 0;
    for (uint32_t i = 0; i < count; i++) {
        aa += times[i] * (a[i] - mean) * (a[i] - mean);
        bb += times[i] * (b[i] - mean) * (b[i] - mean);
        ab += times[i] * (a[i] - mean) * (b[i] - mean);
    }
    return aa > 0 && bb > 0 ? ab / (sqrt(aa) * sqrt(bb)) : NAN;
}

// The statistic of every resample (values[0]: of the study itself): the mean over the valued seeds.
static enum vw_status resample_method(const struct study *study, const struct vw_scorer *scorer,
                                      double values[1 + RESAMPLES]) {
    double *sums = vw_allocate(study->count, sizeof *sums);
    struct vw_ordered *ordered = vw_allocate(study->count, sizeof *ordered);
    double *ranks = study->ranks, *mean_ranks = ranks + study->subsets->count;
    enum vw_status status = sums && ordered ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t r = 0; r <= RESAMPLES; r++) values[r] = 0;
    for (uint32_t seed = 0; !status && seed < study->evaluation->seed_count; seed++) {
        const double *scores = scorer->scores + (size_t)seed * study->evaluation->photo_count;
        double sum = 0;
        for (uint32_t i = 0; i < study->count; i++) sum += sums[i] = sum_over_subset(study, scores, i);
        if (!isfinite(sum)) { // a photo lacks a score
            for (uint32_t r = 0; r <= RESAMPLES; r++) values[r] = NAN;
            break;
        }
        vw_order(sums, study->count, ordered);
        for (uint32_t r = 0; r <= RESAMPLES; r++) {
            const uint16_t *times = study->times + (size_t)r * study->count;
            rank_drawn(ordered, times, study->count, ranks);
            rank_drawn(study->ordered_means, times, study->count, mean_ranks);
            values[r] += correlate_drawn(ranks, mean_ranks, times, study->count) / study->evaluation->seed_count;
        }
    }
    free(sums);
    free(ordered);
    return status;
}

static enum vw_status evaluate_method(const struct study *study, const struct target *target,
                                      const struct vw_scorer *scorer, const double *reference, double *values,
                                      struct vw_metrics *metrics) {
    struct vw_metric row = {.method = scorer->name, .count = study->count};
    enum vw_status status = resample_method(study, scorer, values);
    if (status) return status;
    double gain = reference ? values[0] - reference[0] : NAN;
    double *gains = reference ? vw_allocate(RESAMPLES, sizeof *gains) : NULL;
    if (reference && !gains) return VW_ERROR_MEMORY;
    for (uint32_t r = 0; gains && r < RESAMPLES; r++) gains[r] = values[1 + r] - reference[1 + r];
    row.value = values[0];
    set_interval(values + 1, &row);
    status = vw_metrics_add(metrics, "lds", target->name, row);
    row.value = gain;
    if (gains) set_interval(gains, &row);
    if (!status && gains) status = vw_metrics_add(metrics, "lds_gain", target->name, row);
    free(gains);
    return status;
}

static const struct vw_scorer *find_reference(const struct vw_evaluation *evaluation) {
    for (uint32_t i = 0; i < evaluation->scorer_count; i++)
        if (!strcmp(evaluation->scorers[i].name, vw_reference_scorer)) return &evaluation->scorers[i];
    return NULL;
}

static enum vw_status evaluate_methods(const struct study *study, const struct target *target,
                                       struct vw_metrics *metrics) {
    const struct vw_scorer *found = find_reference(study->evaluation);
    double *values = vw_allocate(2 * (1 + RESAMPLES), sizeof *values), *reference = NULL;
    enum vw_status status = values ? VW_OK : VW_ERROR_MEMORY;
    if (!status && found) {
        reference = values + 1 + RESAMPLES;
        status = resample_method(study, found, reference);
    }
    for (uint32_t i = 0; !status && i < study->evaluation->scorer_count; i++)
        status = evaluate_method(study, target, &study->evaluation->scorers[i], reference, values, metrics);
    free(values);
    return status;
}

static enum vw_status add_noise_ceiling(const struct study *study, const struct target *target,
                                        struct vw_metrics *metrics) {
    const double *first = study->outcomes, *second = first + study->subsets->count;
    double agreement = NAN;
    enum vw_status status = vw_spearman(first, second, study->count, &agreement); // as the LDS that lie below it
    struct vw_metric row = {
        .method = agreement_name, .value = agreement, .ci_low = NAN, .ci_high = NAN, .count = study->count};
    if (!status) status = vw_metrics_add(metrics, "agreement", target->name, row);
    row.method = noise_ceiling_name;
    row.value = agreement > 0 ? sqrt(2 * agreement / (1 + agreement)) : NAN;
    return status ? status : vw_metrics_add(metrics, "lds", target->name, row);
}

// The LDS of random scores. With few photos it varies widely.
static enum vw_status add_chance(const struct study *study, const struct target *target, struct vw_metrics *metrics) {
    uint32_t photo_count = study->evaluation->photo_count;
    double *scores = vw_allocate(photo_count, sizeof *scores), *sums = vw_allocate(study->count, sizeof *sums);
    double *drawn = vw_allocate(RESAMPLES, sizeof *drawn);
    enum vw_status status = scores && sums && drawn ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t r = 0; !status && r < RESAMPLES; r++) {
        for (uint32_t i = 0; i < photo_count; i++) {
            uint32_t words[4];
            vw_random_words(RESAMPLING_SEED, VW_RANDOM_ORDER, r, i, 1, words);
            scores[i] = vw_random_unit(words[0]);
        }
        for (uint32_t i = 0; i < study->count; i++) sums[i] = sum_over_subset(study, scores, i);
        status = vw_spearman(sums, study->means, study->count, &drawn[r]);
    }
    struct vw_metric row = {.method = chance_name, .count = study->count};
    for (uint32_t r = 0; !status && r < RESAMPLES; r++) row.value += drawn[r] / RESAMPLES;
    if (!status) set_interval(drawn, &row);
    if (!status) status = vw_metrics_add(metrics, "lds", target->name, row);
    free(scores);
    free(sums);
    free(drawn);
    return status;
}

enum vw_status vw_evaluate_subsets(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                   struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; !status && i < VW_ARRAY_COUNT(targets); i++) {
        struct study study;
        status = open_study(evaluation, subsets, &targets[i], &study);
        if (!status && study.count > 2) status = evaluate_methods(&study, &targets[i], metrics);
        if (!status && study.count > 2) status = add_noise_ceiling(&study, &targets[i], metrics);
        if (!status && study.count > 2) status = add_chance(&study, &targets[i], metrics);
        close_study(&study);
    }
    return status;
}

// ---- Harm ----

static bool has_photo(const struct study *study, uint32_t kept, uint32_t photo) {
    const uint32_t *places = study->subsets->places + (size_t)study->kept[kept] * study->subsets->size;
    for (uint32_t i = 0; i < study->subsets->size; i++)
        if (places[i] == photo) return true;
    return false;
}

// What every photo adds to a training, from the subsets drawn: the mean with it less the mean without it. In an
// additive game this is the photo's worth, times a factor near 1 plus a constant near 0 that are the same for all
// photos, since a subset with one photo has one less of the others.
static void find_worths(const struct study *study, const bool *has, const uint16_t *times, double *worths) {
    for (uint32_t photo = 0; photo < study->evaluation->photo_count; photo++) {
        double sums[2] = {0}, counts[2] = {0};
        for (uint32_t i = 0; i < study->count; i++) {
            bool with = has[(size_t)i * study->evaluation->photo_count + photo];
            sums[with] += times[i] * study->means[i];
            counts[with] += times[i];
        }
        worths[photo] = sums[1] / counts[1] - sums[0] / counts[0]; // NaN where a resample has only one of the two
    }
}

// The mean worth of the clean photos less that of the photos of a kind.
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

static enum vw_status add_harm(struct study *study, const char *kind, const double *worths, double *resampled,
                               struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = study->evaluation;
    if (vw_metrics_find(metrics, "harm", kind, retrainings_name)) return VW_OK;
    struct vw_metric row = {.method = retrainings_name, .value = harm_of(evaluation, kind, worths)};
    for (uint32_t r = 0; r < RESAMPLES; r++)
        resampled[r] = harm_of(evaluation, kind, worths + (size_t)(1 + r) * evaluation->photo_count);
    for (uint32_t photo = 0; photo < evaluation->photo_count; photo++)
        row.count += !strcmp(evaluation->ground_truths[photo], kind);
    set_interval(resampled, &row);
    return vw_metrics_add(metrics, "harm", kind, row);
}

static enum vw_status evaluate_harm(struct study *study, bool *has, double *worths, double *resampled,
                                    struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = study->evaluation;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < study->count; i++)
        for (uint32_t photo = 0; photo < evaluation->photo_count; photo++)
            has[(size_t)i * evaluation->photo_count + photo] = has_photo(study, i, photo);
    for (uint32_t r = 0; r <= RESAMPLES; r++)
        find_worths(study, has, study->times + (size_t)r * study->count, worths + (size_t)r * evaluation->photo_count);
    for (uint32_t photo = 0; !status && photo < evaluation->photo_count; photo++)
        if (!vw_photo_is_clean(evaluation, photo))
            status = add_harm(study, evaluation->ground_truths[photo], worths, resampled, metrics);
    return status;
}

enum vw_status vw_evaluate_harm(const struct vw_evaluation *evaluation, const struct vw_subsets *subsets,
                                struct vw_metrics *metrics) {
    struct study study;
    enum vw_status status = open_study(evaluation, subsets, &targets[0], &study);
    bool *has = vw_allocate((size_t)study.count * evaluation->photo_count, sizeof *has);
    double *worths = vw_allocate((1 + (size_t)RESAMPLES) * evaluation->photo_count, sizeof *worths);
    double *resampled = vw_allocate(RESAMPLES, sizeof *resampled);
    if (!status && (!has || !worths || !resampled)) status = VW_ERROR_MEMORY;
    if (!status && study.count) status = evaluate_harm(&study, has, worths, resampled, metrics);
    free(has);
    free(worths);
    free(resampled);
    close_study(&study);
    return status;
}
