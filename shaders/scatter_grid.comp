#version 460
#extension GL_GOOGLE_include_directive : require
// The backward side of the hash grid: every sample of the chunk adds its encoding gradient to the eight corners of its cell, one level per
// invocation, level by level so that one level's table stays in cache.
#include "common.glsl"
#ifndef VW_SPLIT_ATOMICS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "hash_grid.glsl"
#include "mlp.glsl"
#include "rows.glsl"
#include "fixed_point.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_scatter push; };

#ifdef VW_SPLIT_ATOMICS // for devices without 64-bit atomics: two 32-bit ones with the carry give the same sum, whatever the order
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uint d_grid[]; };
void add_word(uint word, uvec2 value) {
    uint before = atomicAdd(d_grid[2u * word], value.x);
    uint carry = before + value.x < before ? 1u : 0u;
    atomicAdd(d_grid[2u * word + 1u], value.y + carry);
}
#else
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uint64_t d_grid[]; };
void add_word(uint word, uvec2 value) { atomicAdd(d_grid[word], packUint2x32(value)); }
#endif

// What is not finite marks the step; what leaves the clamp is counted. One branch, hardly ever taken.
void note_extremes(vec2 gradient) {
    bvec2 known = bvec2(finite(gradient.x), finite(gradient.y));
    bvec2 beyond = bvec2(known.x && abs(gradient.x) > GRADIENT_CLAMP, known.y && abs(gradient.y) > GRADIENT_CLAMP);
    if (all(known) && !any(beyond)) return;
    if (!all(known)) atomicOr(state.nonfinite, 1u);
    atomicAdd(state.clamped, uint(beyond.x) + uint(beyond.y));
}

// In units of the quantum, within the clamp; what is not finite adds nothing.
float to_quanta(float gradient) {
    return finite(gradient) ? clamp(gradient, -GRADIENT_CLAMP, GRADIENT_CLAMP) / GRADIENT_QUANTUM : 0.0;
}

// No branch around the atomics: on lavapipe adding 0 costs half of asking. (Not measured on GPUs, where many equal places might contend.)
// Invocations behind the last one add 0 to the last one's place.
void main() {
    uint index = invocation_index();
    bool inside = index < push.sample_count * push.level_count;
    index = min(index, push.sample_count * push.level_count - 1u);
    uint level_in_window = index / push.sample_count;
    uint slot = index - level_in_window * push.sample_count;
    uint level = push.first_level + level_in_window;
    bool dense = level < DENSE_LEVELS;
    grid_cell cell = grid_locate(row_value(ROW_POSITION, slot).xyz, level_resolution(level), dense);
    uint first_pair = level_first_pair(level) - push.first_pair;
    [[unroll]] for (uint pair = 0u; pair < FEATURE_PAIRS; pair++) {
        uint part = level * FEATURE_PAIRS + pair;
        vec4 gradient4 = row_value(ROW_D_ENCODING + part / 2u, slot);
        vec2 gradient = inside ? (part & 1u) == 0u ? gradient4.xy : gradient4.zw : vec2(0.0);
        note_extremes(gradient);
        vec2 quanta = vec2(to_quanta(gradient.x), to_quanta(gradient.y));
        [[unroll]] for (uint corner = 0u; corner < 8u; corner++) {
            float weight = grid_weight(cell, corner);
            uvec2 first = to_fixed(weight * quanta.x), second = to_fixed(weight * quanta.y);
            uint word = (first_pair + grid_corner(cell, corner, dense) * FEATURE_PAIRS + pair) * WORDS_PER_PAIR;
            if (WIDE_GRADIENT != 0u) {
                add_word(word, first);
                add_word(word + 1u, second);
            } else add_word(word, pack_pair(first, second));
        }
    }
}
