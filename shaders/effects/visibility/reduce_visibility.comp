// Adds what groups of rays say of the network of visibility or, in the variant VW_UNCERTAINTY, of uncertainty, group by
// group, where update_weights reads it. One column per invocation. Anything not finite marks the step.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_VISIBILITY_PARTIALS) readonly buffer Partials { vec4 partials[]; };
BUFFER(VW_SLOT_D_WEIGHTS) writeonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
#ifdef VW_UNCERTAINTY
const uint COLUMNS = UNCERTAINTY_COLUMNS;
#else
const uint COLUMNS = VISIBILITY_COLUMNS;
#endif
PUSH uniform Push { vw_push_reduce push; };

void main() {
    uint column = invocation_index();
    if (column >= COLUMNS) return;
    vec4 sum = vec4(0.0);
    for (uint group = 0u; group < push.count; group++) sum += partials[group * COLUMNS + column];
    d_weights[VISIBILITY_COLUMN + column] = sum;
    if (!finite(sum)) atomicOr(state.nonfinite, 1u);
}
