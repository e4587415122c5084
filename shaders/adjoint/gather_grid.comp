// The grid's gradient as floats: of the mean loss, as update_grid takes it, or added to the adjoint by the backward
// pass. One pair per invocation.
#include "fixed_point.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_D_GRID) buffer DGrid { uvec2 d_grid[]; };
BUFFER(VW_SLOT_GATHERED) buffer Gathered { vec2 gathered[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_ADJOINT_STATE) readonly buffer AdjointState { vw_adjoint_state adjoint; };
PUSH uniform Push { vw_push_gather push; };

void main() {
    uint pair = invocation_index();
    if (pair >= push.count) return;
    uvec2 word = d_grid[pair * WORDS_PER_PAIR];
    uvec2 word_high = WIDE_GRADIENT != 0u ? d_grid[pair * WORDS_PER_PAIR + 1u] : uvec2(0u);
    vec2 quanta = WIDE_GRADIENT != 0u ? vec2(from_fixed(word), from_fixed(word_high)) : unpack_pair(word);
    vec2 gradient = quanta * (GRADIENT_QUANTUM * INVERSE_RAYS);
    if (push.adds == 0u) { // a step that is skipped moves nothing
        gathered[pair] = state.nonfinite != 0u ? vec2(0.0) : gradient;
        return;
    }
    if (word == uvec2(0u) && word_high == uvec2(0u)) return;
    d_grid[pair * WORDS_PER_PAIR] = uvec2(0u);
    if (WIDE_GRADIENT != 0u) d_grid[pair * WORDS_PER_PAIR + 1u] = uvec2(0u);
    gathered[pair] += adjoint.unscale * gradient;
}
