// First-order credit (`value --first-order`): how validation would change along a step if it kept the slope that it has
// where the step starts: the dot product of the step with the measure's gradient. It is taken as a central difference
// on the line through the params before and behind the step, by two more validations and no way back, all on the
// device. Then the params behind the step are restored, as a copy.
#ifndef VIEWWORTH_TRAIN_FIRST_ORDER_H
#define VIEWWORTH_TRAIN_FIRST_ORDER_H

#include "train/probes/probe_context.h"

enum { FIRST_ORDER_MEASUREMENTS = 2 }; // ahead of where the step starts, and behind

// How far from there, as a share of the step. Nearer, what rounding does to the params and to the sums over pixels
// counts for more; farther, the measures' curvature and the kinks of ReLUs and of the absolute error. Misfit to the
// reference's gradient, root mean square over 18 early steps of a small field, in percent of the slope of PSNR | of L1:
//     learning rate   reach 1/2     1/4           1/8           1/16          1/32          1/64
//     1e-2            2.4  | 5.1    0.84 | 3.6    0.77 | 2.1    0.75 | 1.7    0.46 | 1.3    0.17 | 0.87
//     3e-3            0.24 | 2.4    0.07 | 2.4    0.03 | 1.4    0.02 | 0.69   0.02 | 0.40   0.01 | 0.31
//     3e-4            0.27 | 0.30   0.12 | 0.17   0.07 | 0.09   0.06 | 0.06   0.06 | 0.07   0.09 | 0.11
//     3e-5            0.28 | 0.29   0.15 | 0.16   0.16 | 0.14   0.32 | 0.38   0.46 | 0.50   0.94 | 0.81
extern const float first_order_reach;

struct first_order {
    const struct field *field;        // borrowed
    struct vw_buffer *before, *after; // the params
    struct vw_pass **mix;             // per window
    uint64_t window_bytes;
    uint32_t window_count;
};

// `binding_bytes`: the largest range that a binding may have; params beyond it are mixed window by window.
enum vw_status first_order_create(const struct field *field, uint64_t binding_bytes, struct first_order **first_order);
void first_order_destroy(struct first_order **first_order);

// With --first-order, every step behind burn-in.
bool first_order_due(const struct probe_context *context, uint64_t step);

// To be recorded before the step, and behind it and its own validation. The measurements go to scalars[scalar_row] and
// on.
void first_order_record_begin(const struct first_order *first_order, struct vw_batch *batch);
void first_order_record_end(const struct first_order *first_order, const struct probe_context *context,
                            struct vw_batch *batch, uint32_t scalar_row);

// `rows`: the measurements. NaN where the step was `skipped` or a measurement is not finite.
void first_order_read(const struct probe_context *context, const vw_float4 *rows, bool skipped, struct vw_probe *probe);

// Records params = before + reach * (after - before).
void first_order_record_mix(const struct first_order *first_order, struct vw_batch *batch, float reach);

#endif
