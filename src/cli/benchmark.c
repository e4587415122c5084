// Judging every scoring method where truth is known: valued runs of two seeds, and, with other seeds, trainings on random halves of the
// photos and on what is left in the order that scores give.
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/benchmark_output.h"
#include "cli/commands.h"
#include "cli/contestants.h"
#include "cli/controls.h"
#include "cli/interrupt.h"
#include "cli/laboratory.h"
#include "cli/seed_runs.h"
#include "viewworth/file.h"
#include "viewworth/log.h"
#include "viewworth/memory.h"
#include "viewworth/value.h"

struct benchmark {
    const struct vw_options *options;
    struct vw_laboratory laboratory;
    struct vw_contestants contestants;
    struct vw_subsets subsets;
    struct vw_judgements judgements;
    double training_seconds;
};

// Trainings that judge have other seeds than the valued runs: an initialisation that both shared would lift how well they agree. Leaving
// one out is judged like a method, and judges methods: its seeds are those of neither.
enum { JUDGING_SEED = VW_SUBSET_SEEDS, LEAVE_ONE_OUT_SEED = 2 * VW_SUBSET_SEEDS, SEEDS_IN_ALL = 3 * VW_SUBSET_SEEDS };

static uint64_t judging_seed(const struct vw_options *options) { return options->config.seed + JUDGING_SEED; }

static bool wants_curves(const struct vw_options *options) { return !options->curves || strcmp(options->curves, "none") != 0; }

static bool is_word(const char *word, size_t length, const char *name) { return strlen(name) == length && !strncmp(word, name, length); }

static bool is_contestant(const char *word, size_t length) {
    uint32_t count;
    const struct vw_value_method *methods = vw_value_methods(&count);
    for (uint32_t i = 0; i < count; i++)
        if (is_word(word, length, methods[i].name)) return true;
    for (uint32_t i = 0; i < vw_control_count; i++)
        if (is_word(word, length, vw_controls[i].name)) return true;
    return is_word(word, length, "leave_one_out");
}

static enum vw_status check_curves(const char *list) {
    if (!list || !strcmp(list, "all") || !strcmp(list, "none")) return VW_OK;
    for (const char *word = list; word; word = strchr(word, ',') ? strchr(word, ',') + 1 : NULL)
        if (!is_contestant(word, strcspn(word, ",")))
            return vw_fail(VW_ERROR_USAGE, "--curves: \"%.*s\" is no method; take all, none, or names as scores.csv has them",
                           (int)strcspn(word, ","), word);
    return VW_OK;
}

// Whether --curves names a method: a list with commas, or "all".
static bool is_named(const struct vw_options *options, const char *method) {
    const char *list = options->curves;
    if (!list) return !strcmp(method, vw_contest_reference) || !strcmp(method, "truth");
    if (!strcmp(list, "all")) return true;
    for (const char *word = list; word; word = strchr(word, ',') ? strchr(word, ',') + 1 : NULL)
        if (is_word(word, strcspn(word, ","), method)) return true;
    return false;
}

// Equal scores give no order to remove photos in, and random ones have a curve of their own.
static bool has_curve(const struct benchmark *benchmark, const struct vw_contestant *contestant) {
    const struct vw_contest *contest = &benchmark->contestants.contest;
    bool differ = false;
    for (size_t i = 1; i < (size_t)contest->seed_count * contest->photo_count; i++)
        differ |= contestant->scores[i] != contestant->scores[0];
    return differ && strcmp(contestant->name, "random") != 0 && is_named(benchmark->options, contestant->name);
}

static void plan(struct benchmark *benchmark) {
    const struct vw_contest *contest = &benchmark->contestants.contest;
    uint32_t curves = wants_curves(benchmark->options) ? VW_CURVE_ORDERS : 0;
    for (uint32_t i = 0; i < contest->contestant_count; i++) curves += has_curve(benchmark, &contest->contestants[i]);
    benchmark->laboratory.planned = 1 + (uint64_t)benchmark->subsets.count * VW_SUBSET_SEEDS + (uint64_t)curves * vw_curve_trainings();
    if (benchmark->options->leave_one_out) benchmark->laboratory.planned += (uint64_t)contest->seed_count * (contest->photo_count + 1);
}

// What a training on all photos takes and reaches: what removals are compared with.
static enum vw_status train_on_all(struct benchmark *benchmark) {
    struct vw_laboratory *laboratory = &benchmark->laboratory;
    const struct vw_trial trial = {
        .views = laboratory->train_views, .view_count = laboratory->train_count, .seed = judging_seed(benchmark->options)};
    struct vw_outcome outcome;
    enum vw_status status = vw_laboratory_try(laboratory, &trial, &outcome);
    if (!status) benchmark->training_seconds = outcome.seconds;
    return status;
}

static enum vw_status leave_one_out(struct benchmark *benchmark) {
    const struct vw_contest *contest = &benchmark->contestants.contest;
    if (!benchmark->options->leave_one_out) return VW_OK;
    uint32_t trainings = contest->photo_count + 1;
    double *scores = vw_contestants_add(&benchmark->contestants, "leave_one_out", trainings);
    if (!scores) return VW_ERROR_MEMORY;
    uint64_t first_seed = benchmark->options->config.seed + LEAVE_ONE_OUT_SEED;
    return vw_leave_one_out(contest, first_seed, vw_laboratory_try, &benchmark->laboratory, scores);
}

