// What each pass has to load, store and multiply, from the layout alone: what its time is compared with (--profile).
// Everything counts as often as it is asked for, as if nothing stayed in caches (so that gradient_weights, which reads
// its operands many times, may beat a copy), every grid entry as if it had a gradient, and every sample as if none were
// skipped. What is small beside a pass's main traffic is left out, and so are the probes of --noise-floor and
// --same-state, which are steps of their own.
#ifndef VIEWWORTH_TRAIN_PASS_COSTS_H
#define VIEWWORTH_TRAIN_PASS_COSTS_H

#include "train/step.h"
#include "train/trainer.h"
#include "train/validation.h"

struct vw_costed_passes { // all borrowed
    const struct vw_config *config;
    const struct vw_step_passes *step;
    const struct vw_validation *validation;
};

// Appends one, or adds it to that of the same pass; for the fields' own lists.
void vw_pass_cost_add(struct vw_pass_cost *costs, uint32_t *count, struct vw_pass_cost cost);
void vw_pass_costs_list(const struct vw_costed_passes *passes, struct vw_pass_cost costs[VW_PASS_COSTS_MAX],
                        uint32_t *count);

#endif
