#include "run/plan/budget.h"

#include <ctype.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

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
