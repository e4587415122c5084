#include "lab/benchmark.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/hash.h"
#include "base/memory.h"
#include "base/text.h"
#include "experiment/experiment.h"
#include "experiment/retrain.h"
#include "experiment/worth.h"
#include "lab/benchmark_files.h"
#include "lab/evaluation/exact_values.h"
#include "lab/evaluation/leave_one_out.h"
#include "lab/evaluation/subset_trainings.h"
#include "lab/scorers.h"
#include "run/out_folder.h"
#include "value/worth.h"

// A benchmark while it is made.
struct work {
    const struct vw_benchmark_params *params;
    struct vw_out_lock *lock; // lock of OUT
    struct vw_session session;
    struct vw_retrainer retrainer;
    struct vw_scorers scorers;
    struct vw_subsets subsets;
    struct vw_worths worths[VW_TRUTH_COUNT];
    struct vw_left_out left_out;
    struct vw_exact_values exact; // values from all subsets
};

// Retrainings that evaluate scores have other seeds than the valued runs: a shared initialisation would raise their
// agreement. Leave-one-out is both evaluated and compared with, so it has seeds of its own.
static uint64_t evaluation_seed(const struct work *work) {
    return work->params->common.config->seed + work->params->common.seeds;
}

static uint64_t leave_one_out_seed(const struct work *work) {
    return evaluation_seed(work) + work->params->retraining_seeds;
}

// Returns enough seeds for both uses of leave-one-out: a scorer of the valued seeds, and a truth of the retraining
// seeds.
static uint32_t leave_one_out_seeds(const struct vw_benchmark_params *params) {
    return params->common.seeds > params->retraining_seeds ? params->common.seeds : params->retraining_seeds;
}

static uint32_t worth_retrainings_most(const struct vw_benchmark_params *params) {
    uint32_t most = 0;
    for (uint32_t i = 0; i < params->worth_count; i++)
        if (params->worth_retrainings[i] > most) most = params->worth_retrainings[i];
    return most;
}

// Returns the first seed of a worth's retrainings. They never judge that worth: the truths come from other subsets and
// other seeds. Each valued seed has its own.
static uint64_t worth_seed(const struct work *work, uint32_t valued) {
    return leave_one_out_seed(work) + leave_one_out_seeds(work->params) +
           (uint64_t)valued * worth_retrainings_most(work->params);
}

static uint32_t count_seeds(const struct vw_benchmark_params *params) {
    if (params->evaluated.methods) return vw_method_scorers_seed_count(&params->common);
    return params->common.seeds * (1 + worth_retrainings_most(params)) + params->retraining_seeds +
           leave_one_out_seeds(params);
}

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
                             "--curves: \"%s\" is not a method; take all, none, gain, or names as scores.csv has them",
                             name);
        free(name);
    }
    return status;
}

static bool is_wanted(const struct vw_benchmark_params *params, const char *scorer) {
    switch (params->curves) {
    case VW_CURVES_DEFAULT: return !strcmp(scorer, vw_reference_scorer) || !strcmp(scorer, "ground_truth");
    case VW_CURVES_NONE: return false;
    case VW_CURVES_ALL:
    case VW_CURVES_GAIN: return true;
    case VW_CURVES_LISTED: return vw_word_list_has(params->curve_scorers, scorer);
    }
    return false;
}

// Returns true if the scorer has a curve. Equal scores define no order in which to remove photos, and random orders
// have a curve of their own.
static bool has_curve(const struct work *work, const struct vw_scorer *scorer) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    bool differ = false;
    for (size_t i = 1; i < (size_t)evaluation->seed_count * evaluation->photo_count; i++)
        differ |= scorer->scores[i] != scorer->scores[0];
    return differ && strcmp(scorer->name, "random") != 0 && is_wanted(work->params, scorer->name);
}

static enum vw_status evaluate_curves(struct work *work, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    const struct vw_curve_params params = {.evaluation = evaluation,
                                           .first_seed = evaluation_seed(work),
                                           .seed_count = work->params->retraining_seeds,
                                           .retrain = vw_retrain,
                                           .context = &work->retrainer,
                                           .gain_only = work->params->curves == VW_CURVES_GAIN};
    if (work->params->curves == VW_CURVES_NONE) return VW_OK;
    enum vw_status status = vw_evaluate_random_curve(&params, metrics);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        if (has_curve(work, &evaluation->scorers[i]))
            status = vw_evaluate_curve(&params, &evaluation->scorers[i], metrics);
    return status;
}

