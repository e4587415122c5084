// Evaluating every scoring method where truth is known: valued runs of two seeds, and, with other seeds, trainings on
// random halves of the photos and on what is left in the order that scores give.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/output/benchmark_output.h"
#include "cli/commands/commands.h"
#include "experiment/scorers.h"
#include "experiment/baselines.h"
#include "cli/interrupt.h"
#include "experiment/retrain.h"
#include "experiment/seed_runs.h"
#include "base/file.h"
#include "viewworth/log.h"
#include "base/memory.h"
#include "base/hash.h"
#include "viewworth/value.h"

struct benchmark {
    const struct vw_options *options;
    struct vw_retrainer retrainer;
    struct vw_scorers scorers;
    struct vw_subsets subsets;
    struct vw_metrics metrics;
    double training_seconds;
};

// Trainings that evaluate have other seeds than the valued runs: an initialisation that both shared would lift how well
// they agree. Leaving one out is evaluated like a method, and evaluates methods: its seeds are those of neither.
enum {
    EVALUATION_SEED = VW_SUBSET_SEEDS,
    LEAVE_ONE_OUT_SEED = 2 * VW_SUBSET_SEEDS,
    SEEDS_IN_ALL = 3 * VW_SUBSET_SEEDS
};

static uint64_t evaluation_seed(const struct vw_options *options) { return options->config.seed + EVALUATION_SEED; }

static bool wants_curves(const struct vw_options *options) {
    return !options->curves || strcmp(options->curves, "none") != 0;
}

static bool is_word(const char *word, size_t length, const char *name) {
    return strlen(name) == length && !strncmp(word, name, length);
}

static bool is_scorer(const char *word, size_t length) {
    uint32_t count;
    const struct vw_value_method *methods = vw_value_methods(&count);
    for (uint32_t i = 0; i < count; i++)
        if (is_word(word, length, methods[i].name)) return true;
    for (uint32_t i = 0; i < vw_baseline_count; i++)
        if (is_word(word, length, vw_baselines[i].name)) return true;
    return is_word(word, length, "leave_one_out");
}

static enum vw_status check_curves(const char *list) {
    if (!list || !strcmp(list, "all") || !strcmp(list, "none")) return VW_OK;
    for (const char *word = list; word; word = strchr(word, ',') ? strchr(word, ',') + 1 : NULL)
        if (!is_scorer(word, strcspn(word, ",")))
            return vw_fail(VW_ERROR_USAGE,
                           "--curves: \"%.*s\" is no method; take all, none, or names as scores.csv has them",
                           (int)strcspn(word, ","), word);
    return VW_OK;
}

// Whether --curves names a method: a list with commas, or "all".
static bool is_named(const struct vw_options *options, const char *method) {
    const char *list = options->curves;
    if (!list) return !strcmp(method, vw_reference_scorer) || !strcmp(method, "ground_truth");
    if (!strcmp(list, "all")) return true;
    for (const char *word = list; word; word = strchr(word, ',') ? strchr(word, ',') + 1 : NULL)
        if (is_word(word, strcspn(word, ","), method)) return true;
    return false;
}

// Equal scores give no order to remove photos in, and random ones have a curve of their own.
static bool has_curve(const struct benchmark *benchmark, const struct vw_scorer *scorer) {
    const struct vw_evaluation *evaluation = &benchmark->scorers.evaluation;
    bool differ = false;
    for (size_t i = 1; i < (size_t)evaluation->seed_count * evaluation->photo_count; i++)
        differ |= scorer->scores[i] != scorer->scores[0];
    return differ && strcmp(scorer->name, "random") != 0 && is_named(benchmark->options, scorer->name);
}

static void plan(struct benchmark *benchmark) {
    const struct vw_evaluation *evaluation = &benchmark->scorers.evaluation;
    uint32_t curves = wants_curves(benchmark->options) ? VW_CURVE_ORDERS : 0;
    for (uint32_t i = 0; i < evaluation->scorer_count; i++) curves += has_curve(benchmark, &evaluation->scorers[i]);
    benchmark->retrainer.planned =
        1 + (uint64_t)benchmark->subsets.count * VW_SUBSET_SEEDS + (uint64_t)curves * vw_curve_trainings();
    if (benchmark->options->leave_one_out)
        benchmark->retrainer.planned += (uint64_t)evaluation->seed_count * (evaluation->photo_count + 1);
}

// What a training on all photos takes and reaches: what removals are compared with.
static enum vw_status train_on_all(struct benchmark *benchmark) {
    struct vw_retrainer *retrainer = &benchmark->retrainer;
    const struct vw_retrain_params retraining = {.views = retrainer->train_views,
                                                 .view_count = retrainer->train_count,
                                                 .seed = evaluation_seed(benchmark->options)};
    struct vw_retrain_result outcome;
    enum vw_status status = vw_retrain(retrainer, &retraining, &outcome);
    if (!status) benchmark->training_seconds = outcome.seconds;
    return status;
}

static enum vw_status leave_one_out(struct benchmark *benchmark) {
    const struct vw_evaluation *evaluation = &benchmark->scorers.evaluation;
    if (!benchmark->options->leave_one_out) return VW_OK;
    uint32_t trainings = evaluation->photo_count + 1;
    double *scores = vw_scorers_add(&benchmark->scorers, "leave_one_out", trainings);
    if (!scores) return VW_ERROR_MEMORY;
    uint64_t first_seed = benchmark->options->config.seed + LEAVE_ONE_OUT_SEED;
    return vw_leave_one_out(evaluation, first_seed, vw_retrain, &benchmark->retrainer, scores);
}

