// Counts of each digit in each block.
#include "splats/radix_sort.glsl"
layout(local_size_x_id = 95) in;

BUFFER(VW_SLOT_SORT_COUNTS) writeonly buffer Counts { uint counts[]; };

void main() {
    uint lane = gl_LocalInvocationID.x, block = workgroup_index(), blocks = state.sort_groups.x;
    uint first = min((block * SORT_LANES + lane) * SORT_KEYS, state.pairs), end = min(first + SORT_KEYS, state.pairs);
    count_runs(lane, first, end);
    for (uint digit = lane; digit < SORT_DIGITS; digit += SORT_LANES) {
        uint sum = 0u;
        for (uint i = 0u; i < SORT_LANES; i++) sum += digit_counts[digit * SORT_LANES + i];
        counts[digit * blocks + block] = sum;
    }
}
