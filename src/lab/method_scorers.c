#include "lab/method_scorers.h"

#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/text.h"
#include "experiment/experiment.h"
#include "lab/methods/gradient_scores.h"
#include "viewworth/log.h"

const char vw_method_budgets_default[] = "1,2,4,10,N,4N";

// First seed of the methods' retrainings. It lies after all other seeds of an experiment, so that more of those do not
// change it; each run has METHOD_SEEDS of its own.
enum { METHODS_FROM = 1 << 30, METHOD_SEEDS = 1 << 20 };

uint32_t vw_method_scorers_seed_count(const struct vw_experiment_params *params) {
    return METHODS_FROM + params->seeds * METHOD_SEEDS;
}

// ---- What is asked for ----

enum { BUDGET_MOST = 100000, FACTOR_MOST = 1000 };

// A budget as the option spells it: `times` trainings, or times / parts of one for each photo.
struct budget {
    uint32_t times, parts;
    bool per_photo;
};

static const char *read_number(const char *text, const char *end, uint32_t *number) {
    *number = 0;
    while (text < end && isdigit((unsigned char)*text) && *number <= BUDGET_MOST)
        *number = 10 * *number + (uint32_t)(*text++ - '0');
    return text;
}

// Reads a budget: 40, N, 4N, N/2, 3N/2.
static bool read_budget(struct vw_word word, struct budget *budget) {
    const char *end = word.text + word.length, *text = read_number(word.text, end, &budget->times);
    bool number = text > word.text;
    budget->parts = 1;
    budget->per_photo = text < end && *text == 'N';
    if (budget->per_photo && !number) budget->times = 1;
    if (budget->per_photo && ++text < end && *text == '/') text = read_number(text + 1, end, &budget->parts);
    return word.length && text == end && budget->times > 0 && budget->parts > 0 && (number || budget->per_photo) &&
           budget->times <= (budget->per_photo ? FACTOR_MOST : BUDGET_MOST);
}

static bool is_asked_for(const char *list, const char *method) {
    return list && (!strcmp(list, "all") || vw_word_list_has(list, method));
}

static enum vw_status check_methods(const char *list) {
    const char *rest = list && strcmp(list, "all") != 0 ? list : NULL;
    struct vw_word word;
    while (vw_word_list_next(&rest, &word)) {
        bool known = false;
        for (uint32_t i = 0; i < vw_retraining_method_count; i++)
            known |= vw_word_is(word, vw_retraining_methods[i]->name);
        for (uint32_t i = 0; i < VW_GRADIENT_METHODS; i++) known |= vw_word_is(word, vw_gradient_methods[i].name);
        if (!known)
            return vw_fail(VW_ERROR_USAGE,
                           "--methods: \"%.*s\" is none of " VW_RETRAINING_METHODS ", " VW_GRADIENT_METHOD_NAMES,
                           (int)word.length, word.text);
    }
    return VW_OK;
}

enum vw_status vw_method_scorers_check(const struct vw_method_params *params) {
    const char *rest = params->run_equivalents;
    struct vw_word word;
    struct budget budget;
    uint32_t count = 0;
    if (!params->methods && params->run_equivalents)
        return vw_fail(VW_ERROR_USAGE, "--run-equivalents needs --methods");
    while (vw_word_list_next(&rest, &word))
        if (++count > VW_METHOD_BUDGETS_MAX || !read_budget(word, &budget))
            return vw_fail(
                VW_ERROR_USAGE,
                "--run-equivalents takes up to %d numbers, 1 to %d, or parts of N as N, N/2 and 4N, not \"%s\"",
                VW_METHOD_BUDGETS_MAX, BUDGET_MOST, params->run_equivalents);
    return check_methods(params->methods);
}

// Budgets for so many photos, each once, as they were given: "4N" stands for the same budget in scenes of any size.
struct budgets {
    uint32_t numbers[VW_METHOD_BUDGETS_MAX];
    struct vw_word words[VW_METHOD_BUDGETS_MAX];
    uint32_t count;
};

static struct budgets list_budgets(const struct vw_method_params *params, uint32_t photo_count) {
    const char *rest = params->run_equivalents ? params->run_equivalents : vw_method_budgets_default;
    struct budgets budgets = {.count = 0};
    struct vw_word word;
    struct budget budget;
    while (vw_word_list_next(&rest, &word) && budgets.count < VW_METHOD_BUDGETS_MAX && read_budget(word, &budget)) {
        uint64_t number = budget.per_photo ? (uint64_t)budget.times * photo_count / budget.parts : budget.times;
        bool listed = number < 1 || number > BUDGET_MOST;
        for (uint32_t i = 0; i < budgets.count; i++) listed |= budgets.numbers[i] == number;
        if (listed) continue;
        budgets.words[budgets.count] = word;
        budgets.numbers[budgets.count++] = (uint32_t)number;
    }
    return budgets;
}

