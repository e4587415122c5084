#include "run/probe_costs.h"

#include <math.h>

#include "train/trainer.h"

struct vw_probe_costs vw_probe_costs_count(const struct vw_value_input *input, const struct vw_trainer *trainer,
                                           double command_s) {
    struct vw_probe_costs costs = {.same_state_s = NAN, .same_state_share = NAN};
    struct vw_trainer_stats stats;
    uint64_t state = 0;
    for (uint64_t i = 0; i < input->probe_count; i++) {
        const struct vw_probe *probe = &input->probes[i];
        if (probe->kind != VW_PROBE_SAME_STATE) continue;
        costs.same_state_steps++;
        costs.states += probe->step != state; // rows come by their steps, which count from 1
        state = probe->step;
    }
    vw_trainer_get_stats(trainer, &stats);
    if (!stats.same_state_steps) return costs;
    costs.same_state_s = stats.same_state_s;
    costs.same_state_share = stats.same_state_s / command_s;
    return costs;
}
