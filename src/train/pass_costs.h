// The work of each pass (loads, stores, products), from the layout alone, to compare with its time (--profile).
// Everything counts as often as it is asked for, as if nothing stayed in caches (so that gradient_weights, which reads
// its operands many times, may beat a copy), every grid entry as if it had a gradient, and every sample as if none were
// skipped. What is small beside a pass's main traffic is left out.
#ifndef VIEWWORTH_TRAIN_PASS_COSTS_H
#define VIEWWORTH_TRAIN_PASS_COSTS_H

#include "train/step.h"
#include "train/trainer.h"
#include "train/validation/validation.h"

struct vw_costed_passes { // all borrowed
    const struct vw_config *config;
    const struct vw_step_passes *step;
    const struct vw_validation *validation;
};

// Per sample, and sizes of the model; those of the grid are of the field hash.
struct vw_cost_sizes {
    double samples, rays, encoding4, width4, gathers, pairs, pair_bytes;
};
struct vw_cost_sizes vw_cost_sizes_of(const struct vw_model *model, uint32_t rays);

// Appends one, or adds it to that of the same pass; for the lists of fields and effects.
void vw_pass_cost_add(struct vw_pass_cost *costs, uint32_t *count, struct vw_pass_cost cost);
// Adds what it takes to place importance samples by the even samples of `rays`. `trains`: where there is a coarse
// network, it learns by them.
void vw_pass_costs_add_placing(const struct vw_model *model, double rays, uint32_t chunks, const char *role,
                               bool trains, struct vw_pass_cost *costs, uint32_t *count);
void vw_pass_costs_list(const struct vw_costed_passes *passes, struct vw_pass_cost costs[VW_PASS_COSTS_MAX],
                        uint32_t *count);

#endif
