#include "cli/choice.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/estimate.h"
#include "cli/out_folder.h"
#include "cli/settings.h"
#include "cli/thumbnails.h"
#include "viewworth/budget.h"
#include "viewworth/file.h"
#include "viewworth/ledger.h"
#include "viewworth/log.h"

enum {
    RUNGS_MOST = 16,
    EPOCHS_MOST = 1000000000, // as --epochs
    EPOCHS_WORTH_IT = 5,      // behind burn-in; with fewer, scores say little
};
// What cannot be timed beforehand of the end of a run: field, scores and tables, and the rows of the ledger, which are read twice.
static const double CONCLUSION_S = 0.3, ROW_S = 4e-6;
// Of the budget, after which no further setting is measured.
static const double MEASURING_SHARE = 0.1;

// ---- The record -------------------------------------------------------------------------------------------------------

static enum vw_status write_record(struct vw_choice *choice, json_t *record) {
    choice->record = record;
    choice->json = record ? json_dumps(record, JSON_COMPACT) : NULL;
    return choice->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for what was chosen");
}

static double number_of(const json_t *record, const char *key) { return json_number_value(json_object_get(record, key)); }
static const char *text_of(const json_t *record, const char *key) { return json_string_value(json_object_get(record, key)); }

// Also what someone edited is read, which vw_ledger_verify finds out later.
static enum vw_status read_record(const char *json, struct vw_choice *choice) {
    choice->record = json_loads(json, 0, NULL);
    double planned = number_of(choice->record, "epochs_planned"), most = number_of(choice->record, "epochs_most");
    if (!json_is_object(choice->record) || !(planned >= 0 && planned <= EPOCHS_MOST) || !(most >= 0 && most <= EPOCHS_MOST))
        return vw_fail(VW_ERROR_INPUT, "run.choice_json of the ledger: \"%.100s\" is no choice; make the run again", json);
    choice->budget_s = number_of(choice->record, "budget_s");
    choice->step_s = number_of(choice->record, "step_s");
    choice->epochs_planned = (uint32_t)planned;
    choice->epochs_most = (uint32_t)most;
    choice->json = json_dumps(choice->record, JSON_COMPACT);
    return choice->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for what was chosen");
}

// ---- A new run --------------------------------------------------------------------------------------------------------

static enum vw_status find_accuracy(const char *name, const struct vw_setting **setting) {
    *setting = name ? vw_setting_find(name) : NULL;
    if (!name || *setting) return VW_OK;
    char names[200] = "";
    uint32_t count;
    const struct vw_setting *settings = vw_settings(&count);
    for (uint32_t i = 0; i < count; i++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", i ? ", " : "", settings[i].name);
    }
    return vw_fail(VW_ERROR_USAGE, "--accuracy: \"%s\" is not one of %s", name, names);
}

static void say(const struct vw_choice *choice, const struct vw_config *config) {
    char text[VW_SETTING_TEXT_BYTES], lead[40];
    const char *gives_up = text_of(choice->record, "gives_up");
    snprintf(lead, sizeof lead, choice->budget_s > 0 ? "budget   %g s: " : "accuracy ", choice->budget_s);
    vw_setting_options(config, text);
    vw_log_info("%s%s (%s)", lead, text_of(choice->record, "setting"), text);
    if (choice->budget_s > 0) vw_log_info("         about %u epochs at %.3g ms a step", choice->epochs_planned, 1e3 * choice->step_s);
    if (*gives_up) vw_log_info("         gives up %s", gives_up);
}

static enum vw_status choose_accuracy(struct vw_options *options, const struct vw_setting *setting, struct vw_choice *choice) {
    vw_setting_apply_beside(setting, options, &options->config);
    enum vw_status status = vw_config_check(&options->config);
    if (!status)
        status = write_record(
            choice, json_pack("{s:s, s:s, s:s}", "accuracy", options->accuracy, "setting", setting->name, "gives_up", setting->gives_up));
    if (!status) say(choice, &options->config);
    return status;
}

