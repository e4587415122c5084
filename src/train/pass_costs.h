// The work of each pass (loads, stores, products), from the layout alone, to compare with its time (--profile).
// Everything counts as often as it is asked for, as if nothing stayed in caches (so that gradient_weights, which reads
// its operands many times, may beat a copy), every grid entry as if it had a gradient, and every sample as if none were
// skipped. What is small beside a pass's main traffic is left out.
#ifndef VIEWWORTH_TRAIN_PASS_COSTS_H
#define VIEWWORTH_TRAIN_PASS_COSTS_H

#include <stdint.h>

struct vw_model; // train/model.h

// The work of a pass in one step with its validation, from the sizes alone, to compare its time (vw_gpu_timers) with
// the device's peak throughput.
struct vw_pass_cost {
    const char *name, *role;     // as the timer's
    double dispatches;           // per step, on average
    double multiply_adds, bytes; // float operations; bytes loaded plus stored, gathers counted every time
};
enum { VW_PASS_COSTS_MAX = 48 };
struct vw_pass_costs {
    struct vw_pass_cost list[VW_PASS_COSTS_MAX];
    uint32_t count;
};

// Per sample, and sizes of the model; those of the grid are of the field hash.
struct vw_cost_sizes {
    double samples, rays, encoding4, width4, gathers, pairs;
};
struct vw_cost_sizes vw_cost_sizes_of(const struct vw_model *model, uint32_t rays);

// Appends one, or adds it to that of the same pass.
void vw_pass_cost_add(struct vw_pass_costs *costs, struct vw_pass_cost cost);

#endif
