#include "cli/epoch_ends.h"

#include <stdlib.h>

#include "cli/choice.h"
#include "cli/until_stable.h"
#include "viewworth/budget.h"
#include "viewworth/log.h"

static bool has_clock(const struct vw_training_run *run) { return vw_choice_clock(run->options); }
static bool is_held(const struct vw_training_run *run) { return has_clock(run) || run->options->until_stable > 0; }
static uint64_t photos_of(const struct vw_training_run *run) { return vw_trainer_epoch_end(run->trainer, 1); }

// The run is known by the epochs that it is held at. What is recorded of that is written with the next steps.
static enum vw_status tell_epochs(struct vw_training_run *run, uint64_t epochs) {
    if (!has_clock(run)) return VW_OK;
    run->options->choice->config->epochs = (uint32_t)epochs;
    char *config_json = vw_config_to_json(&run->options->config, false);
    if (!config_json) return VW_ERROR_MEMORY;
    enum vw_status status = run->ledger ? vw_ledger_extend(run->ledger, config_json) : VW_OK;
    free(config_json);
    return status;
}

static enum vw_status hold_at(struct vw_training_run *run, uint64_t step) {
    run->stretch.first_step = run->tally.steps;
    run->stretch.started_s = vw_now_s();
    vw_trainer_hold_after(run->trainer, step);
    return tell_epochs(run, step / photos_of(run));
}

enum vw_status vw_epoch_ends_begin(struct vw_training_run *run) {
    if (has_clock(run)) vw_choice_foresee_conclusion(run->options, run->scene, run->options->choice); // of a run that is gone on with, too
    return is_held(run) ? hold_at(run, vw_trainer_epoch_end(run->trainer, run->tally.steps)) : VW_OK;
}

// As the last stretch went, unless it was no whole epoch: the first steps after a start are slow.
static double epoch_seconds(const struct vw_training_run *run) {
    uint64_t steps = run->tally.steps - run->stretch.first_step, photos = photos_of(run);
    if (steps < photos) return (double)photos * run->options->choice->step_s;
    return (vw_now_s() - run->stretch.started_s) * (double)photos / (double)steps;
}

// Epochs to take before it is seen again; 0: the run ends.
static uint32_t next_stretch(struct vw_training_run *run) {
    uint64_t taken = run->tally.steps / photos_of(run), total = vw_trainer_total_steps(run->trainer) / photos_of(run);
    if (!has_clock(run)) return taken < total;
    struct vw_choice *choice = run->options->choice;
    uint32_t most = (uint32_t)(total - taken), least = run->options->config.burn_in_epochs + 1;
    double epoch_s = epoch_seconds(run) + choice->conclusion_step_s * (double)photos_of(run),
           left_s = vw_choice_left_s(choice, run->tally.steps);
    choice->epochs_planned = (uint32_t)taken + vw_budget_epochs_that_fit(left_s, epoch_s, most);
    uint32_t stretch = vw_budget_stretch(left_s, epoch_s, most);
    if (stretch == 0 && taken < least && most > 0) stretch = 1; // without which there are no scores at all
    return stretch > 1 && run->options->until_stable > 0 ? 1 : stretch;
}

enum vw_status vw_epoch_ends_pass(struct vw_training_run *run, bool *goes_on) {
    bool stable = false;
    *goes_on = false;
    if (!is_held(run)) return VW_OK;
    enum vw_status status = vw_until_stable_measure(run, &stable);
    uint32_t epochs = status || stable ? 0 : next_stretch(run);
    *goes_on = epochs > 0;
    return *goes_on ? hold_at(run, run->tally.steps + epochs * photos_of(run)) : status;
}

uint64_t vw_epoch_ends_foreseen(const struct vw_training_run *run) {
    uint64_t total = vw_trainer_total_steps(run->trainer);
    if (!has_clock(run)) return total;
    uint64_t planned = run->options->choice->epochs_planned * photos_of(run), held = run->options->config.epochs * photos_of(run);
    return planned > held ? planned : held;
}
