// Moves the grid, one feature pair per invocation, and clears its gradient. Lazy Adam: a pair whose integer gradient is
// 0 keeps its moments and its own step count, so that after a long silence its first step is as long as any other
// (decision 4).
#include "fixed_point.glsl"
#include "networks/adam.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_GRID) buffer Grid { vec2 grid[]; };
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uvec2 d_grid[]; };
BUFFER(VW_SLOT_GRID_MOMENT1) buffer Moment1 { vec2 grid_moment1[]; };
BUFFER(VW_SLOT_GRID_MOMENT2) buffer Moment2 { vec2 grid_moment2[]; };
BUFFER(VW_SLOT_GRID_VISITS) buffer Visits { uint grid_visits[]; };
BUFFER(VW_SLOT_STEP_STATE) readonly buffer State { vw_step_state state; };
BUFFER(VW_SLOT_OVERFLOW) writeonly buffer Overflow { uint overflow; };
PUSH uniform Push { vw_push_update push; };

void main() {
    uint pair = invocation_index();
    if (pair >= push.count) return;
    uvec2 word = d_grid[pair * WORDS_PER_PAIR];
    uvec2 word_high = WIDE_GRADIENT != 0u ? d_grid[pair * WORDS_PER_PAIR + 1u] : uvec2(0u);
    if (word == uvec2(0u) && word_high == uvec2(0u) && OPTIMIZER != OPTIMIZER_DENSE_ADAM) return;
    d_grid[pair * WORDS_PER_PAIR] = uvec2(0u);
    if (WIDE_GRADIENT != 0u) d_grid[pair * WORDS_PER_PAIR + 1u] = uvec2(0u);
    if (state.nonfinite != 0u) return; // the step is skipped

    vec2 quanta = WIDE_GRADIENT != 0u ? vec2(from_fixed(word), from_fixed(word_high)) : unpack_pair(word);
    vec4 gradient = vec4(quanta * (GRADIENT_QUANTUM * INVERSE_RAYS), 0.0, 0.0);
    // Saturated as push.step_low is: a count that wrapped to 0 would divide by 0 in the bias correction.
    uint visits = OPTIMIZER == OPTIMIZER_DENSE_ADAM ? push.step_low : min(grid_visits[pair], 0x7FFFFFFEu) + 1u;
    vec4 moment1 = MOMENTUM != 0u ? vec4(grid_moment1[pair], 0.0, 0.0) : vec4(0.0);
    vec4 moment2 = vec4(grid_moment2[pair], 0.0, 0.0);
    vec2 change = (1.0 + push.extra) * adam_step(push.adam, gradient, visits, moment1, moment2).xy;
    vec2 moved = grid[pair] - change;
    // Params stay finite, whatever the learning rate, and the row says so (decision 8).
    if (!(finite(moved.x) && finite(moved.y))) {
        overflow = 1u;
        return;
    }
    grid[pair] = moved;
    grid_moment2[pair] = moment2.xy;
    grid_visits[pair] = visits;
    if (MOMENTUM != 0u) grid_moment1[pair] = moment1.xy;
}