static enum vw_status evaluate_curves(struct benchmark *benchmark) {
    const struct vw_evaluation *evaluation = &benchmark->scorers.evaluation;
    uint64_t seed = evaluation_seed(benchmark->options);
    if (!wants_curves(benchmark->options)) return VW_OK;
    enum vw_status status =
        vw_evaluate_random_curve(evaluation, seed, vw_retrain, &benchmark->retrainer, &benchmark->metrics);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        if (has_curve(benchmark, &evaluation->scorers[i]))
            status = vw_evaluate_curve(evaluation, &evaluation->scorers[i], seed, vw_retrain, &benchmark->retrainer,
                                       &benchmark->metrics);
    return status;
}

static enum vw_status evaluate(struct benchmark *benchmark) {
    struct vw_scorers *scorers = &benchmark->scorers;
    const struct vw_evaluation *evaluation = &scorers->evaluation;
    struct vw_metrics *metrics = &benchmark->metrics;
    enum vw_status status = vw_evaluate_detection(evaluation, metrics);
    if (!status) status = vw_evaluate_seeds(evaluation, metrics);
    if (!status) status = vw_evaluate_subsets(evaluation, &benchmark->subsets, metrics);
    if (!status) status = vw_evaluate_harm(evaluation, &benchmark->subsets, metrics);
    if (!status) status = vw_evaluate_harmful(evaluation, metrics);
    if (!status && benchmark->options->leave_one_out)
        status =
            vw_evaluate_leave_one_out(evaluation, evaluation->scorers[evaluation->scorer_count - 1].scores, metrics);
    if (!status) status = evaluate_curves(benchmark);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++)
        status = vw_metrics_add(metrics, "cost", "trainings",
                                (struct vw_metric){.method = evaluation->scorers[i].name,
                                                   .value = scorers->trainings[i],
                                                   .ci_low = NAN,
                                                   .ci_high = NAN,
                                                   .count = evaluation->seed_count});
    return status;
}

// Metrics of the same photos, config and number of subsets replace one another.
static enum vw_status keep_metrics(struct benchmark *benchmark) {
    const struct vw_options *options = benchmark->options;
    struct vw_hasher hasher;
    uint8_t hash[32];
    char config_hash[VW_HASH_HEX_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, benchmark->retrainer.base_id);
    vw_hasher_add_integer(&hasher, options->config.epochs);
    vw_hasher_add_integer(&hasher, (int64_t)options->config.seed);
    vw_hasher_add_integer(&hasher, options->config.val_rays);
    vw_hasher_add_integer(&hasher, options->config.burn_in_epochs);
    vw_hasher_add_integer(&hasher, benchmark->subsets.count);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, config_hash);
    return vw_retrainings_set_metrics(benchmark->retrainer.retrainings, benchmark->retrainer.scene_hash, config_hash,
                                      benchmark->metrics.rows, (uint32_t)benchmark->metrics.count);
}

static enum vw_status finish(struct benchmark *benchmark) {
    char *csv_path = vw_path_join(benchmark->options->out, "benchmark.csv");
    struct vw_benchmark_output output = {.scene = benchmark->options->operand,
                                         .scorers = &benchmark->scorers,
                                         .metrics = &benchmark->metrics,
                                         .subset_count = benchmark->subsets.count,
                                         .training_seconds = benchmark->training_seconds,
                                         .csv_path = csv_path};
    enum vw_status status = csv_path ? keep_metrics(benchmark) : VW_ERROR_MEMORY;
    if (!status) status = vw_benchmark_write_csv(&output);
    if (!status && benchmark->options->json) status = vw_benchmark_print_json(&output);
    else if (!status) vw_benchmark_print(&output);
    free(csv_path);
    return status;
}

static enum vw_status run(struct benchmark *benchmark) {
    const struct vw_options *options = benchmark->options;
    struct vw_retrainer *retrainer = &benchmark->retrainer;
    vw_interrupt_watch();
    enum vw_status status = vw_retrainer_open(options, retrainer);
    if (!status) status = vw_scorers_make(retrainer, VW_SUBSET_SEEDS, &benchmark->scorers);
    if (!status) status = vw_subsets_draw(retrainer->train_count, options->subsets, &benchmark->subsets);
    if (status) return status;
    plan(benchmark);
    status = train_on_all(benchmark);
    if (!status)
        status = vw_subsets_retrain(&benchmark->subsets, retrainer->train_views, evaluation_seed(options), vw_retrain,
                                    retrainer);
    if (!status) status = leave_one_out(benchmark);
    if (!status) status = evaluate(benchmark);
    return status ? status : finish(benchmark);
}

enum vw_status vw_command_benchmark(const struct vw_options *options) {
    if (options->config.epochs <= options->config.burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u to score; take more epochs",
                       options->config.epochs, options->config.burn_in_epochs);
    if (options->config.seed > (uint64_t)INT64_MAX - (SEEDS_IN_ALL - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the %d seeds counted from it pass %" PRId64
                       ", the largest; begin with a lower one",
                       options->config.seed, SEEDS_IN_ALL, INT64_MAX);
    struct benchmark benchmark = {.options = options, .training_seconds = NAN};
    enum vw_status status = check_curves(options->curves);
    if (!status) status = vw_seed_runs_make(options, 0, VW_SUBSET_SEEDS);
    if (!status) status = run(&benchmark);
    free(benchmark.metrics.rows);
    vw_subsets_free(&benchmark.subsets);
    vw_scorers_free(&benchmark.scorers);
    vw_retrainer_close(&benchmark.retrainer);
    return status;
}