// ---- Scores ----

// State that all methods share.
struct work {
    const struct vw_method_params *params;
    struct vw_retrainer *retrainer;
    struct vw_scorers *scorers;
    struct vw_feature_table features; // its arrays are those below
    const char *feature_names[VW_FEATURE_COUNT];
    double *feature_values; // owned
};

// Makes the table of the features that are known of all photos before a run.
static enum vw_status make_feature_table(struct work *work) {
    const struct vw_photo_features *known = &work->scorers->features;
    enum vw_feature columns[VW_FEATURE_COUNT];
    uint32_t count = 0, photos = known->photo_count;
    for (enum vw_feature feature = 0; feature < VW_FEATURE_COUNT; feature++) {
        bool whole = !vw_features[feature].of_run;
        for (uint32_t i = 0; whole && i < photos; i++) whole = isfinite(vw_photo_feature(known, 0, i, feature));
        if (!whole) continue;
        columns[count] = feature;
        work->feature_names[count++] = vw_features[feature].name;
    }
    work->feature_values = vw_allocate((size_t)photos * count + 1, sizeof *work->feature_values);
    if (!work->feature_values) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < (size_t)photos * count; i++)
        work->feature_values[i] = vw_photo_feature(known, 0, (uint32_t)(i / count), columns[i % count]);
    work->features = (struct vw_feature_table){count, work->feature_names, work->feature_values};
    return VW_OK;
}

static struct vw_retraining_input input_of(const struct work *work, uint32_t valued, uint32_t budget) {
    struct vw_retrainer *retrainer = work->retrainer;
    uint64_t seed = retrainer->params.config->seed;
    return (struct vw_retraining_input){.photos = retrainer->train_views,
                                        .photo_count = retrainer->train_count,
                                        .retrain = vw_retrain,
                                        .context = retrainer,
                                        .equal = retrainer->params.equal,
                                        .first_seed = seed + METHODS_FROM + (uint64_t)valued * METHOD_SEEDS,
                                        .key = seed + valued,
                                        .budget = budget,
                                        .epochs = retrainer->params.config->epochs,
                                        .features = work->features.count ? &work->features : NULL};
}

// Returns true if the budget is enough, and needs no more seeds than there are.
static bool can_use(const struct vw_retraining_method *method, const struct vw_retraining_input *input) {
    return input->budget >= method->least_budget(input) && (uint64_t)input->budget * input->epochs <= METHOD_SEEDS;
}

uint64_t vw_method_scorers_count(const struct vw_method_params *params, uint32_t seeds,
                                 const struct vw_retrainer *retrainer) {
    const struct budgets budgets = list_budgets(params, retrainer->train_count);
    uint32_t epochs = retrainer->params.config->epochs;
    uint64_t count = 0;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++) {
        const struct vw_retraining_method *method = vw_retraining_methods[m];
        uint32_t of_each = epochs / (method->epochs ? method->epochs(epochs) : epochs);
        for (uint32_t i = 0; is_asked_for(params->methods, method->name) && i < budgets.count; i++)
            count += (uint64_t)budgets.numbers[i] * (of_each + 1); // an untrained field beside each, at most
    }
    return count * seeds;
}

static enum vw_status add_scorer(const struct work *work, const struct vw_retraining_method *method, uint32_t budget,
                                 const char *name) {
    struct vw_scorers *scorers = work->scorers;
    uint32_t seeds = scorers->evaluation.seed_count;
    struct vw_scorer_cost mean = {0};
    double *scores = vw_scorers_add(scorers, (struct vw_scorer){.name = name, .has_sign = method->has_sign}, mean);
    enum vw_status status = scores ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t valued = 0; !status && valued < seeds; valued++) {
        const struct vw_retraining_input input = input_of(work, valued, budget);
        struct vw_retraining_cost cost;
        status = vw_retraining_method_score(method, &input, scores + (size_t)valued * input.photo_count, &cost);
        if (status) break;
        mean.trainings += cost.run_equivalents / seeds;
        mean.seconds += cost.seconds / seeds;
    }
    if (!status) scorers->costs[scorers->evaluation.scorer_count - 1] = mean;
    return status;
}

