// The backward side of the hash grid: every sample of the chunk adds its encoding gradient to the eight corners of its
// cell. Sums are of integers, so all three forms give the same bits:
//   one sample and level per invocation, level by level so that one level's table stays in cache, with 64-bit atomics;
//   the same with two 32-bit atomics each (VW_SPLIT_ATOMICS), where the device has no others;
//   a whole level per invocation, without atomics (VW_WALK_LEVELS): on a CPU an atomic costs twice a plain addition,
//   even unshared.
#ifndef VW_SPLIT_ATOMICS
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#if !defined(VW_SPLIT_ATOMICS) && !defined(VW_WALK_LEVELS)
#extension GL_EXT_shader_atomic_int64 : require
#endif
#include "field_hash/hash_grid.glsl"
#include "networks/mlp.glsl"
#define ROWS_OF_GRID
#include "networks/rows.glsl"
#include "fixed_point.glsl"
#ifdef VW_WALK_LEVELS
layout(local_size_x = VW_WALK_GROUP) in;
#else
layout(local_size_x = 64) in;
#endif

BUFFER(VW_SLOT_STEP_STATE) buffer State { vw_step_state state; };
PUSH uniform Push { vw_push_scatter push; };

#if defined(VW_WALK_LEVELS)
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uint64_t d_grid[]; };
void add_word(uint word, uvec2 value) { d_grid[word] += packUint2x32(value); }
#elif defined(VW_SPLIT_ATOMICS) // the carry gives the same sum, whatever the order
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uint d_grid[]; };
void add_word(uint word, uvec2 value) {
    if (SKIP_ZEROS != 0u && (value.x | value.y) == 0u) return;
    uint before = atomicAdd(d_grid[2u * word], value.x);
    uint carry = before + value.x < before ? 1u : 0u;
    atomicAdd(d_grid[2u * word + 1u], value.y + carry);
}
#else
BUFFER(VW_SLOT_D_GRID) buffer DGrid { uint64_t d_grid[]; };
void add_word(uint word, uvec2 value) {
    if (SKIP_ZEROS != 0u && (value.x | value.y) == 0u) return;
    atomicAdd(d_grid[word], packUint2x32(value));
}
#endif

// The findings of an invocation: if a gradient was not finite, which marks the step, and how many left the clamp.
struct extremes {
    uint nonfinite, clamped;
};

void note(float gradient, inout extremes met) {
    bool known = finite(gradient);
    met.nonfinite |= known ? 0u : 1u;
    met.clamped += known && abs(gradient) > GRADIENT_CLAMP ? 1u : 0u;
}

void report(extremes met) {
    if (met.nonfinite == 0u && met.clamped == 0u) return; // one branch, hardly ever not taken
    atomicOr(state.nonfinite, met.nonfinite);
    atomicAdd(state.clamped, met.clamped);
}

// Converts to units of the quantum, within the clamp; a non-finite gradient adds nothing.
float to_quanta(float gradient) {
    return finite(gradient) ? clamp(gradient, -GRADIENT_CLAMP, GRADIENT_CLAMP) / GRADIENT_QUANTUM : 0.0;
}

// Adds without branches: on lavapipe adding 0 costs half as much as a test (src/train/device_choices.c).
void scatter(uint slot, uint level, bool inside, inout extremes met) {
    bool dense = level < DENSE_LEVELS;
    grid_cell cell = grid_locate(grid_row(GRID_ROW_POSITION, slot).xyz, level_resolution(level), dense);
    uint first_pair = level_first_pair(level) - push.first_pair;
    [[unroll]] for (uint pair = 0u; pair < FEATURE_PAIRS; pair++) {
        uint part = level * FEATURE_PAIRS + pair;
        vec4 gradient4 = grid_row(GRID_ROW_D_ENCODING + part / 2u, slot);
        vec2 gradient = inside ? (part & 1u) == 0u ? gradient4.xy : gradient4.zw : vec2(0.0);
        note(gradient.x, met);
        note(gradient.y, met);
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

#ifdef VW_WALK_LEVELS
// Assigns levels that are far apart to neighbouring invocations, which a CPU runs as one vector, so that each of the
// few workgroups has cheap and expensive ones. No two invocations add to the same words.
void main() {
    uint groups = (push.level_count + VW_WALK_GROUP - 1u) / VW_WALK_GROUP;
    uint level_in_window = gl_LocalInvocationID.x * groups + workgroup_index();
    uint samples = level_in_window < push.level_count ? push.sample_count : 0u;
    extremes met = extremes(0u, 0u);
    for (uint slot = 0u; slot < samples; slot++) scatter(slot, push.first_level + level_in_window, true, met);
    report(met);
}
#else
// Scatters one sample per invocation; surplus invocations add 0 at the place of the last sample.
void main() {
    uint index = invocation_index();
    uint samples = push.sample_count;
    uint last = samples * push.level_count - 1u;
    uint level_in_window = min(index, last) / samples;
    extremes met = extremes(0u, 0u);
    scatter(min(index, last) - level_in_window * samples, push.first_level + level_in_window, index <= last, met);
    report(met);
}
#endif
