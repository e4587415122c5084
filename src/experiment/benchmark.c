#include "experiment/benchmark.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "run/out_lock.h"
#include "base/csv.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/word_list.h"
#include "experiment/retrain.h"
#include "experiment/scorers.h"
#include "experiment/seed_runs.h"

// A benchmark while it is made.
struct work {
    const struct vw_benchmark_params *params;
    struct vw_out_lock *lock; // of OUT
    struct vw_session session;
    struct vw_retrainer retrainer;
    struct vw_scorers scorers;
    struct vw_subsets subsets;
};

// Retrainings that evaluate scores have other seeds than the valued runs: a shared initialisation would raise their
// agreement. Leave-one-out is both evaluated and compared with, so it has seeds of its own.
enum { EVALUATION_SEED = VW_SUBSET_SEEDS, LEAVE_ONE_OUT_SEED = 2 * VW_SUBSET_SEEDS, SEED_COUNT = 3 * VW_SUBSET_SEEDS };

static uint64_t evaluation_seed(const struct work *work) { return work->params->common.config->seed + EVALUATION_SEED; }

// ---- Curves ----

static enum vw_status check_curves(const struct vw_benchmark_params *params) {
    const char *rest = params->curves == VW_CURVES_LISTED ? params->curve_scorers : NULL;
    enum vw_status status = VW_OK;
    struct vw_word word;
    while (!status && vw_word_list_next(&rest, &word)) {
        char *name = vw_format_text("%.*s", (int)word.length, word.text);
        if (!name) return VW_ERROR_MEMORY;
        if (!vw_scorer_exists(name))
            status = vw_fail(VW_ERROR_USAGE,
                             "--curves: \"%s\" is no method; take all, none, or names as scores.csv has them", name);
        free(name);
    }
    return status;
}

static bool is_wanted(const struct vw_benchmark_params *params, const char *scorer) {
    switch (params->curves) {
    case VW_CURVES_DEFAULT: return !strcmp(scorer, vw_reference_scorer) || !strcmp(scorer, "ground_truth");
    case VW_CURVES_NONE: return false;
    case VW_CURVES_ALL: return true;
    case VW_CURVES_LISTED: return vw_word_list_has(params->curve_scorers, scorer);
    }
    return false;
}

// Equal scores give no order in which to remove photos. Random orders have a curve of their own.
static bool has_curve(const struct work *work, const struct vw_scorer *scorer) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    bool differ = false;
    for (size_t i = 1; i < (size_t)evaluation->seed_count * evaluation->photo_count; i++)
        differ |= scorer->scores[i] != scorer->scores[0];
    return differ && strcmp(scorer->name, "random") != 0 && is_wanted(work->params, scorer->name);
}

static enum vw_status evaluate_curves(struct work *work, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    uint64_t seed = evaluation_seed(work);
    if (work->params->curves == VW_CURVES_NONE) return VW_OK;
    enum vw_status status = vw_evaluate_random_curve(evaluation, seed, vw_retrain, &work->retrainer, metrics);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        if (has_curve(work, &evaluation->scorers[i]))
            status =
                vw_evaluate_curve(evaluation, &evaluation->scorers[i], seed, vw_retrain, &work->retrainer, metrics);
    return status;
}

// ---- Retrainings ----

static uint64_t count_retrainings(const struct work *work) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    uint32_t curves = work->params->curves == VW_CURVES_NONE ? 0 : VW_CURVE_ORDERS;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++) curves += has_curve(work, &evaluation->scorers[i]);
    uint64_t count = 1 + (uint64_t)work->subsets.count * VW_SUBSET_SEEDS + (uint64_t)curves * vw_curve_trainings();
    if (work->params->leave_one_out) count += (uint64_t)evaluation->seed_count * (evaluation->photo_count + 1);
    return count;
}

// The baseline of removals, and the time of a training.
static enum vw_status train_on_all(struct work *work, double *seconds) {
    struct vw_retrainer *retrainer = &work->retrainer;
    const struct vw_retrain_params retraining = {
        .views = retrainer->train_views, .view_count = retrainer->train_count, .seed = evaluation_seed(work)};
    struct vw_retrain_result result;
    enum vw_status status = vw_retrain(retrainer, &retraining, 1, &result);
    if (!status) *seconds = result.seconds;
    return status;
}

static enum vw_status leave_one_out(struct work *work) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    if (!work->params->leave_one_out) return VW_OK;
    double *scores = vw_scorers_add(&work->scorers, vw_leave_one_out_scorer, evaluation->photo_count + 1);
    if (!scores) return VW_ERROR_MEMORY;
    uint64_t first_seed = work->params->common.config->seed + LEAVE_ONE_OUT_SEED;
    return vw_leave_one_out(evaluation, first_seed, vw_retrain, &work->retrainer, scores);
}

// ---- Metrics ----

static enum vw_status add_costs(const struct vw_scorers *scorers, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        status = vw_metrics_add(metrics, "cost", "trainings",
                                (struct vw_metric){.method = evaluation->scorers[i].name,
                                                   .value = scorers->trainings[i],
                                                   .ci_low = NAN,
                                                   .ci_high = NAN,
                                                   .count = evaluation->seed_count});
    return status;
}