// ---- Retrainings ----

static uint64_t count_retrainings(const struct work *work) {
    const struct vw_benchmark_params *params = work->params;
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    uint32_t curves = params->curves == VW_CURVES_NONE ? 0 : VW_CURVE_ORDERS;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++) curves += has_curve(work, &evaluation->scorers[i]);
    uint64_t count = 1 + (uint64_t)work->subsets.count * params->retraining_seeds +
                     (uint64_t)curves * vw_curve_trainings(params->retraining_seeds, params->curves == VW_CURVES_GAIN);
    count += (uint64_t)params->common.seeds * worth_retrainings_most(params);
    count += vw_method_scorers_count(&params->evaluated, params->common.seeds, &work->retrainer);
    if (params->leave_one_out) count += (uint64_t)leave_one_out_seeds(params) * (evaluation->photo_count + 1);
    return count;
}

// Trains on all photos: the baseline of removals. Also measures the time of a training.
static enum vw_status train_on_all(struct work *work, double *seconds) {
    struct vw_retrainer *retrainer = &work->retrainer;
    const struct vw_retrain_params retraining = {
        .views = retrainer->train_views, .view_count = retrainer->train_count, .seed = evaluation_seed(work)};
    struct vw_retrain_result result;
    enum vw_status status = vw_retrain(retrainer, &retraining, 1, &result);
    if (!status) *seconds = result.seconds;
    return status;
}

static enum vw_status draw_subsets(struct work *work) {
    const struct vw_benchmark_params *params = work->params;
    uint32_t photo_count = work->session.scene->split_count[VW_SPLIT_TRAIN];
    const struct vw_subsets_params drawn = {.photo_count = photo_count,
                                            .halves = (params->subsets + 1) / 2,
                                            .random_sizes = params->subsets / 2,
                                            .seed_count = params->retraining_seeds};
    return params->all_subsets ? vw_subsets_list_all(photo_count, params->retraining_seeds, &work->subsets)
                               : vw_subsets_draw(&drawn, &work->subsets);
}

// Trains on the subsets, and adds the worths that follow from validation photos as a scorer.
static enum vw_status find_worths(struct work *work) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    uint32_t photos = evaluation->photo_count, seeds = work->params->retraining_seeds;
    enum vw_status status =
        vw_subsets_retrain(&work->subsets, evaluation->photos, evaluation_seed(work), vw_retrain, &work->retrainer);
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++)
        status = vw_worths_fit(
            &(struct vw_worth_params){
                .subsets = &work->subsets, .outcome = vw_truths[truth], .predict = true, .resample = true},
            &work->worths[truth]);
    if (status) return status;
    const struct vw_scorer scorer = {.name = vw_subset_worth_name, .of_subsets = true};
    const struct vw_scorer_cost cost = {.trainings = work->subsets.count * seeds};
    double *scores = vw_scorers_add(&work->scorers, scorer, cost);
    if (!scores) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < evaluation->seed_count * photos; i++) scores[i] = work->worths[0].values[i % photos];
    return VW_OK;
}

// Trains once for the largest number; smaller ones are the first of these.
static enum vw_status retrain_for_worth(struct work *work, uint32_t valued, struct vw_ledger_retraining **retrainings) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    uint32_t most = worth_retrainings_most(work->params);
    struct vw_worth_subsets drawn = {0};
    const struct vw_worth_subsets_params params = {.photos = evaluation->photos,
                                                   .photo_count = evaluation->photo_count,
                                                   .count = most,
                                                   .key = work->params->common.config->seed + valued + 1,
                                                   .first_seed = worth_seed(work, valued),
                                                   .epochs = work->params->common.config->epochs};
    enum vw_status status = vw_worth_subsets_draw(&params, &drawn);
    if (!status) status = vw_worth_retrainings_list(&drawn, most, retrainings);
    if (!status) status = vw_worth_retrainings_train(*retrainings, 0, most, vw_retrain, &work->retrainer);
    vw_subsets_free(&drawn.subsets);
    return status;
}

static enum vw_status find_worths_of_seed(struct work *work, uint32_t valued, double *const *scores) {
    struct vw_ledger_retraining *retrainings = NULL;
    enum vw_status status = retrain_for_worth(work, valued, &retrainings);
    for (uint32_t i = 0; !status && i < work->params->worth_count; i++)
        status = vw_scorers_find_worth(&work->scorers, valued, retrainings, work->params->worth_retrainings[i],
                                       scores[i] + (size_t)valued * work->scorers.evaluation.photo_count);
    free(retrainings);
    return status;
}

