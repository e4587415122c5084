#include "run/plan/plan.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/params.h"
#include "run/plan/estimate.h"
#include "run/out_folder.h"
#include "run/plan/presets.h"
#include "run/outputs/thumbnails.h"
#include "run/plan/budget.h"
#include "base/file.h"
#include "viewworth/ledger.h"
#include "train/trainer.h"
#include "viewworth/log.h"

enum {
    CANDIDATES_MAX = 16,
    EPOCHS_MOST = 1000000000, // as --epochs
    EPOCHS_WORTH_IT = 5,      // behind burn-in; with fewer, scores say little
};
// What cannot be timed beforehand of the end of a run: field, scores and tables, and the rows of the ledger, which are
// read twice.
static const double FINISH_S = 0.3, ROW_S = 4e-6;
// Of the budget, after which no further preset is measured.
static const double MEASURING_SHARE = 0.1;

// ---- The record
// -------------------------------------------------------------------------------------------------------

static enum vw_status write_record(struct vw_plan *plan, json_t *record) {
    plan->record = record;
    plan->json = record ? json_dumps(record, JSON_COMPACT) : NULL;
    return plan->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for what was chosen");
}

static double number_of(const json_t *record, const char *key) {
    return json_number_value(json_object_get(record, key));
}
static const char *text_of(const json_t *record, const char *key) {
    return json_string_value(json_object_get(record, key));
}

// Also what someone edited is read, which vw_ledger_verify finds out later.
static enum vw_status read_record(const char *json, struct vw_plan *plan) {
    plan->record = json_loads(json, 0, NULL);
    double planned = number_of(plan->record, "epochs_planned"), most = number_of(plan->record, "epochs_most");
    if (!json_is_object(plan->record) || !(planned >= 0 && planned <= EPOCHS_MOST) ||
        !(most >= 0 && most <= EPOCHS_MOST))
        return vw_fail(VW_ERROR_INPUT, "run.plan_json of the ledger: \"%.100s\" is no plan; make the run again", json);
    plan->budget_s = number_of(plan->record, "budget_s");
    plan->step_s = number_of(plan->record, "step_s");
    plan->epochs_planned = (uint32_t)planned;
    plan->epochs_most = (uint32_t)most;
    plan->json = json_dumps(plan->record, JSON_COMPACT);
    return plan->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for what was chosen");
}

// ---- A new run
// --------------------------------------------------------------------------------------------------------

static enum vw_status find_accuracy(const char *name, const struct vw_preset **preset) {
    *preset = name ? vw_preset_find(name) : NULL;
    if (!name || *preset) return VW_OK;
    char names[200] = "";
    uint32_t count;
    const struct vw_preset *presets = vw_presets(&count);
    for (uint32_t i = 0; i < count; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", presets[i].name);
    }
    return vw_fail(VW_ERROR_USAGE, "--accuracy: \"%s\" is not one of %s", name, names);
}

static void say(const struct vw_plan *plan, const struct vw_config *config) {
    char text[VW_PRESET_TEXT_BYTES], lead[40];
    const char *trade_off = text_of(plan->record, "trade_off");
    snprintf(lead, sizeof lead, plan->budget_s > 0 ? "budget   %g s: " : "accuracy ", plan->budget_s);
    vw_preset_options(config, text);
    vw_log_info("%s%s (%s)", lead, text_of(plan->record, "preset"), text);
    if (plan->budget_s > 0)
        vw_log_info("         about %u epochs at %.3g ms a step", plan->epochs_planned, 1e3 * plan->step_s);
    if (*trade_off) vw_log_info("         gives up %s", trade_off);
}

static enum vw_status choose_accuracy(struct vw_options *options, const struct vw_preset *preset,
                                      struct vw_plan *plan) {
    vw_preset_apply_beside(preset, options, &options->config);
    enum vw_status status = vw_config_check(&options->config);
    if (!status)
        status = write_record(plan, json_pack("{s:s, s:s, s:s}", "accuracy", options->accuracy, "preset", preset->name,
                                              "trade_off", preset->trade_off));
    if (!status) say(plan, &options->config);
    return status;
}