// A trainer takes its first steps. Without burn-in, so that what is probed behind it is paid for as well.
static enum vw_status measure(const struct vw_config *setting, const struct vw_stage *stage, double *step_s) {
    struct vw_config config = *setting;
    struct vw_estimate estimate = {0};
    config.epochs = EPOCHS_MOST;
    config.burn_in_epochs = 0;
    enum vw_status status = vw_config_check(&config);
    if (!status)
        status = vw_estimate_take_steps(&(struct vw_trainer_params){.gpu = stage->gpu,
                                                                    .scene = stage->scene,
                                                                    .config = &config,
                                                                    .effects = stage->effects,
                                                                    .effect_count = stage->effect_count,
                                                                    .validate = true},
                                        &estimate);
    *step_s = estimate.seconds_per_step;
    if (!status && !(*step_s > 0)) status = vw_fail(VW_ERROR_USAGE, "--budget: no step could be timed; give --accuracy instead");
    return status;
}

void vw_choice_foresee_conclusion(const struct vw_options *options, const struct vw_scene *scene, struct vw_choice *choice) {
    if (choice->conclusion_s > 0) return;
    choice->conclusion_s = CONCLUSION_S + (options->no_thumbnails ? 0 : vw_thumbnails_foresee_s(scene));
    choice->conclusion_step_s = ROW_S * (2 + scene->split_count[VW_SPLIT_VAL]);
}

// Among the first `count` rungs.
static enum vw_status plan_among(const struct vw_options *options, const struct vw_stage *stage, const struct vw_budget_rung *rungs,
                                 uint32_t count, const struct vw_choice *choice, struct vw_budget_plan *chosen) {
    const struct vw_budget_task task = {.left_s = vw_choice_left_s(choice, 0),
                                        .photos = stage->scene->split_count[VW_SPLIT_TRAIN],
                                        .burn_in_epochs = options->config.burn_in_epochs,
                                        .epochs_most = choice->epochs_most};
    return vw_budget_plan(rungs, count, &task, chosen);
}

// Whether there is any sense in measuring this rung, too: it would have to fit if it were no dearer than the one below it, and measuring
// has to leave the time to the run (of a device that has not seen a setting's shaders yet it can ask a lot).
static bool is_worth_measuring(const struct vw_options *options, const struct vw_stage *stage, struct vw_budget_rung *rungs, uint32_t rung,
                               const struct vw_choice *choice, double begun_s) {
    struct vw_budget_plan hoped = {0};
    if (rung == 0) return true;
    rungs[rung].step_s = rungs[rung - 1].step_s;
    return vw_now_s() - begun_s < MEASURING_SHARE * choice->budget_s && !plan_among(options, stage, rungs, rung + 1, choice, &hoped) &&
           hoped.rung == rung;
}

// From the cheapest setting on, until one is too dear.
static enum vw_status plan(const struct vw_options *options, const struct vw_stage *stage, const struct vw_setting *settings,
                           uint32_t count, struct vw_choice *choice, struct vw_budget_plan *chosen) {
    struct vw_budget_rung rungs[RUNGS_MOST];
    double begun_s = vw_now_s();
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && chosen->rung + 1 >= i && i < count && i < RUNGS_MOST; i++) {
        struct vw_config config = options->config;
        vw_setting_apply_beside(&settings[i], options, &config);
        uint32_t wanted = settings[i].budget_epochs;
        rungs[i] = (struct vw_budget_rung){.epochs = wanted < choice->epochs_most ? wanted : choice->epochs_most};
        if (!is_worth_measuring(options, stage, rungs, i, choice, begun_s)) return VW_OK;
        status = measure(&config, stage, &rungs[i].step_s);
        if (status && i > 0) return VW_OK; // as where the device has no room for it
        rungs[i].step_s += choice->conclusion_step_s;
        struct vw_budget_plan found = *chosen;
        if (!status) status = plan_among(options, stage, rungs, i + 1, choice, &found);
        if (status && i > 0) return VW_OK; // measuring took what time there was: the plan stays
        if (!status) *chosen = found;
        if (!status) choice->step_s = rungs[chosen->rung].step_s - choice->conclusion_step_s;
    }
    return status;
}

