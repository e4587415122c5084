#include "experiment/method_scorers.h"

#include <ctype.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/word_list.h"
#include "viewworth/log.h"

const char vw_method_budgets_default[] = "1,2,4,10,N,4N";

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

// 40, N, 4N, N/2, 3N/2.
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

static bool is_asked_for(const char *list, const struct vw_retraining_method *method) {
    return list && (!strcmp(list, "all") || vw_word_list_has(list, method->name));
}

static enum vw_status check_methods(const char *list) {
    const char *rest = list && strcmp(list, "all") != 0 ? list : NULL;
    struct vw_word word;
    while (vw_word_list_next(&rest, &word)) {
        bool known = false;
        for (uint32_t i = 0; i < vw_retraining_method_count; i++)
            known |= vw_word_is(word, vw_retraining_methods[i]->name);
        if (!known)
            return vw_fail(VW_ERROR_USAGE, "--methods: \"%.*s\" is none of " VW_RETRAINING_METHODS, (int)word.length,
                           word.text);
    }
    return VW_OK;
}

enum vw_status vw_method_scorers_check(const struct vw_method_scorers_params *params) {
    const char *rest = params->budgets;
    struct vw_word word;
    struct budget budget;
    uint32_t count = 0;
    if (!params->methods && params->budgets)
        return vw_fail(VW_ERROR_USAGE, "--run-equivalents are of --methods; add --methods all, or leave them out");
    while (vw_word_list_next(&rest, &word))
        if (++count > VW_METHOD_BUDGETS_MAX || !read_budget(word, &budget))
            return vw_fail(
                VW_ERROR_USAGE,
                "--run-equivalents takes up to %d numbers, 1 to %d, or parts of N as N, N/2 and 4N, not \"%s\"",
                VW_METHOD_BUDGETS_MAX, BUDGET_MOST, params->budgets);
    return check_methods(params->methods);
}

// Budgets for so many photos, each once, as they were given: "4N" stands for the same budget in scenes of any size.
struct budgets {
    uint32_t numbers[VW_METHOD_BUDGETS_MAX];
    struct vw_word words[VW_METHOD_BUDGETS_MAX];
    uint32_t count;
};

static struct budgets list_budgets(const struct vw_method_scorers_params *params, uint32_t photo_count) {
    const char *rest = params->budgets ? params->budgets : vw_method_budgets_default;
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

static struct vw_retraining_input input_of(const struct vw_method_scorers_params *params,
                                           struct vw_retrainer *retrainer, uint32_t valued, uint32_t budget) {
    return (struct vw_retraining_input){.photos = retrainer->train_views,
                                        .photo_count = retrainer->train_count,
                                        .retrain = vw_retrain,
                                        .context = retrainer,
                                        .equal = retrainer->params.equal,
                                        .first_seed = params->first_seed + (uint64_t)valued * VW_METHOD_SEEDS,
                                        .key = params->key + valued,
                                        .budget = budget,
                                        .epochs = retrainer->params.config->epochs,
                                        .features = params->features};
}

// Whether the budget is enough, and asks for no more seeds than there are.
static bool can_use(const struct vw_retraining_method *method, const struct vw_retraining_input *input) {
    return input->budget >= method->least_budget(input) && (uint64_t)input->budget * input->epochs <= VW_METHOD_SEEDS;
}

uint64_t vw_method_scorers_count(const struct vw_method_scorers_params *params, const struct vw_retrainer *retrainer,
                                 uint32_t valued_seeds) {
    const struct budgets budgets = list_budgets(params, retrainer->train_count);
    uint32_t epochs = retrainer->params.config->epochs;
    uint64_t count = 0;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++) {
        const struct vw_retraining_method *method = vw_retraining_methods[m];
        uint32_t of_each = epochs / (method->epochs ? method->epochs(epochs) : epochs);
        for (uint32_t i = 0; is_asked_for(params->methods, method) && i < budgets.count; i++)
            count += (uint64_t)budgets.numbers[i] * (of_each + 1); // an untrained field beside each, at most
    }
    return count * valued_seeds;
}

static enum vw_status add_scorer(const struct vw_method_scorers_params *params,
                                 const struct vw_retraining_method *method, uint32_t budget, const char *name,
                                 struct vw_retrainer *retrainer, struct vw_scorers *scorers) {
    uint32_t seeds = scorers->evaluation.seed_count;
    struct vw_scorer_cost mean = {0};
    double *scores = vw_scorers_add(scorers, (struct vw_scorer){.name = name, .has_sign = method->has_sign}, mean);
    enum vw_status status = scores ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t valued = 0; !status && valued < seeds; valued++) {
        const struct vw_retraining_input input = input_of(params, retrainer, valued, budget);
        struct vw_retraining_cost cost;
        status = vw_retraining_method_score(method, &input, scores + (size_t)valued * input.photo_count, &cost);
        if (status) break;
        mean.trainings += cost.run_equivalents / seeds;
        mean.seconds += cost.seconds / seeds;
    }
    if (!status) scorers->costs[scorers->evaluation.scorer_count - 1] = mean;
    return status;
}

enum vw_status vw_method_scorers_add(const struct vw_method_scorers_params *params, struct vw_retrainer *retrainer,
                                     struct vw_scorers *scorers, char (**names)[VW_METHOD_NAME_BYTES]) {
    const struct budgets budgets = list_budgets(params, retrainer->train_count);
    uint32_t added = 0;
    enum vw_status status = VW_OK;
    if (!params->methods) return VW_OK;
    *names = vw_allocate((size_t)vw_retraining_method_count * VW_METHOD_BUDGETS_MAX, sizeof **names);
    if (!*names) return VW_ERROR_MEMORY;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++) {
        const struct vw_retraining_method *method = vw_retraining_methods[m];
        for (uint32_t i = 0; !status && is_asked_for(params->methods, method) && i < budgets.count; i++) {
            const struct vw_retraining_input input = input_of(params, retrainer, 0, budgets.numbers[i]);
            char *name = (*names)[added++];
            snprintf(name, VW_METHOD_NAME_BYTES, "%s_%.*s", method->name, (int)budgets.words[i].length,
                     budgets.words[i].text);
            if (can_use(method, &input))
                status = add_scorer(params, method, budgets.numbers[i], name, retrainer, scorers);
            else
                vw_log_info("method   %s is left out: it takes %" PRIu32 " to %d run-equivalents", name,
                            method->least_budget(&input), VW_METHOD_SEEDS / (int)input.epochs);
        }
    }
    return status;
}
