// Lists the sightings that have pairs, and where the pairs of each begin: prefix sums by one workgroup, each invocation
// over a run of sightings. Also how many workgroups the passes after it take. More pairs than have room are not listed
// at all: the step is skipped.
#include "splats/constants.glsl"
layout(local_size_x_id = 98) in;

BUFFER(VW_SLOT_SIGHTING_PAIRS) buffer Counts { uint sighting_pairs[]; };
BUFFER(VW_SLOT_SPLATS_SEEN) writeonly buffer Seen { vw_splat_seen splats_seen[]; };
BUFFER(VW_SLOT_SPLAT_STATE) writeonly buffer State { vw_splat_state state; };
PUSH uniform Push { vw_push_splats push; };

shared uvec2 sums[PLACE_LANES]; // pairs, sightings with pairs

const uint RUN_PAIRS_MOST = 0x7FFFFFFFu; // no sum of two such numbers wraps

uint divide_up(uint value, uint part) { return (value + part - 1u) / part; }
uint add_capped(uint a, uint b) { return min(min(a, RUN_PAIRS_MOST) + min(b, RUN_PAIRS_MOST), RUN_PAIRS_MOST); }

void main() {
    uint lane = gl_LocalInvocationID.x, sightings = push.count * push.view_count;
    uint run = divide_up(sightings, PLACE_LANES), first = min(lane * run, sightings), end = min(first + run, sightings);
    uint pairs = 0u, seen = 0u;
    for (uint sighting = first; sighting < end; sighting++) {
        uint count = sighting_pairs[sighting];
        pairs = add_capped(pairs, count);
        seen += uint(count > 0u);
    }
    sums[lane] = uvec2(pairs, seen);
    barrier();
    uint pairs_before = 0u, seen_before = 0u, all_pairs = 0u, all_seen = 0u;
    for (uint i = 0u; i < PLACE_LANES; i++) {
        uvec2 sum = sums[i];
        pairs_before = add_capped(pairs_before, i < lane ? sum.x : 0u);
        seen_before += i < lane ? sum.y : 0u;
        all_pairs = add_capped(all_pairs, sum.x);
        all_seen += sum.y;
    }
    bool fits = all_pairs <= push.pair_capacity;
    for (uint sighting = first; sighting < end; sighting++) {
        uint count = fits ? sighting_pairs[sighting] : 0u;
        if (count > 0u) splats_seen[seen_before].sighting = sighting;
        sighting_pairs[sighting] = pairs_before;
        pairs_before += count;
        seen_before += uint(count > 0u);
    }
    if (lane != 0u) return;
    uint listed = fits ? all_pairs : 0u, drawn = fits ? all_seen : 0u;
    sighting_pairs[sightings] = listed;
    sighting_pairs[sightings + 1u] = drawn;
    state.seen_groups = uvec3(divide_up(drawn, 64u), 1u, 1u);
    state.sort_groups = uvec3(divide_up(listed, SORT_LANES * SORT_KEYS), 1u, 1u);
    state.tile_groups = uvec3(divide_up(push.tile_count * SPLAT_LANES, SPLAT_GROUP), 1u, 1u);
    state.square_groups = uvec3(push.squares, 1u, 1u);
    state.seen = drawn;
    state.pairs = listed;
    state.overflow = uint(!fits);
}