static enum vw_status record_plan(struct vw_options *options, const struct vw_setting *setting, struct vw_choice *choice, uint32_t epochs) {
    vw_setting_apply_beside(setting, options, &options->config);
    options->config.epochs = choice->epochs_planned = epochs;
    return write_record(choice,
                        json_pack("{s:s*, s:f, s:s, s:f, s:I, s:I, s:s}", "accuracy", options->accuracy, "budget_s", choice->budget_s,
                                  "setting", setting->name, "step_s", choice->step_s, "epochs_planned", (json_int_t)epochs, "epochs_most",
                                  (json_int_t)choice->epochs_most, "gives_up", setting->gives_up));
}

static enum vw_status choose_budget(struct vw_options *options, struct vw_stage *stage, const struct vw_setting *accuracy,
                                    struct vw_choice *choice) {
    uint32_t count = 1;
    const struct vw_setting *settings = accuracy ? accuracy : vw_settings(&count);
    struct vw_budget_plan chosen = {0};
    uint32_t burn_in = options->config.burn_in_epochs;
    choice->epochs_most = vw_options_have(options, "epochs") ? options->config.epochs : EPOCHS_MOST;
    if (choice->epochs_most <= burn_in)
        return vw_fail(VW_ERROR_USAGE, "--budget: --epochs %u leaves no epoch after --burn-in %u; take more", choice->epochs_most, burn_in);
    enum vw_status status = vw_out_check(options->out);
    if (!status) status = vw_stage_open(options, stage);
    if (!status) status = vw_stage_decide_effects(options, stage);
    if (status) return status;
    vw_choice_foresee_conclusion(options, stage->scene, choice);
    status = plan(options, stage, settings, count, choice, &chosen);
    if (!status) status = record_plan(options, &settings[chosen.rung], choice, chosen.epochs);
    if (status) return status;
    say(choice, &options->config);
    if (chosen.rung == 0 && chosen.epochs < burn_in + EPOCHS_WORTH_IT && chosen.epochs < choice->epochs_most)
        vw_log_warning("--budget %s: there is time for about %u epochs of the cheapest setting, which say little about photos; allow more",
                       options->budget, chosen.epochs);
    return VW_OK;
}

// ---- A run that is gone on with ---------------------------------------------------------------------------------------

static enum vw_status check_same_choice(const struct vw_options *options, double wanted_s, const struct vw_choice *choice) {
    const char *accuracy = text_of(choice->record, "accuracy");
    bool same = !options->budget || wanted_s == choice->budget_s;
    same &= !options->accuracy || (accuracy && strcmp(accuracy, options->accuracy) == 0);
    if (same) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--resume: the run in %s was made with another --accuracy or --budget, or without: leave both out (more --epochs extend "
                   "it), or name another --out",
                   options->out);
}

// The recorded setting, but for what is given; vw_run_row_check_same looks whether that is another.
static enum vw_status take_recorded_setting(struct vw_options *options, const struct vw_ledger_run *run) {
    struct vw_config recorded;
    enum vw_status status = vw_config_from_json(run->config_json, &recorded);
    const struct vw_setting setting = {.rays = recorded.rays,
                                       .samples = recorded.samples,
                                       .val_rays = recorded.val_rays,
                                       .log2_table = recorded.log2_table,
                                       .width = recorded.width,
                                       .epochs = recorded.epochs};
    if (!status) vw_setting_apply_beside(&setting, options, &options->config);
    return status;
}

// --epochs without --budget says how long the run is to be, whatever the time; beside --budget it says how long at most.
static void go_on(struct vw_options *options, uint64_t recorded_steps, struct vw_choice *choice) {
    bool epochs_given = vw_options_have(options, "epochs");
    choice->spent_s = (double)recorded_steps * choice->step_s;
    if (epochs_given && options->budget) choice->epochs_most = options->config.epochs;
    if (epochs_given && !options->budget) choice->budget_s = 0;
    if (choice->budget_s > 0) vw_log_info("budget   %g s, of which earlier steps took about %.1f s", choice->budget_s, choice->spent_s);
}

