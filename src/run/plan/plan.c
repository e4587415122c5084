#include "run/plan/plan.h"

#include <ctype.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/json.h"
#include "base/memory.h"
#include "run/outputs/reconstruction.h"
#include "run/outputs/residuals.h"
#include "run/outputs/thumbnails.h"
#include "run/plan/accuracy_levels.h"
#include "run/scoring.h"
#include "train/trainer.h"
#include "viewworth/ledger.h"
#include "viewworth/log.h"

// ---- Estimates ----------------------------------------------------------------------------------------------------

static const double MEASURED_SECONDS = 0.3;

static uint64_t count_host_bytes(const struct vw_scene *scene) {
    static const uint64_t channel_bytes[] = {[VW_PIXEL_UINT8] = 1, [VW_PIXEL_UINT16] = 2, [VW_PIXEL_FLOAT32] = 4};
    uint64_t sum = scene->point_count * sizeof *scene->points + scene->track_count * sizeof *scene->tracks;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_view *view = &scene->views[v];
        uint64_t pixels = (uint64_t)view->image.width_px * view->image.height_px; // 0 of excluded photos
        sum += pixels * (4 * channel_bytes[view->image.format] + (view->mask ? 1 : 0));
    }
    return sum;
}

// Times the steps after the first submission, which warms up.
static enum vw_status measure(struct vw_trainer *trainer, struct vw_estimate *estimate) {
    const struct vw_step_record *records = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_trainer_advance(trainer, &records, &count);
    double started_s = vw_now_s(), passed_s = 0;
    while (!status && count > 0 && passed_s < MEASURED_SECONDS) {
        status = vw_trainer_advance(trainer, &records, &count);
        passed_s = vw_now_s() - started_s;
        estimate->measured_steps += count;
    }
    estimate->seconds_per_step = estimate->measured_steps ? passed_s / (double)estimate->measured_steps : NAN;
    return status;
}

enum vw_status vw_estimate_take_steps(const struct vw_trainer_params *params, struct vw_estimate *estimate) {
    struct vw_trainer *trainer = NULL;
    struct vw_trainer_stats stats;
    enum vw_status status = vw_trainer_create(params, &trainer);
    if (status) return status;
    vw_trainer_get_stats(trainer, &stats);
    estimate->param_count = stats.param_count;
    estimate->device_bytes = stats.device_bytes;
    estimate->steps = vw_trainer_total_steps(trainer);
    status = measure(trainer, estimate);
    vw_trainer_destroy(&trainer);
    return status;
}

void vw_estimate_run(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                     const struct vw_effect_decision *effects, uint32_t effect_count, struct vw_estimate *estimate) {
    estimate->host_bytes = count_host_bytes(scene);
    if (!gpu) return;
    snprintf(estimate->device, sizeof estimate->device, "%s", vw_gpu_get_info(gpu)->name);
    const struct vw_trainer_params params = {.gpu = gpu,
                                             .scene = scene,
                                             .config = config,
                                             .effects = effects,
                                             .effect_count = effect_count,
                                             .validate = true};
    if (vw_estimate_take_steps(&params, estimate))
        snprintf(estimate->missing, sizeof estimate->missing, "%.*s", (int)sizeof estimate->missing - 1,
                 vw_error_message());
}

enum {
    CANDIDATES_MAX = 16,
    EPOCHS_MOST = 1000000000, // as --epochs
    EPOCHS_WORTH_IT = 5,      // after burn-in; with fewer, scores say little
};
// Time at the end of a run that cannot be measured beforehand: field, scores, tables and reading the ledger's rows.
static const double FINISH_S = 0.3, ROW_S = 4e-6;
// Share of the budget after which no further level is measured.
static const double MEASURING_SHARE = 0.1;

// ---- Budgets -------------------------------------------------------------------------------------------------------

static const double LEAST_S = 10, MOST_S = 3600e3;

static const struct {
    const char *name;
    double seconds;
} units[] = {{"s", 1}, {"min", 60}, {"h", 3600}};