// A trainer takes its first steps. Without burn-in, so that what is probed behind it is paid for as well.
static enum vw_status measure(const struct vw_config *preset, const struct vw_session *session, double *step_s) {
    struct vw_config config = *preset;
    struct vw_estimate estimate = {0};
    config.epochs = EPOCHS_MOST;
    config.burn_in_epochs = 0;
    enum vw_status status = vw_config_check(&config);
    if (!status)
        status = vw_estimate_take_steps(&(struct vw_trainer_params){.gpu = session->gpu,
                                                                    .scene = session->scene,
                                                                    .config = &config,
                                                                    .effects = session->effects,
                                                                    .effect_count = session->effect_count,
                                                                    .validate = true},
                                        &estimate);
    *step_s = estimate.seconds_per_step;
    if (!status && !(*step_s > 0))
        status = vw_fail(VW_ERROR_USAGE, "--budget: no step could be timed; give --accuracy instead");
    return status;
}

void vw_plan_estimate_finish(const struct vw_options *options, const struct vw_scene *scene, struct vw_plan *plan) {
    if (plan->finish_s > 0) return;
    plan->finish_s = FINISH_S + (options->no_thumbnails ? 0 : vw_thumbnails_estimate_s(scene));
    plan->finish_step_s = ROW_S * (2 + scene->split_count[VW_SPLIT_VAL]);
}

// Among the first `count` candidates.
static enum vw_status plan_among(const struct vw_options *options, const struct vw_session *session,
                                 const struct vw_budget_candidate *candidates, uint32_t count,
                                 const struct vw_plan *plan, struct vw_budget_plan *chosen) {
    const struct vw_budget_task task = {.left_s = vw_plan_left_s(plan, 0),
                                        .photos = session->scene->split_count[VW_SPLIT_TRAIN],
                                        .burn_in_epochs = options->config.burn_in_epochs,
                                        .epochs_most = plan->epochs_most};
    return vw_budget_plan(candidates, count, &task, chosen);
}

// Whether there is any sense in measuring this candidate, too: it would have to fit if it were no dearer than the one
// below it, and measuring has to leave the time to the run (of a device that has not seen a preset's shaders yet it can
// ask a lot).
static bool is_worth_measuring(const struct vw_options *options, const struct vw_session *session,
                               struct vw_budget_candidate *candidates, uint32_t candidate, const struct vw_plan *plan,
                               double begun_s) {
    struct vw_budget_plan hoped = {0};
    if (candidate == 0) return true;
    candidates[candidate].step_s = candidates[candidate - 1].step_s;
    return vw_now_s() - begun_s < MEASURING_SHARE * plan->budget_s &&
           !plan_among(options, session, candidates, candidate + 1, plan, &hoped) && hoped.candidate == candidate;
}

// From the cheapest preset on, until one is too dear.
static enum vw_status choose_preset(const struct vw_options *options, const struct vw_session *session,
                                    const struct vw_preset *presets, uint32_t count, struct vw_plan *plan,
                                    struct vw_budget_plan *chosen) {
    struct vw_budget_candidate candidates[CANDIDATES_MAX];
    double begun_s = vw_now_s();
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && chosen->candidate + 1 >= i && i < count && i < CANDIDATES_MAX; i++) {
        struct vw_config config = options->config;
        vw_preset_apply_beside(&presets[i], options, &config);
        uint32_t wanted = presets[i].budget_epochs;
        candidates[i] = (struct vw_budget_candidate){.epochs = wanted < plan->epochs_most ? wanted : plan->epochs_most};
        if (!is_worth_measuring(options, session, candidates, i, plan, begun_s)) return VW_OK;
        status = measure(&config, session, &candidates[i].step_s);
        if (status && i > 0) return VW_OK; // as where the device has no room for it
        candidates[i].step_s += plan->finish_step_s;
        struct vw_budget_plan found = *chosen;
        if (!status) status = plan_among(options, session, candidates, i + 1, plan, &found);
        if (status && i > 0) return VW_OK; // measuring took what time there was: the plan stays
        if (!status) *chosen = found;
        if (!status) plan->step_s = candidates[chosen->candidate].step_s - plan->finish_step_s;
    }
    return status;
}

