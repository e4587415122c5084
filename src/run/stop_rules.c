#include "run/stop_rules.h"

#include <stdlib.h>

#include "run/plan/plan.h"
#include "run/until_stable.h"
#include "run/plan/budget.h"
#include "train/trainer.h"
#include "viewworth/log.h"

static bool has_clock(const struct vw_training_run *run) { return vw_plan_clock(run->options); }
static bool is_held(const struct vw_training_run *run) { return has_clock(run) || run->options->until_stable > 0; }
static uint64_t photos_of(const struct vw_training_run *run) { return vw_trainer_epoch_end(run->trainer, 1); }

// The run is known by the epochs that it is held at. What is recorded of that is written with the next steps.
static enum vw_status tell_epochs(struct vw_training_run *run, uint64_t epochs) {
    if (!has_clock(run)) return VW_OK;
    run->options->plan->config->epochs = (uint32_t)epochs;
    char *config_json = vw_config_to_json(&run->options->config, false);
    if (!config_json) return VW_ERROR_MEMORY;
    enum vw_status status = run->ledger ? vw_ledger_extend(run->ledger, config_json) : VW_OK;
    free(config_json);
    return status;
}

static enum vw_status stop_at(struct vw_training_run *run, uint64_t step) {
    run->segment.first_step = run->statistics.steps;
    run->segment.started_s = vw_now_s();
    vw_trainer_stop_after(run->trainer, step);
    return tell_epochs(run, step / photos_of(run));
}

enum vw_status vw_stop_rules_begin(struct vw_training_run *run) {
    if (has_clock(run))
        vw_plan_estimate_finish(run->options, run->scene, run->options->plan); // of a run that is gone on with, too
    return is_held(run) ? stop_at(run, vw_trainer_epoch_end(run->trainer, run->statistics.steps)) : VW_OK;
}

// As the last segment went, unless it was no whole epoch: the first steps after a start are slow.
static double epoch_seconds(const struct vw_training_run *run) {
    uint64_t steps = run->statistics.steps - run->segment.first_step, photos = photos_of(run);
    if (steps < photos) return (double)photos * run->options->plan->step_s;
    return (vw_now_s() - run->segment.started_s) * (double)photos / (double)steps;
}

// Epochs to take before it is seen again; 0: the run ends.
static uint32_t next_segment(struct vw_training_run *run) {
    uint64_t taken = run->statistics.steps / photos_of(run),
             total = vw_trainer_total_steps(run->trainer) / photos_of(run);
    if (!has_clock(run)) return taken < total;
    struct vw_plan *plan = run->options->plan;
    uint32_t most = (uint32_t)(total - taken), least = run->options->config.burn_in_epochs + 1;
    double epoch_s = epoch_seconds(run) + plan->finish_step_s * (double)photos_of(run),
           left_s = vw_plan_left_s(plan, run->statistics.steps);
    plan->epochs_planned = (uint32_t)taken + vw_budget_epochs_that_fit(left_s, epoch_s, most);
    uint32_t segment = vw_budget_segment(left_s, epoch_s, most);
    if (segment == 0 && taken < least && most > 0) segment = 1; // without which there are no scores at all
    return segment > 1 && run->options->until_stable > 0 ? 1 : segment;
}

enum vw_status vw_stop_rules_pass(struct vw_training_run *run, bool *goes_on) {
    bool stable = false;
    *goes_on = false;
    if (!is_held(run)) return VW_OK;
    enum vw_status status = vw_until_stable_measure(run, &stable);
    uint32_t epochs = status || stable ? 0 : next_segment(run);
    *goes_on = epochs > 0;
    return *goes_on ? stop_at(run, run->statistics.steps + epochs * photos_of(run)) : status;
}

uint64_t vw_stop_rules_expected_steps(const struct vw_training_run *run) {
    uint64_t total = vw_trainer_total_steps(run->trainer);
    if (!has_clock(run)) return total;
    uint64_t planned = run->options->plan->epochs_planned * photos_of(run),
             held = run->options->config.epochs * photos_of(run);
    return planned > held ? planned : held;
}