// ---- From gradients along the valued runs ----

// Computes the scores of one valued seed. A run that these methods cannot follow leaves NaN, and so no scorer.
static enum vw_status follow_run(const struct vw_retrainer *retrainer, uint32_t valued,
                                 double *const scores[VW_GRADIENT_METHODS]) {
    const struct vw_retrainer_params *params = &retrainer->params;
    uint64_t seed = params->config->seed + valued;
    char *out = vw_seed_run_path(params->out, seed, "");
    char *name = vw_format_text("gradient_scores_%" PRIu64 ".csv", seed);
    char *store = name ? vw_path_join(params->out, name) : NULL;
    const struct vw_gradient_scores_params run = {.gpu = params->session->devices[0].gpu,
                                                  .scene = params->session->scene,
                                                  .epochs = params->config->epochs,
                                                  .out = out,
                                                  .store = store,
                                                  .interrupt = params->interrupt};
    enum vw_status status = out && store ? vw_file_check_inside(params->out, name) : VW_ERROR_MEMORY;
    if (!status) status = vw_gradient_scores_make(&run, scores, NULL);
    free(out);
    free(name);
    free(store);
    if (status != VW_ERROR_USAGE) return status;
    vw_log_warning("no scores from gradients: %s", vw_error_message());
    return VW_OK;
}

// Budgets do not concern them: they cost a run, and a pass over it.
static enum vw_status add_gradient_scorers(const char *methods, struct vw_retrainer *retrainer,
                                           struct vw_scorers *scorers) {
    double *scores[VW_GRADIENT_METHODS] = {0}, *of_seed[VW_GRADIENT_METHODS];
    bool some = false;
    enum vw_status status = VW_OK;
    for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++) {
        const struct vw_gradient_method_row *row = &vw_gradient_methods[m];
        if (!is_asked_for(methods, row->name)) continue;
        scores[m] = vw_scorers_add(scorers, (struct vw_scorer){.name = row->name, .has_sign = row->has_sign},
                                   (struct vw_scorer_cost){.trainings = row->run_equivalents});
        if (!scores[m]) return VW_ERROR_MEMORY;
        some = true;
    }
    for (uint32_t valued = 0; some && !status && valued < scorers->evaluation.seed_count; valued++) {
        for (uint32_t m = 0; m < VW_GRADIENT_METHODS; m++)
            of_seed[m] = scores[m] ? scores[m] + (size_t)valued * retrainer->train_count : NULL;
        status = follow_run(retrainer, valued, of_seed);
    }
    vw_scorers_drop_incomplete(scorers);
    return status;
}

static enum vw_status add_retraining_scorers(const struct work *work, char (*names)[VW_METHOD_NAME_BYTES]) {
    const struct budgets budgets = list_budgets(work->params, work->retrainer->train_count);
    enum vw_status status = VW_OK;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++) {
        const struct vw_retraining_method *method = vw_retraining_methods[m];
        for (uint32_t i = 0; !status && is_asked_for(work->params->methods, method->name) && i < budgets.count; i++) {
            const struct vw_retraining_input input = input_of(work, 0, budgets.numbers[i]);
            char *name = *names++;
            snprintf(name, VW_METHOD_NAME_BYTES, "%s_%.*s", method->name, (int)budgets.words[i].length,
                     budgets.words[i].text);
            if (can_use(method, &input)) status = add_scorer(work, method, budgets.numbers[i], name);
            else
                vw_log_info("method   %s is left out: it takes %" PRIu32 " to %d run-equivalents", name,
                            method->least_budget(&input), METHOD_SEEDS / (int)input.epochs);
        }
    }
    return status;
}

enum vw_status vw_method_scorers_add(const struct vw_method_params *params, struct vw_retrainer *retrainer,
                                     struct vw_scorers *scorers, char (**names)[VW_METHOD_NAME_BYTES]) {
    struct work work = {.params = params, .retrainer = retrainer, .scorers = scorers};
    if (!params->methods) return VW_OK;
    *names = vw_allocate((size_t)vw_retraining_method_count * VW_METHOD_BUDGETS_MAX, sizeof **names);
    enum vw_status status = *names ? make_feature_table(&work) : VW_ERROR_MEMORY;
    if (!status) status = add_retraining_scorers(&work, *names);
    if (!status) status = add_gradient_scorers(params->methods, retrainer, scorers);
    free(work.feature_values);
    return status;
}
