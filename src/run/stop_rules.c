#include "run/stop_rules.h"

#include <stdlib.h>

#include "base/clock.h"
#include "run/plan/plan.h"

static bool keeps_time(const struct vw_run *run) { return vw_plan_keeps_time(&run->results.plan); }
static bool has_rule(const struct vw_run *run) { return keeps_time(run) || run->results.until_stable > 0; }
static uint64_t photos_of(const struct vw_run *run) { return vw_trainer_epoch_end(run->trainer, 1); }

enum vw_status vw_stop_rules_check(double until_stable) {
    if (until_stable >= 0 && until_stable < 1) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--until-stable takes a rank correlation of 0 (never stop) to below 1, not %g",
                   until_stable);
}

enum vw_status vw_stop_rules_measure_stability(struct vw_run *run, bool *stable) {
    *stable = false;
    if (!(run->results.until_stable > 0)) return VW_OK;
    enum vw_status status = vw_stability_watch_measure(&run->watch, &run->results.stability);
    *stable = !status && vw_stability_reaches(&run->results.stability, run->results.until_stable);
    return status;
}

// Sets the number of epochs, which the ledger gets with the next steps.
static enum vw_status set_epochs(struct vw_run *run, uint64_t epochs) {
    if (!keeps_time(run)) return VW_OK;
    run->config.epochs = (uint32_t)epochs;
    char *config_json = vw_config_to_json(&run->config, false);
    if (!config_json) return VW_ERROR_MEMORY;
    enum vw_status status = run->ledger ? vw_ledger_extend(run->ledger, config_json) : VW_OK;
    free(config_json);
    return status;
}

static enum vw_status stop_next_at(struct vw_run *run, uint64_t step) {
    run->segment.first_step = run->results.statistics.steps;
    run->segment.started_s = vw_now_s();
    run->stop_step = step;
    return set_epochs(run, step / photos_of(run));
}

enum vw_status vw_stop_rules_begin(struct vw_run *run) {
    run->stop_step = vw_trainer_total_steps(run->trainer);
    if (!has_rule(run)) return VW_OK;
    if (keeps_time(run))
        vw_plan_estimate_finish(run->scene, run->report.no_thumbnails, &run->results.plan); // a resumed one has none
    return stop_next_at(run, vw_trainer_epoch_end(run->trainer, run->results.statistics.steps));
}

// Returns the seconds of an epoch at the pace of the last segment, unless it was shorter than an epoch: the first steps
// are slow.
static double epoch_seconds(const struct vw_run *run) {
    uint64_t steps = run->results.statistics.steps - run->segment.first_step, photos = photos_of(run);
    if (steps < photos) return (double)photos * run->results.plan.step_s;
    return (vw_now_s() - run->segment.started_s) * (double)photos / (double)steps;
}

// Epochs to take before the next look; 0: the run ends.
static uint32_t next_segment(struct vw_run *run) {
    uint64_t taken = run->results.statistics.steps / photos_of(run),
             total = vw_trainer_total_steps(run->trainer) / photos_of(run);
    if (!keeps_time(run)) return taken < total;
    struct vw_plan *plan = &run->results.plan;
    uint32_t most = (uint32_t)(total - taken), least = run->config.burn_in_epochs + 1;
    double epoch_s = epoch_seconds(run) + plan->finish_step_s * (double)photos_of(run),
           left_s = vw_plan_left_s(plan, run->results.statistics.steps);
    plan->epochs_planned = (uint32_t)taken + vw_budget_epochs_that_fit(left_s, epoch_s, most);
    uint32_t segment = vw_budget_segment(left_s, epoch_s, most);
    if (segment == 0 && taken < least && most > 0) segment = 1; // without which there are no scores at all
    return segment > 1 && run->results.until_stable > 0 ? 1 : segment;
}

enum vw_status vw_stop_rules_pass(struct vw_run *run, bool *continues) {
    bool stable = false;
    *continues = false;
    if (!has_rule(run)) return VW_OK;
    enum vw_status status = vw_stop_rules_measure_stability(run, &stable);
    uint32_t epochs = status || stable ? 0 : next_segment(run);
    *continues = epochs > 0;
    return *continues ? stop_next_at(run, run->results.statistics.steps + epochs * photos_of(run)) : status;
}

uint64_t vw_stop_rules_expected_steps(const struct vw_run *run) {
    uint64_t total = vw_trainer_total_steps(run->trainer);
    if (!keeps_time(run)) return total;
    uint64_t planned = run->results.plan.epochs_planned * photos_of(run), decided = run->config.epochs * photos_of(run);
    return planned > decided ? planned : decided;
}
