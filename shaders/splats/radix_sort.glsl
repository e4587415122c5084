// A stable radix sort of pairs by their keys, digit by digit from the lowest. A workgroup has a block of pairs, each of
// its invocations a run of them in order. No subgroups, no atomics: equal digits keep the order of their pairs.
#ifndef RADIX_SORT_GLSL
#define RADIX_SORT_GLSL
#include "splats/constants.glsl"

BUFFER(VW_SLOT_SORT_FROM) readonly buffer From { uvec2 from[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer State { vw_splat_state state; };
PUSH uniform Push { vw_push_splats push; };

shared uint digit_counts[SORT_DIGITS * SORT_LANES]; // [digit][invocation]

uint digit_of(uint key) { return key >> push.shift & (SORT_DIGITS - 1u); }

// Counts the digits of this invocation's run, and waits for those of the others.
void count_runs(uint lane, uint first, uint end) {
    for (uint digit = 0u; digit < SORT_DIGITS; digit++) digit_counts[digit * SORT_LANES + lane] = 0u;
    for (uint pair = first; pair < end; pair++) digit_counts[digit_of(from[pair].x) * SORT_LANES + lane]++;
    barrier();
}

#endif
