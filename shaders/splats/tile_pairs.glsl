// The pairs of a tile: a range of the sorted ones.
#ifndef TILE_PAIRS_GLSL
#define TILE_PAIRS_GLSL

BUFFER(VW_SLOT_SORT_FROM) readonly buffer Sorted { uvec2 sorted[]; };
BUFFER(VW_SLOT_PAIR_SPLATS) readonly buffer PairSplats { uint pair_splats[]; };
BUFFER(VW_SLOT_SPLATS_DRAWN) readonly buffer Drawn { vec4 drawn[]; };

// Returns the first of `count` sorted pairs that is of this tile or of a later one.
uint first_of_tile(uint tile, uint count) {
    uint low = 0u, high = count;
    while (low < high) {
        uint middle = (low + high) / 2u;
        bool before = sorted[middle].x >> VW_SPLAT_DEPTH_BITS < tile;
        low = before ? middle + 1u : low;
        high = before ? high : middle;
    }
    return low;
}

#endif