static enum vw_status evaluate(struct work *work, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    enum vw_status status = vw_evaluate_detection(evaluation, metrics);
    if (!status) status = vw_evaluate_seeds(evaluation, metrics);
    if (!status) status = vw_evaluate_subsets(evaluation, &work->subsets, metrics);
    if (!status) status = vw_evaluate_harm(evaluation, &work->subsets, metrics);
    if (!status) status = vw_evaluate_harmful(evaluation, metrics);
    if (!status && work->params->leave_one_out)
        status =
            vw_evaluate_leave_one_out(evaluation, evaluation->scorers[evaluation->scorer_count - 1].scores, metrics);
    if (!status) status = evaluate_curves(work, metrics);
    return status ? status : add_costs(&work->scorers, metrics);
}

// Metrics of the same photos, config and number of subsets replace one another.
static enum vw_status record_metrics(struct work *work, const struct vw_metrics *metrics) {
    const struct vw_config *config = work->params->common.config;
    struct vw_hasher hasher;
    uint8_t hash[VW_HASH_BYTES];
    char config_hash[VW_HASH_HEX_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, work->retrainer.base_id);
    vw_hasher_add_integer(&hasher, config->epochs);
    vw_hasher_add_integer(&hasher, (int64_t)config->seed);
    vw_hasher_add_integer(&hasher, config->val_rays);
    vw_hasher_add_integer(&hasher, config->burn_in_epochs);
    vw_hasher_add_integer(&hasher, work->subsets.count);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, config_hash);
    return vw_retrainings_set_metrics(work->retrainer.retrainings, work->retrainer.scene_hash, config_hash,
                                      metrics->rows, (uint32_t)metrics->count);
}

static void print_csv(FILE *stream, const void *context) {
    const struct vw_benchmark *benchmark = context;
    fputs("scene,metric,method,value,ci_low,ci_high,count\n", stream);
    for (size_t i = 0; i < benchmark->metrics.count; i++) {
        const struct vw_metric *row = &benchmark->metrics.rows[i];
        const char *const texts[] = {benchmark->params->common.scene.path, row->metric, row->method};
        const double values[] = {row->value, row->ci_low, row->ci_high};
        for (int t = 0; t < 3; t++) {
            vw_csv_write_text(stream, texts[t]);
            fputc(',', stream);
        }
        for (int v = 0; v < 3; v++) {
            vw_csv_write_real(stream, values[v]);
            fputc(',', stream);
        }
        fprintf(stream, "%u\n", row->count);
    }
}

static enum vw_status write_results(struct work *work, struct vw_benchmark *benchmark) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    benchmark->photo_count = evaluation->photo_count;
    benchmark->subset_count = work->subsets.count;
    benchmark->methods = vw_allocate(evaluation->scorer_count, sizeof *benchmark->methods);
    benchmark->csv_path = vw_path_join(work->params->common.out, "benchmark.csv");
    if (!benchmark->methods || !benchmark->csv_path) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++)
        benchmark->methods[benchmark->method_count++] =
            (struct vw_benchmark_method){evaluation->scorers[i].name, work->scorers.trainings[i]};
    enum vw_status status = record_metrics(work, &benchmark->metrics);
    return status ? status : vw_csv_write_file(benchmark->csv_path, print_csv, benchmark);
}

// ---- All of it ----

static enum vw_status make_runs(struct work *work) {
    struct vw_experiment_params runs = work->params->common;
    runs.seeds = VW_SUBSET_SEEDS;
    return vw_seed_runs_make(&runs, &work->session);
}

static enum vw_status open_retrainer(struct work *work) {
    const struct vw_experiment_params *common = &work->params->common;
    const struct vw_retrainer_params params = {.session = &work->session,
                                               .config = common->config,
                                               .out = common->out,
                                               .together = common->together,
                                               .interrupt = common->interrupt};
    return vw_retrainer_open(&params, &work->retrainer);
}

static enum vw_status make(struct work *work, struct vw_benchmark *benchmark) {
    struct vw_retrainer *retrainer = &work->retrainer;
    enum vw_status status = make_runs(work);
    if (!status) status = open_retrainer(work);
    if (!status) status = vw_scorers_make(&work->params->common, retrainer, VW_SUBSET_SEEDS, &work->scorers);
    if (!status) status = vw_subsets_draw(retrainer->train_count, work->params->subsets, &work->subsets);
    if (status) return status;
    retrainer->planned = count_retrainings(work);
    status = train_on_all(work, &benchmark->training_seconds);
    if (!status)
        status =
            vw_subsets_retrain(&work->subsets, retrainer->train_views, evaluation_seed(work), vw_retrain, retrainer);
    if (!status) status = leave_one_out(work);
    if (!status) status = evaluate(work, &benchmark->metrics);
    return status ? status : write_results(work, benchmark);
}

enum vw_status vw_benchmark_make(const struct vw_benchmark_params *params, struct vw_benchmark *benchmark) {
    *benchmark = (struct vw_benchmark){.params = params, .training_seconds = NAN};
    struct work *work = vw_allocate(1, sizeof *work);
    if (!work) return VW_ERROR_MEMORY;
    work->params = params;
    enum vw_status status = vw_experiment_check(&params->common, SEED_COUNT, true);
    if (!status) status = check_curves(params);
    if (!status) status = vw_out_lock_take(params->common.out, &work->lock);
    if (!status) status = make(work, benchmark);
    vw_subsets_free(&work->subsets);
    vw_scorers_free(&work->scorers);
    vw_retrainer_close(&work->retrainer);
    vw_session_close(&work->session);
    vw_out_lock_release(&work->lock);
    free(work);
    return status;
}

void vw_benchmark_free(struct vw_benchmark *benchmark) {
    free(benchmark->methods);
    free(benchmark->metrics.rows);
    free(benchmark->csv_path);
}
