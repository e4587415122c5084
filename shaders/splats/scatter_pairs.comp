// Moves the pairs of every block to the places of their digits.
#include "splats/radix_sort.glsl"
layout(local_size_x_id = 95) in;

BUFFER(VW_SLOT_SORT_COUNTS) readonly buffer Counts { uint counts[]; };
BUFFER(VW_SLOT_SORT_TO) writeonly buffer To { uvec2 to[]; };

void main() {
    uint lane = gl_LocalInvocationID.x, block = workgroup_index(), blocks = state.sort_groups.x;
    uint first = min((block * SORT_LANES + lane) * SORT_KEYS, state.pairs), end = min(first + SORT_KEYS, state.pairs);
    count_runs(lane, first, end);
    for (uint digit = lane; digit < SORT_DIGITS; digit += SORT_LANES) {
        uint place = counts[digit * blocks + block];
        for (uint i = 0u; i < SORT_LANES; i++) {
            uint count = digit_counts[digit * SORT_LANES + i];
            digit_counts[digit * SORT_LANES + i] = place;
            place += count;
        }
    }
    barrier();
    for (uint pair = first; pair < end; pair++) {
        uvec2 moved = from[pair];
        uint at = digit_of(moved.x) * SORT_LANES + lane;
        to[digit_counts[at]] = moved;
        digit_counts[at]++;
    }
}
