// Turns counts of digits in blocks into places of their pairs: a prefix sum by one workgroup, each invocation over the
// blocks of one digit.
#include "splats/constants.glsl"
layout(local_size_x_id = 98) in;

BUFFER(VW_SLOT_SORT_COUNTS) buffer Counts { uint counts[]; };
BUFFER(VW_SLOT_SPLAT_STATE) readonly buffer State { vw_splat_state state; };

shared uint sums[SORT_DIGITS];

const uint DIGITS_EACH = (SORT_DIGITS + PLACE_LANES - 1u) / PLACE_LANES; // a run of digits for each invocation

void main() {
    uint lane = gl_LocalInvocationID.x, blocks = state.sort_groups.x;
    uint first = min(lane * DIGITS_EACH, SORT_DIGITS) * blocks;
    uint end = min((lane + 1u) * DIGITS_EACH, SORT_DIGITS) * blocks;
    uint sum = 0u;
    for (uint i = first; i < end; i++) sum += counts[i];
    if (lane < SORT_DIGITS) sums[lane] = sum;
    barrier();
    uint before = 0u;
    for (uint i = 0u; i < min(PLACE_LANES, SORT_DIGITS); i++) before += i < lane ? sums[i] : 0u;
    for (uint i = first; i < end; i++) {
        uint count = counts[i];
        counts[i] = before;
        before += count;
    }
}