enum vw_status vw_budget_parse(const char *text, double *budget_s) {
    // Only digits and a point: strtod knows nan, inf, hexadecimal numbers and exponents, too.
    size_t length = strspn(text, "0123456789.");
    char *end = NULL;
    double number = isdigit((unsigned char)text[0]) ? strtod(text, &end) : NAN, parsed_s = NAN;
    for (size_t i = 0; end == text + length && i < VW_ARRAY_COUNT(units); i++)
        if (strcmp(end, units[i].name) == 0) parsed_s = number * units[i].seconds;
    if (end && !*end)
        return vw_fail(VW_ERROR_USAGE, "--budget takes a time with its unit, s, min or h: is \"%s\" %ss or %smin?",
                       text, text, text);
    if (isnan(parsed_s))
        return vw_fail(VW_ERROR_USAGE, "--budget takes a time as 90s, 10min or 1.5h, not \"%s\"", text);
    enum vw_status status = vw_budget_check(parsed_s);
    if (!status) *budget_s = parsed_s;
    return status;
}

enum vw_status vw_budget_check(double budget_s) {
    if (budget_s >= LEAST_S && budget_s <= MOST_S) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--budget takes %gs to %gh, not %gs", LEAST_S, MOST_S / 3600, budget_s);
}

uint32_t vw_budget_epochs_that_fit(double left_s, double epoch_s, uint32_t most) {
    if (!isfinite(left_s) || !isfinite(epoch_s) || left_s <= 0 || epoch_s <= 0) return 0;
    double fit = floor(left_s / epoch_s);
    return fit < most ? (uint32_t)fit : most;
}

uint32_t vw_budget_segment(double left_s, double epoch_s, uint32_t most) {
    uint32_t fit = vw_budget_epochs_that_fit(left_s, epoch_s, most);
    return fit > 1 ? fit / 2 : fit;
}

enum vw_status vw_budget_plan(const struct vw_budget_candidate *candidates, uint32_t count,
                              const struct vw_budget_task *task, struct vw_budget_plan *plan) {
    uint32_t least = task->burn_in_epochs + 1;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t fit = vw_budget_epochs_that_fit(task->left_s, candidates[i].step_s * task->photos, task->epochs_most);
        if (i == 0 || (fit >= least && fit >= candidates[i].epochs)) *plan = (struct vw_budget_plan){i, fit};
    }
    if (plan->epochs >= least) return VW_OK;
    double missing_s = least * candidates[0].step_s * task->photos - task->left_s;
    return vw_fail(VW_ERROR_USAGE,
                   "--budget: too short by %.0f s for the %u epochs that scores need, at %.3g ms a step; allow more "
                   "time, choose fewer "
                   "photos by --train, or lower --rays",
                   ceil(missing_s), least, 1e3 * candidates[0].step_s);
}

// ---- The record ----------------------------------------------------------------------------------------------------

static enum vw_status write_record(struct vw_plan *plan, json_t *record) {
    plan->record = record;
    plan->json = vw_json_to_text(record, JSON_COMPACT);
    return plan->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for the plan");
}

static double number_of(const json_t *record, const char *key) {
    return json_number_value(json_object_get(record, key));
}
static const char *text_of(const json_t *record, const char *key) {
    return json_string_value(json_object_get(record, key));
}

// Reads the record, which another version may have made.
static enum vw_status read_record(const char *json, struct vw_plan *plan) {
    plan->record = vw_json_load(json, strlen(json), 0, NULL);
    double planned = number_of(plan->record, "epochs_planned"), most = number_of(plan->record, "epochs_most");
    if (!json_is_object(plan->record) || !(planned >= 0 && planned <= EPOCHS_MOST) ||
        !(most >= 0 && most <= EPOCHS_MOST))
        return vw_fail(VW_ERROR_INPUT, "run.plan_json of the ledger: \"%.100s\" is not a plan; make the run again",
                       json);
    plan->budget_s = number_of(plan->record, "budget_s");
    plan->step_s = number_of(plan->record, "step_s");
    plan->epochs_planned = (uint32_t)planned;
    plan->epochs_most = (uint32_t)most;
    plan->json = vw_json_to_text(plan->record, JSON_COMPACT);
    return plan->json ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for the plan");
}

// ---- A new run -----------------------------------------------------------------------------------------------------

