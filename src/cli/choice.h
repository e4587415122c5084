// What `value` chooses by --accuracy and --budget before it trains: a setting of the ladder (cli/settings.h), and by --budget a time to
// keep, for which cli/epoch_ends.h looks at the clock.
//
// run.choice_json of the ledger holds what was chosen: setting, gives_up (one line), with --accuracy that name, and with --budget budget_s,
// step_s (seconds a step was measured to take), epochs_planned and epochs_most (at most so many). A run that goes on does so with the
// recorded setting, without measuring again, and counts recorded steps times step_s as time already taken.
#ifndef VIEWWORTH_CLI_CHOICE_H
#define VIEWWORTH_CLI_CHOICE_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "cli/options.h"
#include "cli/stage.h"
#include "viewworth/status.h"

struct vw_choice {
    double started_s;         // vw_now_s() when the command began
    json_t *record;           // owned; what run.choice_json holds
    char *json;               // owned; the same as text
    struct vw_config *config; // of the options that were chosen: its epochs follow the run that keeps a time
    double budget_s;          // 0: the epochs are settled, and no clock is looked at
    double spent_s;           // of the budget, by earlier commands
    double step_s;            // as measured before the run began
    uint32_t epochs_planned, epochs_most;
    double conclusion_s, conclusion_step_s; // what is to be kept for the end of the run: at once, and per step
};

// Chooses, and puts into `options` what was chosen, and `choice`, which outlives them, where anything was. `started_s` is to be set, the
// rest zero. Opens the stage and decides effects where steps have to be measured. Does nothing where neither option is given and --out
// holds no run that was chosen for. VW_ERROR_USAGE where the options contradict each other or the run that is gone on with, and where the
// time is too short.
enum vw_status vw_choice_make(struct vw_options *options, struct vw_stage *stage, struct vw_choice *choice);
void vw_choice_free(struct vw_choice *choice);

// Whether the run is to end by the clock.
bool vw_choice_clock(const struct vw_options *options);
// Foresees what concludes a run on that scene, for vw_choice_left_s to keep back; once.
void vw_choice_foresee_conclusion(const struct vw_options *options, const struct vw_scene *scene, struct vw_choice *choice);
// How many epochs the trainer is made for.
uint32_t vw_choice_epochs_most(const struct vw_options *options);
// Seconds that are left for steps, after `steps` of them, when what concludes the run is kept back.
double vw_choice_left_s(const struct vw_choice *choice, uint64_t steps);

// What it took, and the options that give the same bits again; nothing where nothing was chosen.
void vw_choice_print(const struct vw_options *options);
// The record with took_s and options, as "budget" or "accuracy" into `root`. False when memory is short.
bool vw_choice_add_json(const struct vw_options *options, json_t *root);

#endif
