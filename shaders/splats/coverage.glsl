// The tiles that a splat colours, the same to the bit in the pass that counts pairs and in the one that lists them:
// both ask reaches() about the same bits.
#ifndef COVERAGE_GLSL
#define COVERAGE_GLSL
#include "splats/constants.glsl"

BUFFER(VW_SLOT_SPLAT_VIEWS) readonly buffer Views { vw_splat_view views[]; };
BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
BUFFER(VW_SLOT_TILE_MAP) readonly buffer Map { uint tile_map[]; };

const uint NO_TILE = 0xFFFFFFFFu;
// Most that rounding may add to an exponent: a tile is left out only if all its pixels are certainly beyond the rim.
const float RIM_MARGIN = 0.01;

struct cell_walk { // over the cells that a box of pixels touches row by row, or over a view's tiles
    ivec2 first, last, at;
    uint tile, end;
};

// Begins a walk over the view's tiles, `walked_tiles` from the first of the dispatch where these are given, or over
// cells if neither says how many.
cell_walk begin_walk(vw_splat_view view, vw_splat_shape shape, uint walked_tiles) {
    uint tiles_of_view = walked_tiles > 0u ? walked_tiles : view.tiles;
    cell_walk walk;
    precise vec2 low = (shape.centre_conic.xy - shape.extent.xy) / float(SPLAT_SIDE);
    precise vec2 high = (shape.centre_conic.xy + shape.extent.xy) / float(SPLAT_SIDE);
    vec2 end = vec2(view.columns, view.rows);
    walk.first = ivec2(clamp(floor(low), vec2(0.0), end));
    walk.last = ivec2(clamp(floor(high), vec2(-1.0), end - 1.0));
    walk.at = walk.first;
    bool nothing = walk.first.x > walk.last.x || walk.first.y > walk.last.y;
    walk.tile = view.first_tile;
    walk.end = nothing ? 0u : view.first_tile + tiles_of_view;
    if (nothing || tiles_of_view > 0u) walk.at.y = walk.last.y + 1;
    return walk;
}

bool has_cell(cell_walk walk) { return walk.at.y <= walk.last.y; }
bool has_tile(cell_walk walk) { return walk.tile < walk.end; }

void next_cell(inout cell_walk walk) {
    bool row_ends = walk.at.x >= walk.last.x;
    walk.at.x = row_ends ? walk.first.x : walk.at.x + 1;
    walk.at.y += int(row_ends);
}

float exponent_at(vec3 conic, vec2 from) {
    return 0.5 * (conic.x * from.x * from.x + conic.z * from.y * from.y) + conic.y * from.x * from.y;
}

// Returns the least exponent over the pixels of a cell. A convex function is least at the point of a rectangle nearest
// to its own least point along the two sides that face it.
float least_exponent(vw_splat_shape shape, ivec2 cell) {
    precise vec2 low = vec2(cell * int(SPLAT_SIDE)) + 0.5 - shape.centre_conic.xy;
    precise vec2 high = low + float(SPLAT_SIDE - 1u);
    vec3 conic = vec3(shape.centre_conic.zw, shape.conic_depth.x);
    vec2 nearest = clamp(vec2(0.0), low, high);
    precise float y = clamp(-conic.y * nearest.x / conic.z, low.y, high.y);
    precise float x = clamp(-conic.y * nearest.y / conic.x, low.x, high.x);
    precise float by_x = exponent_at(conic, vec2(nearest.x, y)), by_y = exponent_at(conic, vec2(x, nearest.y));
    return min(by_x, by_y);
}

bool reaches(vw_splat_shape shape, ivec2 cell) { return least_exponent(shape, cell) <= shape.extent.z + RIM_MARGIN; }

// Says whether the splat reaches the tile at which a walk over tiles is.
bool reaches_tile(vw_splat_shape shape, cell_walk walk, uint first_tile) {
    uint corner = tiles[first_tile + walk.tile].corner;
    ivec2 at = ivec2(corner & 0xFFFFu, corner >> 16);
    bool inside = all(greaterThanEqual(at, walk.first)) && all(lessThanEqual(at, walk.last));
    return inside && reaches(shape, at);
}

// Returns the tile of the cell at which a walk over cells is, NO_TILE where the list has none or the splat does not
// reach it.
uint covered_tile(vw_splat_view view, vw_splat_shape shape, ivec2 at, uint first_tile, uint tile_count) {
    uint cell = view.first_cell + uint(at.y) * view.columns + uint(at.x);
    uint tile = tile_map[cell]; // from this or an earlier list
    bool listed = tile < tile_count && tiles[first_tile + min(tile, tile_count - 1u)].cell == cell;
    return listed && reaches(shape, at) ? tile : NO_TILE;
}

#endif
