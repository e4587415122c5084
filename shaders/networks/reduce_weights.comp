// Adds a chunk's slices to the weight gradients, in order over the whole step, so that the chunk size changes no bit.
// One vec4 column of weights per invocation; in the variant VW_LAYER of one matrix of the field mlp and its biases.
// Anything not finite marks the step.
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHT_PARTIALS) readonly buffer Partials { vec4 partials[]; };
BUFFER(VW_SLOT_D_WEIGHTS) buffer DWeights { vec4 d_weights[]; };
BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
#ifdef VW_LAYER
PUSH uniform Push { vw_push_matrix push; };
#define COLUMNS (push.out4 * (4u * push.in4 + push.biases))
uint first_column() { return push.first_weight; }
uint sample_count() { return push.samples; }
#else
#include "networks/mlp.glsl"
PUSH uniform Push { vw_push_samples push; };
#define COLUMNS WEIGHT_COLUMNS
uint first_column() { return 0u; }
uint sample_count() { return push.ray_count * SAMPLES; }
#endif

const uint AHEAD = 8u; // loads under way at a time: they take longer than the sums, which wait for each other

void main() {
    uint column = invocation_index();
    if (column >= COLUMNS) return;
    uint to = first_column() + column;
    vec4 sum = push.first_ray == 0u ? vec4(0.0) : d_weights[to];
    uint slices = sample_count() / SLICE_SAMPLES;
    for (uint slice = 0u; slice < slices; slice += AHEAD) {
        vec4 next[AHEAD];
        [[unroll]] for (uint i = 0u; i < AHEAD; i++) next[i] = partials[min(slice + i, slices - 1u) * COLUMNS + column];
        [[unroll]] for (uint i = 0u; i < AHEAD; i++) sum += mix(vec4(0.0), next[i], bvec4(slice + i < slices));
    }
    d_weights[to] = sum;
    if (!finite(sum)) atomicOr(state.nonfinite, 1u);
}