// Returns how many trainings the prior of worth costs: the run, and its backward pass if there is one.
static double prior_trainings(const struct vw_scorers *scorers) {
    double most = 1;
    for (uint32_t i = 0; i < scorers->evaluation.scorer_count; i++)
        for (uint32_t m = 0; m < VW_WORTH_PRIORS; m++)
            if (!strcmp(scorers->list[i].name, vw_worth_prior_methods[m]))
                most = fmax(most, scorers->costs[i].trainings);
    return most;
}

// Adds worth as `viewworth worth` computes it, with the scores of the valued run as its prior.
static enum vw_status add_worths(struct work *work, struct vw_benchmark *benchmark) {
    const struct vw_benchmark_params *params = work->params;
    double *scores[VW_BENCHMARK_WORTHS] = {0}, prior = prior_trainings(&work->scorers);
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < params->worth_count; i++) {
        char *name = benchmark->worth_names[i];
        snprintf(name, VW_BENCHMARK_NAME_BYTES, "worth_%u", params->worth_retrainings[i]);
        scores[i] = vw_scorers_add(&work->scorers, (struct vw_scorer){.name = name, .has_sign = true},
                                   (struct vw_scorer_cost){.trainings = prior + params->worth_retrainings[i]});
        if (!scores[i]) return VW_ERROR_MEMORY;
    }
    for (uint32_t seed = 0; !status && params->worth_count && seed < params->common.seeds; seed++)
        status = find_worths_of_seed(work, seed, scores);
    return status;
}

static enum vw_status leave_one_out(struct work *work) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    const struct vw_scorer scorer = {.name = vw_leave_one_out_scorer, .has_sign = true};
    if (!work->params->leave_one_out) return VW_OK;
    const struct vw_scorer_cost cost = {.trainings = evaluation->photo_count + 1};
    double *scores = vw_scorers_add(&work->scorers, scorer, cost);
    if (!scores) return VW_ERROR_MEMORY;
    enum vw_status status = vw_leave_one_out(evaluation, leave_one_out_seeds(work->params), leave_one_out_seed(work),
                                             vw_retrain, &work->retrainer, &work->left_out);
    if (!status)
        memcpy(scores, work->left_out.worths[0],
               (size_t)evaluation->seed_count * evaluation->photo_count * sizeof *scores);
    return status;
}

// ---- Metrics ----

static enum vw_status add_costs(const struct vw_scorers *scorers, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        status = vw_metrics_add(metrics, "cost", "trainings",
                                (struct vw_metric){.method = evaluation->scorers[i].name,
                                                   .value = scorers->costs[i].trainings,
                                                   .ci_low = NAN,
                                                   .ci_high = NAN,
                                                   .count = evaluation->seed_count});
    return status;
}

static enum vw_status evaluate_worths(const struct work *work, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    enum vw_status status = vw_evaluate_harm(evaluation, &work->worths[0], metrics);
    for (uint32_t truth = 0; !status && truth < VW_TRUTH_COUNT; truth++) {
        const char *name = vw_outcome_name(vw_truths[truth]);
        if (!work->worths[truth].count) continue; // for instance without test photos
        status = vw_evaluate_worths(&work->worths[truth], name, metrics);
        if (!status) status = vw_evaluate_signs(evaluation, &work->worths[truth], name, metrics);
    }
    return status;
}

// Evaluates leave-one-out, the last scorer; it is not compared with itself.
static enum vw_status evaluate_leave_one_out(const struct work *work, struct vw_metrics *metrics) {
    struct vw_evaluation others = work->scorers.evaluation;
    if (!work->params->leave_one_out) return VW_OK;
    others.scorer_count--;
    return vw_evaluate_leave_one_out(&others, &work->left_out, metrics);
}

static enum vw_status evaluate_exact_values(struct work *work, struct vw_metrics *metrics) {
    if (!work->params->all_subsets) return VW_OK;
    enum vw_status status = vw_exact_values_find(&work->subsets, &work->exact);
    return status ? status : vw_evaluate_exact_values(&work->scorers.evaluation, &work->exact, metrics);
}

static enum vw_status evaluate(struct work *work, struct vw_metrics *metrics) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    enum vw_status status = vw_evaluate_detection(evaluation, metrics);
    if (!status) status = vw_evaluate_seeds(evaluation, metrics);
    if (!status) status = vw_evaluate_subsets(evaluation, &work->subsets, work->worths, metrics);
    if (!status) status = evaluate_worths(work, metrics);
    if (!status) status = vw_evaluate_harmful(evaluation, metrics);
    if (!status) status = evaluate_leave_one_out(work, metrics);
    if (!status) status = evaluate_exact_values(work, metrics);
    if (!status) status = evaluate_curves(work, metrics);
    return status ? status : add_costs(&work->scorers, metrics);
}

