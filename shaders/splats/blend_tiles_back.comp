// The way back through blend_tiles: the same walk front to back, on which the value of what is still to come (its
// colours times their slopes) shrinks from that of the whole pixel. Writes for each pair, at its place before the sort,
// sums over the tile's pixels, by q = raw opacity times the gradient by it and the distance (x, y) from the splat's
// centre:
//   q, q x, q y, q x x | q x y, q y y, gradients by red and green | by blue
// which no other invocation adds to.
#include "splats/blending.glsl"
#include "splats/tile_pairs.glsl"
layout(local_size_x_id = 94) in;

BUFFER(VW_SLOT_SPLAT_TILES) readonly buffer Tiles { vw_splat_tile tiles[]; };
BUFFER(VW_SLOT_TILE_RANGES) readonly buffer Ranges { vw_tile_range tile_ranges[]; };
BUFFER(VW_SLOT_COLOURS) readonly buffer Colours { vec4 colours[]; };
BUFFER(VW_SLOT_D_COLOURS) readonly buffer DColours { vec4 d_colours[]; };
BUFFER(VW_SLOT_D_PAIRS) writeonly buffer DPairs { vec4 d_pairs[]; };
PUSH uniform Push { vw_push_splats push; };

shared vec4 shares[SPLAT_LANES > 1u ? SPLAT_GROUP *VW_SPLAT_PAIR4 : 1u];

// Adds the parts of a tile's invocations in their order, and writes the sums of a pair.
void write_sums(uint pair, vec4 first, vec4 second, vec4 third) {
    uint here = gl_LocalInvocationID.x, lane = here % SPLAT_LANES, at = pair * VW_SPLAT_PAIR4;
    if (SPLAT_LANES == 1u) {
        d_pairs[at] = first;
        d_pairs[at + 1u] = second;
        d_pairs[at + 2u] = third;
        return;
    }
    barrier();
    shares[here] = first;
    shares[SPLAT_GROUP + here] = second;
    shares[2u * SPLAT_GROUP + here] = third;
    barrier();
    if (lane >= VW_SPLAT_PAIR4) return;
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < SPLAT_LANES; i++) sum += shares[lane * SPLAT_GROUP + here - lane + i];
    d_pairs[at + lane] = sum;
}

void write_zeros(uint at) { [[unroll]] for (uint i = 0u; i < VW_SPLAT_PAIR4; i++) d_pairs[at + i] = vec4(0.0); }

void main() {
    uint index = invocation_index(), tile = index / SPLAT_LANES;
    uint listed = min(tile, push.tile_count - 1u);
    vw_tile_range range = tile_ranges[listed];
    if (tile >= push.tile_count) range = vw_tile_range(0u, 0u, 0u);
    vw_splat_tile place = tiles[push.first_tile + listed];
    uvec2 pixel = lane_pixel(index % SPLAT_LANES);
    vec2 corner = vec2(uvec2(place.corner & 0xFFFFu, place.corner >> 16) * SPLAT_SIDE + pixel) + 0.5;

    float left[PIXELS], rest[PIXELS], d_red[PIXELS], d_green[PIXELS], d_blue[PIXELS];
    [[unroll]] for (uint i = 0u; i < PIXELS; i++) {
        uint x = pixel_x(pixel.x, i / ROWS), y = pixel_y(pixel.y, i % ROWS);
        uint ray = (listed * SPLAT_SIDE + y) * SPLAT_SIDE + x;
        vec4 slope = d_colours[ray];
        left[i] = 1.0;
        rest[i] = dot(slope, colours[ray]);
        d_red[i] = slope.r;
        d_green[i] = slope.g;
        d_blue[i] = slope.b;
    }
    for (uint pair = range.first; pair < range.drawn_end; pair++) {
        uint unsorted = sorted[pair].y, at = pair_splats[unsorted] * VW_SPLAT_DRAWN4;
        vec4 shape = drawn[at], paint = drawn[at + 1u];
        float paint_blue = drawn[at + 2u].x;
        vec3 conic = vec3(shape.zw, paint.x);
        vec2 from = corner - shape.xy;
        vec4 one = vec4(0.0), two = vec4(0.0), three = vec4(0.0);
        [[unroll]] for (uint column = 0u; column < COLUMNS; column++) {
            float dx = from.x + float(column * SPLAT_LANES);
            vec3 terms = power_terms(conic, dx), sums = vec3(0.0); // q, q y, q y y
            [[unroll]] for (uint row = 0u; row < ROWS; row++) {
                uint i = column * ROWS + row;
                float before = left[i], dy = from.y + float(row * ROW_STEP);
                blended b = blend(power_at(terms, dy), paint.y, left[i]);
                float slope = d_red[i] * paint.z + d_green[i] * paint.w + d_blue[i] * paint_blue;
                rest[i] -= b.weight * slope;
                float q = b.raw * (before * slope - rest[i] / (1.0 - b.alpha));
                q = mix(0.0, q, b.weight > 0.0 && b.raw <= ALPHA_MOST);
                sums += vec3(q, q * dy, q * dy * dy);
                two.zw += b.weight * vec2(d_red[i], d_green[i]);
                three.x += b.weight * d_blue[i];
            }
            one += vec4(sums.x, sums.x * dx, sums.y, sums.x * dx * dx);
            two.xy += vec2(sums.y * dx, sums.z);
        }
        write_sums(unsorted, one, two, three);
    }
    for (uint pair = range.drawn_end + index % SPLAT_LANES; pair < range.end; pair += SPLAT_LANES)
        write_zeros(sorted[pair].y * VW_SPLAT_PAIR4);
}
