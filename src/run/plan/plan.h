// The accuracy level and the epochs that a run chooses before it trains, and the memory and time that it needs,
// estimated from its first steps.
//
// run.plan_json of the ledger contains the choice: field and size (a line each, training_choice.h), where a level was
// asked for accuracy (its name) and trade_off (one line), and with a
// budget budget_s, step_s (seconds that a step was measured to take), epochs_planned and epochs_most. A resumed run
// keeps the recorded level, does not measure again, and counts recorded steps times step_s as time already spent.
// Timing chooses the level and the number of epochs; every step stays deterministic.
#ifndef VIEWWORTH_RUN_PLAN_PLAN_H
#define VIEWWORTH_RUN_PLAN_PLAN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/plan/training_choice.h"
#include "run/session.h"
#include "train/trainer.h"
#include "viewworth/gpu.h"
#include "viewworth/run.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"

struct vw_estimate {
    char missing[200]; // why there is no estimate; "" when there is one, and only host_bytes is valid otherwise
    char device[256];  // that the steps were measured on
    uint64_t param_count, device_bytes;
    uint64_t host_bytes; // for photos, masks, points and tracks
    uint64_t steps;      // steps of a run with the config
    uint64_t measured_steps;
    double seconds_per_step; // mean over measured_steps, validation included
};

// Estimates memory, which is what a trainer allocates, and time, extrapolated from a fraction of a second of steps.
// `estimate` is zero before, except for `missing`, which says why there is no device when `gpu` is NULL. Without a
// device, or when the scene cannot be validated, the estimate stays empty; that is not a failure.
void vw_estimate_run(const struct vw_config *config, const struct vw_scene *scene, struct vw_gpu *gpu,
                     const struct vw_effect_decision *effects, uint32_t effect_count, struct vw_estimate *estimate);
// Creates a trainer, takes steps for a fraction of a second after the first submission, and fills in params,
// device_bytes, steps, measured_steps and seconds_per_step (NaN when the first submission took all steps).
enum vw_status vw_estimate_take_steps(const struct vw_trainer_params *params, struct vw_estimate *estimate);

struct vw_plan {
    double started_s; // vw_now_s() when the run was opened
    json_t *record;   // owned; the content of run.plan_json; NULL: nothing was chosen
    char *json;       // owned; the same as text
    double budget_s;  // 0: the epochs are settled, and no clock is read
    double spent_s;   // part of the budget that earlier commands spent
    double step_s;    // as measured before the run began
    uint32_t epochs_planned, epochs_most;
    double finish_s, finish_step_s; // time to keep for the end of the run: at once, and per step
};

// Chooses, and writes the choice into `config` and `plan`. plan->started_s is set, the rest zero. Opens the session and
// decides effects where steps have to be measured. Does nothing where neither accuracy nor budget_s is given and the
// ledger of a resumed run (NULL: it is new) records no choice. VW_ERROR_USAGE where the params contradict each other or
// the recorded choice, and where the time is too short.
enum vw_status vw_plan_make(const struct vw_run_params *params, struct vw_ledger *recorded, struct vw_session *session,
                            struct vw_config *config, struct vw_plan *plan);
// Adds what was chosen of field and size.
enum vw_status vw_plan_note_choice(const struct vw_training_choice *choice, struct vw_plan *plan);
void vw_plan_free(struct vw_plan *plan);

// Returns whether the run has an accuracy level.
bool vw_plan_has_level(const struct vw_plan *plan);

// Returns whether the run ends by the clock.
bool vw_plan_keeps_time(const struct vw_plan *plan);
// Estimates, once, the time that vw_plan_left_s keeps for finishing a run on that scene.
void vw_plan_estimate_finish(const struct vw_scene *scene, bool no_thumbnails, struct vw_plan *plan);
// Returns the number of epochs that the trainer is made for.
uint32_t vw_plan_epochs_most(const struct vw_plan *plan, const struct vw_config *config);
// Seconds that are left for steps, after `steps` of them, without the time for finishing.
double vw_plan_left_s(const struct vw_plan *plan, uint64_t steps);

// ---- The time budget: pure functions of measured times ----

// Reads a number and its unit, s, min or h, without a space: "90s", "10min", "1.5h". Returns VW_ERROR_USAGE for
// anything else, for less than 10 s and for more than 1000 h.
enum vw_status vw_budget_parse(const char *text, double *budget_s);
enum vw_status vw_budget_check(double budget_s); // VW_ERROR_USAGE unless 10 s to 1000 h

// An accuracy level that may be chosen.
struct vw_budget_candidate {
    double step_s;   // seconds that a step takes, validation included
    uint32_t epochs; // that it wants: it is chosen only where these fit, and burn-in and one
};

struct vw_budget_task {
    double left_s; // for steps
    uint32_t photos;
    uint32_t burn_in_epochs;
    uint32_t epochs_most; // that are to be taken at most; more than burn-in
};

struct vw_budget_plan {
    uint32_t candidate;
    uint32_t epochs; // that fit with it, up to epochs_most
};

// Chooses the most expensive candidate (cheapest first, at least one) that fits; the cheapest if none does.
// VW_ERROR_USAGE, with a remedy, if not even burn-in and one more epoch fit with that.
enum vw_status vw_budget_plan(const struct vw_budget_candidate *candidates, uint32_t count,
                              const struct vw_budget_task *task, struct vw_budget_plan *plan);
// Returns how many epochs of `epoch_s` fit into the time left, at most `most`; 0 when a time is not positive or not
// finite.
uint32_t vw_budget_epochs_that_fit(double left_s, double epoch_s, uint32_t most);
// Returns how many epochs to take before the clock is read again: half of those that fit, at least one, so that the run
// stops rarely while the end is far and ends within one epoch of it. 0: the next epoch would end too late.
uint32_t vw_budget_segment(double left_s, double epoch_s, uint32_t most);

#endif