static enum vw_status judge_curves(struct benchmark *benchmark) {
    const struct vw_contest *contest = &benchmark->contestants.contest;
    uint64_t seed = judging_seed(benchmark->options);
    if (!wants_curves(benchmark->options)) return VW_OK;
    enum vw_status status = vw_judge_random_curve(contest, seed, vw_laboratory_try, &benchmark->laboratory, &benchmark->judgements);
    for (uint32_t i = 0; !status && i < contest->contestant_count; i++)
        if (has_curve(benchmark, &contest->contestants[i]))
            status =
                vw_judge_curve(contest, &contest->contestants[i], seed, vw_laboratory_try, &benchmark->laboratory, &benchmark->judgements);
    return status;
}

static enum vw_status judge(struct benchmark *benchmark) {
    struct vw_contestants *contestants = &benchmark->contestants;
    const struct vw_contest *contest = &contestants->contest;
    struct vw_judgements *judgements = &benchmark->judgements;
    enum vw_status status = vw_judge_detection(contest, judgements);
    if (!status) status = vw_judge_seeds(contest, judgements);
    if (!status) status = vw_judge_subsets(contest, &benchmark->subsets, judgements);
    if (!status) status = vw_judge_harm(contest, &benchmark->subsets, judgements);
    if (!status) status = vw_judge_harmful(contest, judgements);
    if (!status && benchmark->options->leave_one_out)
        status = vw_judge_leave_one_out(contest, contest->contestants[contest->contestant_count - 1].scores, judgements);
    if (!status) status = judge_curves(benchmark);
    for (uint32_t i = 0; !status && i < contest->contestant_count; i++)
        status = vw_judgements_add(judgements, "cost", "trainings",
                                   (struct vw_judgement){.method = contest->contestants[i].name,
                                                         .value = contestants->trainings[i],
                                                         .low = NAN,
                                                         .high = NAN,
                                                         .count = contest->seed_count});
    return status;
}

// Judgements of the same photos, config and number of subsets replace one another.
static enum vw_status keep_judgements(struct benchmark *benchmark) {
    const struct vw_options *options = benchmark->options;
    struct vw_hasher hasher;
    uint8_t hash[32];
    char config_hash[VW_HASH_HEX_BYTES];
    vw_hasher_begin(&hasher);
    vw_hasher_add_text(&hasher, benchmark->laboratory.base_id);
    vw_hasher_add_integer(&hasher, options->config.epochs);
    vw_hasher_add_integer(&hasher, (int64_t)options->config.seed);
    vw_hasher_add_integer(&hasher, options->config.val_rays);
    vw_hasher_add_integer(&hasher, options->config.burn_in_epochs);
    vw_hasher_add_integer(&hasher, benchmark->subsets.count);
    vw_hasher_end(&hasher, hash);
    vw_hash_to_hex(hash, config_hash);
    return vw_trials_set_judgements(benchmark->laboratory.trials, benchmark->laboratory.scene_hash, config_hash, benchmark->judgements.rows,
                                    (uint32_t)benchmark->judgements.count);
}

static enum vw_status conclude(struct benchmark *benchmark) {
    char *csv_path = vw_path_join(benchmark->options->out, "benchmark.csv");
    struct vw_benchmark_output output = {.scene = benchmark->options->operand,
                                         .contestants = &benchmark->contestants,
                                         .judgements = &benchmark->judgements,
                                         .subset_count = benchmark->subsets.count,
                                         .training_seconds = benchmark->training_seconds,
                                         .csv_path = csv_path};
    enum vw_status status = csv_path ? keep_judgements(benchmark) : VW_ERROR_MEMORY;
    if (!status) status = vw_benchmark_write_csv(&output);
    if (!status && benchmark->options->json) status = vw_benchmark_print_json(&output);
    else if (!status) vw_benchmark_print(&output);
    free(csv_path);
    return status;
}

static enum vw_status run(struct benchmark *benchmark) {
    const struct vw_options *options = benchmark->options;
    struct vw_laboratory *laboratory = &benchmark->laboratory;
    vw_interrupt_watch();
    enum vw_status status = vw_laboratory_open(options, laboratory);
    if (!status) status = vw_contestants_make(laboratory, VW_SUBSET_SEEDS, &benchmark->contestants);
    if (!status) status = vw_subsets_draw(laboratory->train_count, options->subsets, &benchmark->subsets);
    if (status) return status;
    plan(benchmark);
    status = train_on_all(benchmark);
    if (!status)
        status = vw_subsets_try(&benchmark->subsets, laboratory->train_views, judging_seed(options), vw_laboratory_try, laboratory);
    if (!status) status = leave_one_out(benchmark);
    if (!status) status = judge(benchmark);
    return status ? status : conclude(benchmark);
}

enum vw_status vw_command_benchmark(const struct vw_options *options) {
    if (options->config.epochs <= options->config.burn_in_epochs)
        return vw_fail(VW_ERROR_USAGE, "--epochs %u leaves no epoch after --burn-in %u to score; take more epochs", options->config.epochs,
                       options->config.burn_in_epochs);
    if (options->config.seed > (uint64_t)INT64_MAX - (SEEDS_IN_ALL - 1))
        return vw_fail(VW_ERROR_USAGE,
                       "--seed %" PRIu64 ": the %d seeds counted from it pass %" PRId64 ", the largest; begin with a lower one",
                       options->config.seed, SEEDS_IN_ALL, INT64_MAX);
    struct benchmark benchmark = {.options = options, .training_seconds = NAN};
    enum vw_status status = check_curves(options->curves);
    if (!status) status = vw_seed_runs_make(options, 0, VW_SUBSET_SEEDS);
    if (!status) status = run(&benchmark);
    free(benchmark.judgements.rows);
    vw_subsets_free(&benchmark.subsets);
    vw_contestants_free(&benchmark.contestants);
    vw_laboratory_close(&benchmark.laboratory);
    return status;
}