static enum vw_status record_plan(struct vw_options *options, const struct vw_preset *preset, struct vw_plan *plan,
                                  uint32_t epochs) {
    vw_preset_apply_beside(preset, options, &options->config);
    options->config.epochs = plan->epochs_planned = epochs;
    return write_record(plan, json_pack("{s:s*, s:f, s:s, s:f, s:I, s:I, s:s}", "accuracy", options->accuracy,
                                        "budget_s", plan->budget_s, "preset", preset->name, "step_s", plan->step_s,
                                        "epochs_planned", (json_int_t)epochs, "epochs_most",
                                        (json_int_t)plan->epochs_most, "trade_off", preset->trade_off));
}

static enum vw_status choose_budget(struct vw_options *options, struct vw_session *session,
                                    const struct vw_preset *accuracy, struct vw_plan *plan) {
    uint32_t count = 1;
    const struct vw_preset *presets = accuracy ? accuracy : vw_presets(&count);
    struct vw_budget_plan chosen = {0};
    const struct vw_session_params params = vw_params_of_session(options);
    uint32_t burn_in = options->config.burn_in_epochs;
    plan->epochs_most = vw_options_have(options, "epochs") ? options->config.epochs : EPOCHS_MOST;
    if (plan->epochs_most <= burn_in)
        return vw_fail(VW_ERROR_USAGE, "--budget: --epochs %u leaves no epoch after --burn-in %u; take more",
                       plan->epochs_most, burn_in);
    enum vw_status status = vw_out_check(options->out);
    if (!status) status = vw_session_open(&params, session);
    if (!status) status = vw_session_decide_effects(options->config.effects, session);
    if (status) return status;
    vw_plan_estimate_finish(options, session->scene, plan);
    status = choose_preset(options, session, presets, count, plan, &chosen);
    if (!status) status = record_plan(options, &presets[chosen.candidate], plan, chosen.epochs);
    if (status) return status;
    say(plan, &options->config);
    if (chosen.candidate == 0 && chosen.epochs < burn_in + EPOCHS_WORTH_IT && chosen.epochs < plan->epochs_most)
        vw_log_warning("--budget %s: there is time for about %u epochs of the cheapest preset, which say little about "
                       "photos; allow more",
                       options->budget, chosen.epochs);
    return VW_OK;
}

// ---- A run that is gone on with
// ---------------------------------------------------------------------------------------

static enum vw_status check_same_choice(const struct vw_options *options, double wanted_s, const struct vw_plan *plan) {
    const char *accuracy = text_of(plan->record, "accuracy");
    bool same = !options->budget || wanted_s == plan->budget_s;
    same &= !options->accuracy || (accuracy && strcmp(accuracy, options->accuracy) == 0);
    if (same) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--resume: the run in %s was made with another --accuracy or --budget, or without: leave both out "
                   "(more --epochs extend "
                   "it), or name another --out",
                   options->out);
}

// The recorded preset, but for what is given; vw_run_row_check_same looks whether that is another.
static enum vw_status take_recorded_setting(struct vw_options *options, const struct vw_ledger_run *run) {
    struct vw_config recorded;
    enum vw_status status = vw_config_from_json(run->config_json, &recorded);
    const struct vw_preset preset = {.rays = recorded.rays,
                                     .samples = recorded.samples,
                                     .val_rays = recorded.val_rays,
                                     .log2_table = recorded.log2_table,
                                     .width = recorded.width,
                                     .epochs = recorded.epochs};
    if (!status) vw_preset_apply_beside(&preset, options, &options->config);
    return status;
}

// --epochs without --budget says how long the run is to be, whatever the time; beside --budget it says how long at
// most.
static void go_on(struct vw_options *options, uint64_t recorded_steps, struct vw_plan *plan) {
    bool epochs_given = vw_options_have(options, "epochs");
    plan->spent_s = (double)recorded_steps * plan->step_s;
    if (epochs_given && options->budget) plan->epochs_most = options->config.epochs;
    if (epochs_given && !options->budget) plan->budget_s = 0;
    if (plan->budget_s > 0)
        vw_log_info("budget   %g s, of which earlier steps took about %.1f s", plan->budget_s, plan->spent_s);
}