static enum vw_status take_recorded(struct vw_options *options, const char *ledger_path, double wanted_s, struct vw_choice *choice) {
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run run;
    enum vw_status status = vw_ledger_open(ledger_path, &ledger);
    if (!status) status = vw_ledger_get_run(ledger, &run);
    if (!status) status = read_record(run.choice_json, choice);
    if (!status) status = check_same_choice(options, wanted_s, choice);
    if (!status && json_object_size(choice->record) == 0) vw_choice_free(choice); // nothing was chosen
    else if (!status) status = take_recorded_setting(options, &run);
    uint64_t rows = status ? 0 : vw_ledger_next_step(ledger);
    if (!status && choice->record) go_on(options, rows > 0 ? rows - 1 : 0, choice);
    vw_ledger_close(&ledger);
    return status;
}

// ---- Both -------------------------------------------------------------------------------------------------------------

enum vw_status vw_choice_make(struct vw_options *options, struct vw_stage *stage, struct vw_choice *choice) {
    const struct vw_setting *accuracy = NULL;
    double wanted_s = 0;
    enum vw_status status = find_accuracy(options->accuracy, &accuracy);
    if (!status && options->budget) status = vw_budget_parse(options->budget, &wanted_s);
    if (!status && options->budget && options->config.same_state)
        status = vw_fail(VW_ERROR_USAGE, "--budget cannot stand beside --same-state, whose states lie by --epochs: leave out one of them");
    char *ledger_path = status ? NULL : vw_path_join(options->out, "ledger.db");
    if (!ledger_path) return status ? status : VW_ERROR_MEMORY;
    choice->config = &options->config;
    choice->budget_s = wanted_s;
    if (vw_file_exists(ledger_path)) // which vw_training_open refuses unless it is to be gone on with
        status = options->resume ? take_recorded(options, ledger_path, wanted_s, choice) : VW_OK;
    else if (options->budget) status = choose_budget(options, stage, accuracy, choice);
    else if (accuracy) status = choose_accuracy(options, accuracy, choice);
    if (choice->record) options->choice = choice;
    free(ledger_path);
    return status;
}

void vw_choice_free(struct vw_choice *choice) {
    json_decref(choice->record);
    free(choice->json);
    choice->record = NULL;
    choice->json = NULL;
}

bool vw_choice_clock(const struct vw_options *options) { return options->choice && options->choice->budget_s > 0; }

uint32_t vw_choice_epochs_most(const struct vw_options *options) {
    return vw_choice_clock(options) ? options->choice->epochs_most : options->config.epochs;
}

double vw_choice_left_s(const struct vw_choice *choice, uint64_t steps) {
    double passed_s = vw_now_s() - choice->started_s + choice->spent_s;
    return choice->budget_s - passed_s - choice->conclusion_s - choice->conclusion_step_s * (double)steps;
}

void vw_choice_print(const struct vw_options *options) {
    if (!options->choice) return;
    char text[VW_SETTING_TEXT_BYTES];
    vw_setting_options(&options->config, text);
    if (vw_choice_clock(options))
        printf("budget   %g s; this command took %.1f s\n", options->choice->budget_s, vw_now_s() - options->choice->started_s);
    printf("again    the same bits by %s\n", text);
}

bool vw_choice_add_json(const struct vw_options *options, json_t *root) {
    if (!options->choice) return true;
    char text[VW_SETTING_TEXT_BYTES];
    const json_t *record = options->choice->record;
    vw_setting_options(&options->config, text);
    json_t *object = json_pack("{s:f, s:s}", "took_s", vw_now_s() - options->choice->started_s, "options", text);
    bool failed = !object || json_object_update_missing(object, options->choice->record);
    failed |= json_object_set_new(root, json_object_get(record, "budget_s") ? "budget" : "accuracy", object) != 0;
    return !failed;
}
