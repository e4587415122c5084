// The accuracy level and the epochs that a run chooses before it trains.
//
// run.plan_json of the ledger contains the choice: accuracy (the name of the level), trade_off (one line), and with a
// budget budget_s, step_s (seconds that a step was measured to take), epochs_planned and epochs_most. A resumed run
// keeps the recorded level, does not measure again, and counts recorded steps times step_s as time already spent.
// Timing chooses the level and the number of epochs; every step stays deterministic.
#ifndef VIEWWORTH_RUN_PLAN_PLAN_H
#define VIEWWORTH_RUN_PLAN_PLAN_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "run/session.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

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
void vw_plan_free(struct vw_plan *plan);

// Returns whether the run ends by the clock.
bool vw_plan_keeps_time(const struct vw_plan *plan);
// Estimates, once, the time that vw_plan_left_s keeps for finishing a run on that scene.
void vw_plan_estimate_finish(const struct vw_scene *scene, bool no_thumbnails, struct vw_plan *plan);
// Returns the number of epochs that the trainer is made for.
uint32_t vw_plan_epochs_most(const struct vw_plan *plan, const struct vw_config *config);
// Seconds that are left for steps, after `steps` of them, without the time for finishing.
double vw_plan_left_s(const struct vw_plan *plan, uint64_t steps);

#endif
