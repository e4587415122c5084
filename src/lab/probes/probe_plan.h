// The plan of probes: the states of a run to probe, and how.
#ifndef VIEWWORTH_LAB_PROBES_PROBE_PLAN_H
#define VIEWWORTH_LAB_PROBES_PROBE_PLAN_H

#include "lab/probes/prober.h"

enum {
    VW_PROBE_RESAMPLES = 4,
    VW_PROBES_OF_NOISE = 2 + VW_PROBE_RESAMPLES, // repeated, zero learning rate, resampled: in this order
    // Draws of every photo's pixels at a state. Two are the fewest that tell what the draw does to a score, which is
    // printed beside it; for the same work more states say more than more draws, since the draws of a state share what
    // is peculiar to it.
    VW_SAME_STATE_DRAWS = 2,
};

struct vw_probe_plan {
    struct vw_photo_order *order; // borrowed; that of the run
    uint32_t burn_in_epochs;
    uint32_t epochs;   // that the run has
    uint32_t states;   // from which a step on every photo is taken, at most one per epoch after burn-in; 0: none
    double lengthened; // share of the steps on each photo, in trainings from the end of burn-in on; 0: none
};

// Returns whether all photos are tried on the state after this step: the one at the end of the middle epoch of each of
// `states` nearly equal parts of the epochs after burn-in.
bool vw_probe_state_due(const struct vw_probe_plan *plan, uint64_t step);
// Returns the most probes that a state has.
uint32_t vw_probes_of_state_most(const struct vw_probe_plan *plan);
// Lists the probes to take from the state after `step`, without their results; returns their number. Those of the state
// come first, photo by photo in the order of their views, draw by draw or longer and shorter, then those of the noise
// of the next step.
uint32_t vw_probes_list(const struct vw_probe_plan *plan, uint64_t step, struct vw_probe *probes);

#endif
