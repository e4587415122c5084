#version 460
#extension GL_GOOGLE_include_directive : require
// Adds a chunk's slices to the weight gradients, in order over the whole step, so that the chunk size changes no bit. One vec4 column of
// weights per invocation. Anything not finite marks the step.
#include "common.glsl"
#include "mlp.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHT_PARTIALS) readonly buffer Partials { vec4 partials[]; };
BUFFER(VW_SLOT_D_WEIGHTS) buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
BUFFER(VW_SLOT_KEPT) readonly buffer Kept { vw_kept kept; };
PUSH uniform Push { vw_push_samples push; };

void main() {
    uint column = invocation_index();
    if (column >= WEIGHT_COLUMNS) return;
    vec4 sum = push.first_ray == 0u ? vec4(0.0) : d_weights[column];
    uint samples = push.ray_count * SAMPLES;
    if (EFFECT_OCCUPANCY != 0u) samples = kept.slots;
    uint slices = samples / SLICE_SAMPLES;
    for (uint slice = 0u; slice < slices; slice++) sum += partials[slice * WEIGHT_COLUMNS + column];
    d_weights[column] = sum;
    if (!finite(sum)) atomicOr(state.nonfinite, 1u);
}
