// Blends the splats of every tile front to back: colours of its rays, and what is left of the light from beyond.
// SPLAT_LANES invocations share a tile; a workgroup has SPLAT_GROUP / SPLAT_LANES tiles.
#include "splats/blending.glsl"
#include "splats/tile_pairs.glsl"
layout(local_size_x_id = 94) in;

BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
BUFFER(VW_SLOT_SPLAT_STATE) buffer State { vw_splat_state state; };
BUFFER(VW_SLOT_COLOURS) writeonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_TILE_RANGES) writeonly buffer Ranges { vw_tile_range tile_ranges[]; };
PUSH uniform Push { vw_push_splats push; };

shared uint ends[SPLAT_GROUP];

// Returns the most that any invocation of the tile has.
uint most_of_tile(uint mine) {
    if (SPLAT_LANES == 1u) return mine;
    uint here = gl_LocalInvocationID.x, most = mine;
    ends[here] = mine;
    barrier();
    for (uint i = 0u; i < SPLAT_LANES; i++) most = max(most, ends[here / SPLAT_LANES * SPLAT_LANES + i]);
    return most;
}

void main() {
    uint index = invocation_index(), tile = index / SPLAT_LANES;
    uint pairs = tile < push.tile_count ? state.pairs : 0u;
    uint first = first_of_tile(tile, pairs), end = first_of_tile(tile + 1u, pairs);
    if (end - first > VW_SPLAT_TILE_PAIRS_MAX) atomicOr(state.overflow, 1u);
    end = min(end, first + VW_SPLAT_TILE_PAIRS_MAX);
    vw_splat_tile place = tiles[push.first_tile + min(tile, push.tile_count - 1u)];
    uvec2 pixel = lane_pixel(index % SPLAT_LANES);
    vec2 corner = vec2(uvec2(place.corner & 0xFFFFu, place.corner >> 16) * SPLAT_SIDE + pixel) + 0.5;

    float left[PIXELS], red[PIXELS], green[PIXELS], blue[PIXELS];
    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        left[i] = 1.0;
        red[i] = green[i] = blue[i] = 0.0;
    }
    float most_left = 1.0;
    uint pair = first;
    for (; pair < end && most_left > 0.0; pair++) {
        uint at = pair_splats[sorted[pair].y] * VW_SPLAT_DRAWN4;
        vec4 shape = drawn[at], paint = drawn[at + 1u];
        float paint_blue = drawn[at + 2u].x;
        vec3 conic = vec3(shape.zw, paint.x);
        vec2 from = corner - shape.xy;
        most_left = 0.0;
        [[unroll]] for (uint column = 0u; column < COLUMNS; column++) {
            vec3 terms = power_terms(conic, from.x + float(column * SPLAT_LANES));
            [[unroll]] for (uint row = 0u; row < ROWS; row++) {
                uint i = column * ROWS + row;
                blended b = blend(power_at(terms, from.y + float(row * ROW_STEP)), paint.y, left[i]);
                red[i] += b.weight * paint.z;
                green[i] += b.weight * paint.w;
                blue[i] += b.weight * paint_blue;
                most_left = max(most_left, left[i]);
            }
        }
    }
    uint drawn_end = most_of_tile(pair);
    if (tile >= push.tile_count) return;
    tile_ranges[tile] = vw_tile_range(first, drawn_end, end);
    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        uint x = pixel_x(pixel.x, i / ROWS), y = pixel_y(pixel.y, i % ROWS);
        colours[(tile * SPLAT_SIDE + y) * SPLAT_SIDE + x] = vec4(red[i], green[i], blue[i], abs(left[i]));
    }
}