static void log_plan(const struct vw_plan *plan, const struct vw_config *config) {
    char text[VW_ACCURACY_TEXT_BYTES], lead[40];
    const char *trade_off = text_of(plan->record, "trade_off");
    snprintf(lead, sizeof lead, plan->budget_s > 0 ? "budget   %g s: " : "accuracy ", plan->budget_s);
    vw_accuracy_options(config, text);
    vw_log_info("%s%s (%s)", lead, text_of(plan->record, "accuracy"), text);
    if (plan->budget_s > 0)
        vw_log_info("         about %u epochs at %.3g ms a step", plan->epochs_planned, 1e3 * plan->step_s);
    if (*trade_off) vw_log_info("         trade-off: %s", trade_off);
}

static enum vw_status choose_level(const struct vw_run_params *params, struct vw_config *config, struct vw_plan *plan) {
    uint32_t level = 0;
    enum vw_status status = vw_accuracy_find(params->accuracy, &level);
    if (!status) vw_accuracy_apply(level, params->explicit_fields, config);
    if (!status) status = vw_config_check(config);
    const struct vw_accuracy_about *about = status ? NULL : vw_accuracy_level_about(level);
    if (!status)
        status = write_record(plan, json_pack("{s:s, s:s}", "accuracy", about->name, "trade_off", about->trade_off));
    if (!status) log_plan(plan, config);
    return status;
}