static enum vw_status write_files(struct work *work, const struct vw_benchmark *benchmark) {
    const struct vw_experiment_params *common = &work->params->common;
    const struct vw_benchmark_photos photos = {work->session.scene, work->scorers.evaluation.photos};
    enum vw_status status = vw_benchmark_write_metrics(benchmark->csv_path, common->scene.path, &benchmark->metrics);
    if (!status) status = vw_benchmark_write_worths(common->out, &photos, work->worths);
    if (!status)
        status = vw_benchmark_write_features(common->out, &photos, common->config->seed, &work->scorers.features);
    if (!status && work->params->all_subsets) status = vw_benchmark_write_exact(common->out, &photos, &work->exact);
    return status;
}

static enum vw_status write_results(struct work *work, struct vw_benchmark *benchmark) {
    const struct vw_evaluation *evaluation = &work->scorers.evaluation;
    const struct vw_subsets *subsets = &work->subsets;
    benchmark->photo_count = evaluation->photo_count;
    benchmark->half_count = subsets->halves.end - subsets->halves.begin;
    benchmark->size_count = work->params->all_subsets ? subsets->count : subsets->sizes.end - subsets->sizes.begin;
    benchmark->truth_epochs = work->retrainer.params.averaged_epochs;
    benchmark->has_tests = work->session.scene->split_count[VW_SPLIT_TEST] > 0;
    benchmark->methods = vw_allocate(evaluation->scorer_count, sizeof *benchmark->methods);
    benchmark->csv_path = vw_path_join(work->params->common.out, "benchmark.csv");
    if (!benchmark->methods || !benchmark->csv_path) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++) {
        const struct vw_scorer_cost *cost = &work->scorers.costs[i];
        double seconds = cost->trainings > 0 ? cost->trainings * benchmark->training_seconds : 0;
        benchmark->methods[benchmark->method_count++] = (struct vw_benchmark_method){
            evaluation->scorers[i].name, cost->trainings, cost->seconds > 0 ? cost->seconds : seconds};
    }
    return write_files(work, benchmark);
}

// ---- All of it ----

static enum vw_status make(struct work *work, struct vw_benchmark *benchmark) {
    const struct vw_experiment_params *common = &work->params->common;
    struct vw_retrainer *retrainer = &work->retrainer;
    enum vw_status status = vw_experiment_open_session(common, &work->session);
    if (!status) status = draw_subsets(work); // which refuses too many photos before any training
    if (!status) status = vw_seed_runs_make(common, &work->session);
    if (!status) status = vw_scorers_open_retrainer(common, &work->session, work->params->equal, retrainer);
    if (!status) status = vw_scorers_make(common, retrainer, common->seeds, &work->scorers);
    if (status) return status;
    retrainer->planned = count_retrainings(work);
    status = train_on_all(work, &benchmark->training_seconds);
    if (!status) status = find_worths(work);
    if (!status) status = add_worths(work, benchmark);
    if (!status)
        status = vw_method_scorers_add(&work->params->evaluated, retrainer, &work->scorers, &benchmark->method_names);
    if (!status) status = leave_one_out(work);
    if (!status) status = evaluate(work, &benchmark->metrics);
    return status ? status : write_results(work, benchmark);
}

enum vw_status vw_benchmark_make(const struct vw_benchmark_params *params, struct vw_benchmark *benchmark) {
    *benchmark = (struct vw_benchmark){.params = params, .training_seconds = NAN};
    struct work *work = vw_allocate(1, sizeof *work);
    if (!work) return VW_ERROR_MEMORY;
    work->params = params;
    enum vw_status status = vw_experiment_check(&params->common, count_seeds(params), true);
    if (!status) status = check_curves(params);
    if (!status) status = vw_method_scorers_check(&params->evaluated);
    if (!status) status = vw_out_lock_take(params->common.out, &work->lock);
    if (!status) status = make(work, benchmark);
    for (uint32_t truth = 0; truth < VW_TRUTH_COUNT; truth++) vw_worths_free(&work->worths[truth]);
    vw_left_out_free(&work->left_out);
    vw_exact_values_free(&work->exact);
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
    free(benchmark->method_names);
}
