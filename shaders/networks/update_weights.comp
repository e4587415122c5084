// Moves the MLP weights and, after them, the sky's coefficients, one vec4 column per invocation. They have a gradient
// at every step, so that the step's number is their step count.
#include "networks/adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHTS) buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_D_WEIGHTS) readonly buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_WEIGHT_MOMENTS) buffer Moments { vec4 moments[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_OVERFLOW) writeonly buffer Overflow { uint overflow; };
PUSH uniform Push { vw_push_update push; };

void main() {
    uint column = invocation_index();
    if (column >= push.count || state.nonfinite != 0u) return;
    vec4 moment1 = moments[column];
    vec4 moment2 = moments[push.count + column];
    vec4 moved = weights[column] - (1.0 + push.extra) * adam_step(push.adam, d_weights[column] * INVERSE_RAYS,
                                                                  push.step_low, moment1, moment2);
    if (!finite(moved)) { // params stay finite, whatever the learning rate, and the row says so (decision 8)
        overflow = 1u;
        return;
    }
    weights[column] = moved;
    moments[column] = moment1;
    moments[push.count + column] = moment2;
}
