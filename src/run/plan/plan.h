// What `value` chooses by --accuracy and --budget before it trains: a preset of the ladder (cli/presets.h), and by
// --budget a time to keep, for which cli/epoch_ends.h looks at the clock.
//
// run.plan_json of the ledger holds what was chosen: preset, trade_off (one line), with --accuracy that name, and with
// --budget budget_s, step_s (seconds a step was measured to take), epochs_planned and epochs_most (at most so many). A
// run that goes on does so with the recorded preset, without measuring again, and counts recorded steps times step_s as
// time already taken.
#ifndef VIEWWORTH_RUN_PLAN_H
#define VIEWWORTH_RUN_PLAN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "cli/options.h"
#include "run/session.h"
#include "viewworth/status.h"

struct vw_plan {
    double started_s;         // vw_now_s() when the command began
    json_t *record;           // owned; what run.plan_json holds
    char *json;               // owned; the same as text
    struct vw_config *config; // of the options that were chosen: its epochs follow the run that keeps a time
    double budget_s;          // 0: the epochs are settled, and no clock is looked at
    double spent_s;           // of the budget, by earlier commands
    double step_s;            // as measured before the run began
    uint32_t epochs_planned, epochs_most;
    double finish_s, finish_step_s; // what is to be kept for the end of the run: at once, and per step
};

// Chooses, and puts into `options` what was chosen, and `plan`, which outlives them, where anything was. `started_s` is
// to be set, the rest zero. Opens the session and decides effects where steps have to be measured. Does nothing where
// neither option is given and --out holds no run that was chosen for. VW_ERROR_USAGE where the options contradict each
// other or the run that is gone on with, and where the time is too short.
enum vw_status vw_plan_make(struct vw_options *options, struct vw_session *session, struct vw_plan *plan);
void vw_plan_free(struct vw_plan *plan);

// Whether the run is to end by the clock.
bool vw_plan_clock(const struct vw_options *options);
// Foresees what finishes a run on that scene, for vw_plan_left_s to keep back; once.
void vw_plan_estimate_finish(const struct vw_options *options, const struct vw_scene *scene, struct vw_plan *plan);
// How many epochs the trainer is made for.
uint32_t vw_plan_epochs_most(const struct vw_options *options);
// Seconds that are left for steps, after `steps` of them, when what finishes the run is kept back.
double vw_plan_left_s(const struct vw_plan *plan, uint64_t steps);

// What it took, and the options that give the same bits again; nothing where nothing was chosen.
void vw_plan_print(const struct vw_options *options);
// The record with took_s and options, as "budget" or "accuracy" into `root`. False when memory is short.
bool vw_plan_add_json(const struct vw_options *options, json_t *root);

#endif
