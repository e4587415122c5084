#include "lab/probes/probe_plan.h"

enum { NOISE_EPOCHS = 8 }; // an eighth of the steps, each costing about seven: probing takes nearly as long as the run

// Returns whether a step is probed for noise: every photo's steps are, in one epoch of eight from burn-in on, and the
// photos alternate.
static bool is_probed_for_noise(const struct vw_probe_plan *plan, uint64_t step) {
    uint32_t epoch = vw_photo_order_epoch_of_step(plan->order, step);
    return step > 0 && epoch >= plan->burn_in_epochs && epoch < plan->epochs &&
           (epoch + vw_photo_order_photo_of_step(plan->order, step)) % NOISE_EPOCHS == 0;
}

// Returns how many of the middles (2 i + 1) counted / (2 states), i = 0, 1, ..., are before the beginning of epoch
// `place` of those that are counted.
static uint64_t middles_before(uint64_t states, uint64_t counted, uint64_t place) {
    return (2 * states * place + counted - 1) / (2 * counted);
}

bool vw_probe_state_due(const struct vw_probe_plan *plan, uint64_t step) {
    uint32_t epoch = vw_photo_order_epoch_of_step(plan->order, step);
    if (!plan->states || step == 0 || step % plan->order->train_count != 0 || epoch < plan->burn_in_epochs)
        return false;
    uint64_t counted = plan->epochs - plan->burn_in_epochs, place = epoch - plan->burn_in_epochs;
    return middles_before(plan->states, counted, place + 1) > middles_before(plan->states, counted, place);
}

uint32_t vw_probes_of_state_most(const struct vw_probe_plan *plan) {
    return plan->order->train_count * VW_SAME_STATE_DRAWS + VW_PROBES_OF_NOISE;
}

static enum vw_probe_kind kind_of_noise(uint32_t index) {
    if (index == 0) return VW_PROBE_REPEATED;
    return index == 1 ? VW_PROBE_ZERO_LEARNING_RATE : VW_PROBE_RESAMPLED;
}

uint32_t vw_probes_list(const struct vw_probe_plan *plan, uint64_t step, struct vw_probe *probes) {
    uint32_t count = 0, first = is_probed_for_noise(plan, step) ? VW_PROBES_OF_NOISE : 0;
    if (vw_probe_state_due(plan, step))
        for (; count < plan->order->train_count * VW_SAME_STATE_DRAWS; count++)
            probes[count] =
                (struct vw_probe){.step = step,
                                  .index = first + count,
                                  .kind = VW_PROBE_SAME_STATE,
                                  .view = plan->order->train_views[count / VW_SAME_STATE_DRAWS],
                                  .draw = 1 + VW_PROBE_RESAMPLES + count}; // draws that no probe of noise takes
    if (plan->lengthened > 0 && step == (uint64_t)plan->burn_in_epochs * plan->order->train_count)
        for (; count < plan->order->train_count * 2; count++) // no state of scores is that early
            probes[count] = (struct vw_probe){.step = step,
                                              .index = first + count,
                                              .kind = count % 2 ? VW_PROBE_SHORTER : VW_PROBE_LONGER,
                                              .view = plan->order->train_views[count / 2],
                                              .extra = (float)(count % 2 ? -plan->lengthened : plan->lengthened)};
    if (!is_probed_for_noise(plan, step + 1)) return count;
    uint32_t view = vw_photo_order_view_of_step(plan->order, step + 1);
    for (uint32_t i = 0; i < VW_PROBES_OF_NOISE; i++)
        probes[count++] = (struct vw_probe){
            .step = step + 1, .index = i, .kind = kind_of_noise(i), .view = view, .draw = i > 1 ? i - 1 : 0};
    return count;
}
