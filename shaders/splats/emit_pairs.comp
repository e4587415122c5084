// Lists the pairs of every sighting that has any, with keys for the sort. The pairs of a sighting stand one after
// another.
#include "splats/coverage.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_SPLAT_SHAPES) readonly buffer Shapes { vw_splat_shape shapes[]; };
BUFFER(VW_SLOT_SIGHTING_PAIRS) readonly buffer Places { uint sighting_pairs[]; };
BUFFER(VW_SLOT_SPLATS_SEEN) buffer Seen { vw_splat_seen splats_seen[]; };
BUFFER(VW_SLOT_PAIR_SPLATS) writeonly buffer PairSplats { uint pair_splats[]; };
BUFFER(VW_SLOT_SORT_TO) writeonly buffer Sort { uvec2 sort[]; };
PUSH uniform Push { vw_push_splats push; };

// Returns the bits of depth in a key. Bits of positive floats are in their order. Steps are of 1.5e-5 of the depth; two
// splats within one step stand in the order of their indices.
uint depth_key(float depth) {
    const uint step_bits = 7u, most = (1u << VW_SPLAT_DEPTH_BITS) - 1u;
    return min((floatBitsToUint(depth) - floatBitsToUint(SPLAT_NEAR)) >> step_bits, most);
}

void emit(uint pair, uint tile, uint depth, uint rank) {
    sort[pair] = uvec2(tile == NO_TILE ? NO_TILE : tile << VW_SPLAT_DEPTH_BITS | depth, pair);
    pair_splats[pair] = rank;
}

void main() {
    uint rank = invocation_index();
    if (rank >= sighting_pairs[push.count * push.view_count + 1u]) return;
    uint sighting = splats_seen[rank].sighting, written = 0u;
    vw_splat_seen own =
        vw_splat_seen(sighting, sighting_pairs[sighting], sighting_pairs[sighting + 1u] - sighting_pairs[sighting]);
    vw_splat_shape shape = shapes[own.sighting];
    vw_splat_view view = views[push.first_view + own.sighting / push.count];
    uint depth = depth_key(shape.conic_depth.z);
    cell_walk walk = begin_walk(view, shape, push.walked_tiles);
    for (; written < own.pairs && has_tile(walk); walk.tile++)
        if (reaches_tile(shape, walk, push.first_tile)) emit(own.first_pair + written++, walk.tile, depth, rank);
    for (; written < own.pairs && has_cell(walk); next_cell(walk)) {
        uint tile = covered_tile(view, shape, walk.at, push.first_tile, push.tile_count);
        if (tile != NO_TILE) emit(own.first_pair + written++, tile, depth, rank);
    }
    splats_seen[rank] = vw_splat_seen(sighting, own.first_pair, written);
    // Were fewer tiles found than counted, the room left over would be of a tile that does not exist.
    for (; written < own.pairs; written++) emit(own.first_pair + written, NO_TILE, depth, rank);
}
