// First-order credit (`value --first-order`): how validation would change along a step if it kept the slope that it has where the step starts:
// the dot product of the step with the measure's gradient. It is taken as a central difference on the line through the params before and
// behind the step, by two more validations and no way back, all on the device. Then the params behind the step are put back, as a copy.
#ifndef VIEWWORTH_TRAIN_FIRST_ORDER_H
#define VIEWWORTH_TRAIN_FIRST_ORDER_H

#include "field.h"

struct vw_trainer;
struct vw_probe;

enum { FIRST_ORDER_MEASUREMENTS = 2 }; // ahead of where the step starts, and behind

// How far from there, as a share of the step. Nearer, the rounding of the params and of the sums over pixels grows; farther, the measures' curvature
// and the kinks of ReLUs. Misfit to the twin's gradient by reach: see tests/train/test_first_order.c.
extern const float first_order_reach;

struct first_order {
    const struct field *field;         // borrowed
    struct vw_buffer *before, *after;  // the params
    struct vw_pass **mix;              // per window, so that each binding fits the device's range
    uint64_t window_bytes;
    uint32_t window_count;
};

enum vw_status first_order_create(const struct field *field, struct first_order **first_order);
void first_order_destroy(struct first_order **first_order);

// Every step behind burn-in.
bool first_order_due(const struct vw_trainer *trainer, uint64_t step);

// To be recorded before the step, and behind it and its own validation. The measurements go to scalars[scalar_row] and on.
void first_order_record_begin(const struct first_order *first_order, struct vw_batch *batch);
void first_order_record_end(const struct vw_trainer *trainer, struct vw_batch *batch, uint32_t scalar_row);

// `rows`: the measurements. NaN where the step was `skipped` or a measurement is not finite.
void first_order_read(const struct vw_trainer *trainer, const vw_float4 *rows, bool skipped, struct vw_probe *probe);

// Records params = before + reach * (after - before).
void first_order_record_mix(const struct first_order *first_order, struct vw_batch *batch, float reach);

#endif