static enum vw_status take_recorded(struct vw_options *options, const char *ledger_path, double wanted_s,
                                    struct vw_plan *plan) {
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run run;
    enum vw_status status = vw_ledger_open(ledger_path, &ledger);
    if (!status) status = vw_ledger_get_run(ledger, &run);
    if (!status) status = read_record(run.plan_json, plan);
    if (!status) status = check_same_choice(options, wanted_s, plan);
    if (!status && json_object_size(plan->record) == 0) vw_plan_free(plan); // nothing was chosen
    else if (!status) status = take_recorded_setting(options, &run);
    uint64_t rows = status ? 0 : vw_ledger_next_step(ledger);
    if (!status && plan->record) go_on(options, rows > 0 ? rows - 1 : 0, plan);
    vw_ledger_close(&ledger);
    return status;
}

// ---- Both
// -------------------------------------------------------------------------------------------------------------

enum vw_status vw_plan_make(struct vw_options *options, struct vw_session *session, struct vw_plan *plan) {
    const struct vw_preset *accuracy = NULL;
    double wanted_s = 0;
    enum vw_status status = find_accuracy(options->accuracy, &accuracy);
    if (!status && options->budget) status = vw_budget_parse(options->budget, &wanted_s);
    if (!status && options->budget && options->config.same_state)
        status =
            vw_fail(VW_ERROR_USAGE,
                    "--budget cannot stand beside --same-state, whose states lie by --epochs: leave out one of them");
    char *ledger_path = status ? NULL : vw_path_join(options->out, "ledger.db");
    if (!ledger_path) return status ? status : VW_ERROR_MEMORY;
    plan->config = &options->config;
    plan->budget_s = wanted_s;
    if (vw_file_exists(ledger_path)) // which vw_training_open refuses unless it is to be gone on with
        status = options->resume ? take_recorded(options, ledger_path, wanted_s, plan) : VW_OK;
    else if (options->budget) status = choose_budget(options, session, accuracy, plan);
    else if (accuracy) status = choose_accuracy(options, accuracy, plan);
    if (plan->record) options->plan = plan;
    free(ledger_path);
    return status;
}

void vw_plan_free(struct vw_plan *plan) {
    json_decref(plan->record);
    free(plan->json);
    plan->record = NULL;
    plan->json = NULL;
}

bool vw_plan_clock(const struct vw_options *options) { return options->plan && options->plan->budget_s > 0; }

uint32_t vw_plan_epochs_most(const struct vw_options *options) {
    return vw_plan_clock(options) ? options->plan->epochs_most : options->config.epochs;
}

double vw_plan_left_s(const struct vw_plan *plan, uint64_t steps) {
    double passed_s = vw_now_s() - plan->started_s + plan->spent_s;
    return plan->budget_s - passed_s - plan->finish_s - plan->finish_step_s * (double)steps;
}

void vw_plan_print(const struct vw_options *options) {
    if (!options->plan) return;
    char text[VW_PRESET_TEXT_BYTES];
    vw_preset_options(&options->config, text);
    if (vw_plan_clock(options))
        printf("budget   %g s; this command took %.1f s\n", options->plan->budget_s,
               vw_now_s() - options->plan->started_s);
    printf("again    the same bits by %s\n", text);
}

bool vw_plan_add_json(const struct vw_options *options, json_t *root) {
    if (!options->plan) return true;
    char text[VW_PRESET_TEXT_BYTES];
    const json_t *record = options->plan->record;
    vw_preset_options(&options->config, text);
    json_t *object = json_pack("{s:f, s:s}", "took_s", vw_now_s() - options->plan->started_s, "options", text);
    bool failed = !object || json_object_update_missing(object, options->plan->record);
    failed |= json_object_set_new(root, json_object_get(record, "budget_s") ? "budget" : "accuracy", object) != 0;
    return !failed;
}