// Times the first steps of a trainer.
static enum vw_status time_level(const struct vw_config *level, const struct vw_session *session, double *step_s) {
    struct vw_config config = *level;
    struct vw_estimate estimate = {0};
    config.epochs = EPOCHS_MOST;
    enum vw_status status = vw_config_check(&config);
    if (!status)
        status = vw_estimate_take_steps(&(struct vw_trainer_params){.gpu = session->devices[0].gpu,
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

void vw_plan_estimate_finish(const struct vw_scene *scene, bool no_thumbnails, struct vw_plan *plan) {
    if (plan->finish_s > 0) return;
    plan->finish_s = FINISH_S + (no_thumbnails ? 0 : vw_thumbnails_estimate_s(scene));
    plan->finish_step_s = ROW_S * (2 + scene->split_count[VW_SPLIT_VAL]);
}

// The candidates of a budget, and the steps that are timed for it.
struct choice {
    const struct vw_run_params *params;
    const struct vw_session *session;
    const struct vw_config *config; // without a level
    uint32_t first, count;          // levels
    struct vw_budget_candidate candidates[CANDIDATES_MAX];
    struct vw_budget_plan chosen;
};

// Plans with the first `count` candidates.
static enum vw_status plan_among(const struct choice *choice, uint32_t count, const struct vw_plan *plan,
                                 struct vw_budget_plan *chosen) {
    const struct vw_budget_task task = {.left_s = vw_plan_left_s(plan, 0),
                                        .photos = choice->session->scene->split_count[VW_SPLIT_TRAIN],
                                        .burn_in_epochs = choice->config->burn_in_epochs,
                                        .epochs_most = plan->epochs_most};
    return vw_budget_plan(choice->candidates, count, &task, chosen);
}

// Returns whether to time this candidate: it would have to fit if it cost no more than the next cheaper one, and timing
// must leave time for the run (compiling shaders may take long).
static bool is_worth_measuring(struct choice *choice, uint32_t candidate, const struct vw_plan *plan, double begun_s) {
    struct vw_budget_plan hoped = {0};
    if (candidate == 0) return true;
    choice->candidates[candidate].step_s = choice->candidates[candidate - 1].step_s;
    return vw_now_s() - begun_s < MEASURING_SHARE * plan->budget_s &&
           !plan_among(choice, candidate + 1, plan, &hoped) && hoped.candidate == candidate;
}

// Times the levels from the cheapest on, until one is too expensive.
static enum vw_status choose_candidate(struct choice *choice, struct vw_plan *plan) {
    double begun_s = vw_now_s();
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && choice->chosen.candidate + 1 >= i && i < choice->count && i < CANDIDATES_MAX; i++) {
        struct vw_config config = *choice->config;
        vw_accuracy_apply(choice->first + i, choice->params->explicit_fields, &config);
        uint32_t wanted = vw_accuracy_level_about(choice->first + i)->budget_epochs;
        struct vw_budget_candidate *candidate = &choice->candidates[i];
        *candidate = (struct vw_budget_candidate){.epochs = wanted < plan->epochs_most ? wanted : plan->epochs_most};
        if (!is_worth_measuring(choice, i, plan, begun_s)) return VW_OK;
        status = time_level(&config, choice->session, &candidate->step_s);
        if (status && i > 0) return VW_OK; // as where the device has no room for it
        candidate->step_s += plan->finish_step_s;
        struct vw_budget_plan found = choice->chosen;
        if (!status) status = plan_among(choice, i + 1, plan, &found);
        if (status && i > 0) return VW_OK; // measuring took what time there was: the plan stays
        if (!status) choice->chosen = found;
        if (!status) plan->step_s = choice->candidates[choice->chosen.candidate].step_s - plan->finish_step_s;
    }
    return status;
}

static enum vw_status record_plan(const struct choice *choice, struct vw_config *config, struct vw_plan *plan) {
    const uint32_t level = choice->first + choice->chosen.candidate;
    const struct vw_accuracy_about *about = vw_accuracy_level_about(level);
    vw_accuracy_apply(level, choice->params->explicit_fields, config);
    config->epochs = plan->epochs_planned = choice->chosen.epochs;
    vw_config_settle_decay(config);
    return write_record(plan,
                        json_pack("{s:s, s:f, s:f, s:I, s:I, s:s}", "accuracy", about->name, "budget_s", plan->budget_s,
                                  "step_s", plan->step_s, "epochs_planned", (json_int_t)config->epochs, "epochs_most",
                                  (json_int_t)plan->epochs_most, "trade_off", about->trade_off));
}

static void warn_of_few_epochs(const struct choice *choice, const struct vw_plan *plan) {
    uint32_t epochs = choice->chosen.epochs;
    if (choice->chosen.candidate > 0 || epochs >= choice->config->burn_in_epochs + EPOCHS_WORTH_IT ||
        epochs >= plan->epochs_most)
        return;
    vw_log_warning(
        "--budget %gs: there is time for about %u epochs of the cheapest accuracy level, which say little about "
        "photos; allow more",
        plan->budget_s, epochs);
}

static enum vw_status choose_budget(const struct vw_run_params *params, struct vw_session *session,
                                    struct vw_config *config, struct vw_plan *plan) {
    const struct vw_session_params of_session = {
        .scene = params->scene, .devices.first = params->device, .timers = params->profile};
    const struct vw_config base = *config;
    struct choice choice = {.params = params, .session = session, .config = &base, .count = 1};
    enum vw_status status = VW_OK;
    if (params->accuracy) status = vw_accuracy_find(params->accuracy, &choice.first);
    else choice.count = vw_accuracy_level_count();
    plan->epochs_most = params->explicit_fields & vw_config_explicit("epochs") ? config->epochs : EPOCHS_MOST;
    if (!status) status = vw_check_scored_epochs(plan->epochs_most, config->burn_in_epochs);
    if (!status) status = vw_session_open(&of_session, session);
    if (!status) status = vw_session_decide_effects(config, session);
    if (status) return status;
    vw_plan_estimate_finish(session->scene, params->report.no_thumbnails, plan);
    status = choose_candidate(&choice, plan);
    plan->finish_step_s += (params->report.no_thumbnails ? 1 : 2) * VW_RESIDUALS_SHARE * plan->step_s;
    if (!status) status = record_plan(&choice, config, plan);
    if (status) return status;
    // A train ray counts three times, since it goes back as well.
    plan->finish_s += plan->step_s / (3.0 * config->rays + config->val_rays) *
                      vw_reconstruction_rays(session->scene, params->scene.downscale);
    log_plan(plan, config);
    warn_of_few_epochs(&choice, plan);
    return VW_OK;
}

// ---- A resumed run -------------------------------------------------------------------------------------------------

static enum vw_status check_same_choice(const struct vw_run_params *params, const struct vw_plan *plan) {
    const char *accuracy = text_of(plan->record, "accuracy");
    bool same = params->budget_s == 0 || params->budget_s == plan->budget_s;
    same &= !params->accuracy || (accuracy && strcmp(accuracy, params->accuracy) == 0);
    if (same) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "--resume: the run in %s was made with another --accuracy or --budget, or without: leave both out "
                   "(more --epochs extend it), or name another --out",
                   params->out);
}

// Takes the recorded level, except for explicit fields; vw_run_row_check_same checks those.
static enum vw_status take_recorded_config(const struct vw_run_params *params, const struct vw_ledger_run *run,
                                           struct vw_config *config) {
    struct vw_config recorded;
    enum vw_status status = vw_config_from_json(run->config_json, &recorded);
    if (!status) vw_accuracy_copy(&recorded, params->explicit_fields, config);
    return status;
}

// Epochs without a budget say how long the run is to be, whatever the time; with a budget, how long at most.
static void continue_plan(const struct vw_run_params *params, uint64_t recorded_steps, struct vw_plan *plan) {
    bool explicit_epochs = params->explicit_fields & vw_config_explicit("epochs");
    uint32_t epochs = params->config ? params->config->epochs : vw_config_default.epochs;
    plan->spent_s = (double)recorded_steps * plan->step_s;
    if (explicit_epochs && params->budget_s > 0) plan->epochs_most = epochs;
    if (explicit_epochs && params->budget_s == 0) plan->budget_s = 0;
    if (plan->budget_s > 0)
        vw_log_info("budget   %g s, of which earlier steps took about %.1f s", plan->budget_s, plan->spent_s);
}

static enum vw_status take_recorded(const struct vw_run_params *params, struct vw_ledger *ledger,
                                    struct vw_config *config, struct vw_plan *plan) {
    struct vw_ledger_run run;
    enum vw_status status = vw_ledger_get_run(ledger, &run);
    if (!status) status = read_record(run.plan_json, plan);
    if (!status) status = check_same_choice(params, plan);
    if (!status && json_object_size(plan->record) == 0) vw_plan_free(plan); // nothing was chosen
    else if (!status && vw_plan_has_level(plan)) status = take_recorded_config(params, &run, config);
    uint64_t rows = status ? 0 : vw_ledger_next_step(ledger);
    if (!status && plan->record) continue_plan(params, rows > 0 ? rows - 1 : 0, plan);
    return status;
}

// ---- Both ----------------------------------------------------------------------------------------------------------

enum vw_status vw_plan_make(const struct vw_run_params *params, struct vw_ledger *recorded, struct vw_session *session,
                            struct vw_config *config, struct vw_plan *plan) {
    plan->budget_s = params->budget_s;
    if (recorded) return take_recorded(params, recorded, config, plan);
    if (params->budget_s > 0) return choose_budget(params, session, config, plan);
    return params->accuracy ? choose_level(params, config, plan) : VW_OK;
}

enum vw_status vw_plan_note_choice(const struct vw_training_choice *choice, struct vw_plan *plan) {
    json_t *record = plan->record ? plan->record : json_object();
    if (*choice->field) vw_json_set(&record, "field", vw_json_string(choice->field));
    if (*choice->size) vw_json_set(&record, "size", vw_json_string(choice->size));
    free(plan->json);
    return write_record(plan, record);
}

bool vw_plan_has_level(const struct vw_plan *plan) { return plan->record && text_of(plan->record, "accuracy"); }

void vw_plan_free(struct vw_plan *plan) {
    json_decref(plan->record);
    free(plan->json);
    plan->record = NULL;
    plan->json = NULL;
}

bool vw_plan_keeps_time(const struct vw_plan *plan) { return plan->record && plan->budget_s > 0; }

uint32_t vw_plan_epochs_most(const struct vw_plan *plan, const struct vw_config *config) {
    return vw_plan_keeps_time(plan) ? plan->epochs_most : config->epochs;
}

double vw_plan_left_s(const struct vw_plan *plan, uint64_t steps) {
    double passed_s = vw_now_s() - plan->started_s + plan->spent_s;
    return plan->budget_s - passed_s - plan->finish_s - plan->finish_step_s * (double)steps;
}
