// The time budget of a run: pure functions of measured times. They choose the accuracy level and the number of epochs,
// never a bit of a step.
#ifndef VIEWWORTH_RUN_PLAN_BUDGET_H
#define VIEWWORTH_RUN_PLAN_BUDGET_H

#include <stdint.h>

#include "viewworth/status.h"

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
