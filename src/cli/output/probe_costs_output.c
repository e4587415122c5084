#include "cli/output/probe_costs_output.h"
#include "cli/output/print.h"

#include <inttypes.h>
#include <math.h>

#include "base/json.h"

void vw_probe_costs_print(const struct vw_probe_costs *costs) {
    if (costs->same_state_steps > 0)
        vw_print("same state   %" PRIu64 " probing steps from %" PRIu64 " states", costs->same_state_steps,
                 costs->states);
    if (costs->same_state_steps > 0 && isfinite(costs->same_state_s))
        vw_print(" took %.1f s, %.0f %% of this run's time", costs->same_state_s, 100 * costs->same_state_share);
    if (costs->same_state_steps > 0) vw_print("\n");
}

json_t *vw_probe_costs_same_state_to_json(const struct vw_probe_costs *costs) {
    if (!costs->same_state_steps) return NULL;
    return json_pack("{s:I, s:I, s:o, s:o}", "states", (json_int_t)costs->states, "steps",
                     (json_int_t)costs->same_state_steps, "seconds", vw_json_real(costs->same_state_s), "share",
                     vw_json_real(costs->same_state_share));
}
