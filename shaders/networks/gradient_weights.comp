// Weight gradients: d_W = sum over samples of d_out x in. Each invocation holds one tile of 2x2 blocks (8x8 weights) in
// registers and walks a part of one slice of SLICE_SAMPLES samples. The SLICE_PARTS parts of a slice are neighbours in
// a workgroup, which adds them by halves; reduce_weights adds the slices in order. The variant VW_LAYER is of one
// matrix of the field mlp and of its biases, where a slice is one part.
layout(local_size_x = 64) in;

struct matrix_tiles {
    uint first_weight, out_row, in_row; // where the matrix and its operands begin
    uint out4, in4;                     // its size in blocks
};

BUFFER(VW_SLOT_WEIGHT_PARTIALS) writeonly buffer Partials { vec4 partials[]; };
#ifdef VW_LAYER
BUFFER(VW_SLOT_LAYER_ROWS) readonly buffer LayerRows { vec4 layer_rows[]; };
layout(set = 0, binding = VW_SLOT_LAYER_ROWS_TEXEL) uniform samplerBuffer layer_rows_texel;
BUFFER(VW_SLOT_D_LAYER_ROWS) readonly buffer DLayerRows { vec4 d_layer_rows[]; };
layout(set = 0, binding = VW_SLOT_D_LAYER_ROWS_TEXEL) uniform samplerBuffer d_layer_rows_texel;
PUSH uniform Push { vw_push_matrix push; };

#define COLUMNS (push.out4 * (4u * push.in4 + push.biases))
#define PARTS 1u
uint tile_count() { return VW_TILES(push.out4, push.in4); }
uint sample_count() { return push.samples; }
matrix_tiles find_matrix(inout uint tile) { return matrix_tiles(0u, push.out_row, push.in_row, push.out4, push.in4); }
uint in_place(uint row, uint slot) { return VW_ROW_PLACE(LAYER_ROWS, row, slot); }
uint out_place(uint row, uint slot) { return VW_ROW_PLACE(D_LAYER_ROWS, row, slot); }
vec4 in_at(uint place) { return ROWS_TEXEL != 0u ? texelFetch(layer_rows_texel, int(place)) : layer_rows[place]; }
vec4 out_at(uint place) { return ROWS_TEXEL != 0u ? texelFetch(d_layer_rows_texel, int(place)) : d_layer_rows[place]; }
#else
#include "networks/mlp.glsl"
#include "networks/rows.glsl"
PUSH uniform Push { vw_push_samples push; };

#define COLUMNS WEIGHT_COLUMNS
#define PARTS SLICE_PARTS
#define in_place row_place
#define out_place row_place
#define in_at row_at
#define out_at row_at
uint tile_count() { return VW_WEIGHT_TILES(ENC4, WIDTH4); }
uint sample_count() { return push.ray_count * SAMPLES; }

// Finds the matrix that contains `tile`, and makes `tile` relative to it.
matrix_tiles find_matrix(inout uint tile) {
    const uint count1 = VW_TILES(WIDTH4, ENC4), count2 = VW_TILES(GEO4, WIDTH4), count3 = VW_TILES(WIDTH4, COLOUR4);
    if (tile < count1) return matrix_tiles(DENSITY1, ROW_D_HIDDEN1, ROW_ENCODING, WIDTH4, ENC4);
    tile -= count1;
    if (tile < count2) return matrix_tiles(DENSITY2, ROW_D_GEO, ROW_HIDDEN1, GEO4, WIDTH4);
    tile -= count2;
    if (tile < count3) return matrix_tiles(COLOUR1, ROW_D_HIDDEN2, ROW_COLOUR_IN, WIDTH4, COLOUR4);
    tile -= count3;
    return matrix_tiles(COLOUR2, ROW_D_LOGIT, ROW_HIDDEN2, 1u, WIDTH4);
}
#endif

#ifndef VW_LAYER
shared vec4 of_upper_parts[PARTS > 1u ? 32u * 16u : 1u]; // by column and lane

void put(uint lane, uint block, mat4 sum) {
    for (uint i = 0u; i < 4u; i++) of_upper_parts[32u * (4u * block + i) + lane] = sum[i];
}
void take(uint lane, uint block, inout mat4 sum) {
    for (uint i = 0u; i < 4u; i++) sum[i] += of_upper_parts[32u * (4u * block + i) + lane];
}

// Adds the sums of all parts of a slice to those of its first part.
void add_parts(inout mat4 sum00, inout mat4 sum01, inout mat4 sum10, inout mat4 sum11) {
    [[unroll]] for (uint part_count = PARTS / 2u; part_count > 0u; part_count /= 2u) {
        uint lanes = part_count * (64u / PARTS), lane = gl_LocalInvocationID.x;
        if (lane >= lanes && lane < 2u * lanes) {
            put(lane - lanes, 0u, sum00), put(lane - lanes, 1u, sum01);
            put(lane - lanes, 2u, sum10), put(lane - lanes, 3u, sum11);
        }
        barrier();
        if (lane < lanes) {
            take(lane, 0u, sum00), take(lane, 1u, sum01);
            take(lane, 2u, sum10), take(lane, 3u, sum11);
        }
        barrier();
    }
}
#endif

void write_block(matrix_tiles m, uint slice, uint out_block, uint in_block, mat4 block) {
    if (out_block >= m.out4 || in_block >= m.in4) return;
    uint at = slice * COLUMNS + m.first_weight + 4u * (out_block * m.in4 + in_block);
    for (uint column = 0u; column < 4u; column++) partials[at + column] = block[column];
}

void main() {
    uint tiles = tile_count();
    const uint items = 64u / PARTS; // tiles of slices in a workgroup
    uint part = gl_LocalInvocationID.x / items;
    uint index = workgroup_index() * items + gl_LocalInvocationID.x - part * items;
    uint slice = index / tiles, slices = sample_count() / SLICE_SAMPLES;
    uint tile = index - slice * tiles;
    bool beyond = slice >= slices;
    if (PARTS == 1u && beyond) return;
    slice = min(slice, slices - 1u); // lanes beyond meet the others at barriers

    matrix_tiles m = find_matrix(tile);
    uint in_tiles = (m.in4 + 1u) / 2u;
    uint out_block = 2u * (tile / in_tiles);
    uint in_block = 2u * (tile - tile / in_tiles * in_tiles);
    uint out0 = m.out_row + out_block, out1 = m.out_row + min(out_block + 1u, m.out4 - 1u);
    uint in0 = m.in_row + in_block, in1 = m.in_row + min(in_block + 1u, m.in4 - 1u);

#ifdef VW_LAYER
    vec4 bias0 = vec4(0.0), bias1 = vec4(0.0);
#endif
    mat4 sum00 = mat4(0.0), sum01 = mat4(0.0), sum10 = mat4(0.0), sum11 = mat4(0.0);
    uint first = slice * SLICE_SAMPLES + part * (SLICE_SAMPLES / PARTS); // a slice lies in one workgroup of rows
    for (uint i = 0u; i < SLICE_SAMPLES / PARTS; i += 4u) {
        uint at_out0 = out_place(out0, first + i), at_out1 = out_place(out1, first + i);
        uint at_in0 = in_place(in0, first + i), at_in1 = in_place(in1, first + i);
        vec4 d_out0[4], d_out1[4], value0[4], value1[4];
        [[unroll]] for (uint s = 0u; s < 4u; s++) {
            d_out0[s] = out_at(at_out0 + s), d_out1[s] = out_at(at_out1 + s);
            value0[s] = in_at(at_in0 + s), value1[s] = in_at(at_in1 + s);
        }
#ifdef VW_LAYER
        [[unroll]] for (uint s = 0u; s < 4u; s++) bias0 += d_out0[s], bias1 += d_out1[s];
#endif
        // Weight by weight, each over the four samples, so that a sum is loaded and stored once where registers do not
        // hold all of them.
        [[unroll]] for (uint column = 0u; column < 4u; column++) {
            [[unroll]] for (uint row = 0u; row < 4u; row++) {
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum00[column][row] += d_out0[s][row] * value0[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum01[column][row] += d_out0[s][row] * value1[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum10[column][row] += d_out1[s][row] * value0[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum11[column][row] += d_out1[s][row] * value1[s][column];
            }
        }
    }
#ifndef VW_LAYER
    add_parts(sum00, sum01, sum10, sum11);
    if (part > 0u || beyond) return;
#endif
    write_block(m, slice, out_block, in_block, sum00);
    write_block(m, slice, out_block, in_block + 1u, sum01);
    write_block(m, slice, out_block + 1u, in_block, sum10);
    write_block(m, slice, out_block + 1u, in_block + 1u, sum11);
#ifdef VW_LAYER
    if (in_block > 0u || push.biases == 0u) return;
    uint at = slice * COLUMNS + 4u * m.out4 * m.in4 + out_block;
    partials[at] = bias0;
    if (out_block + 1u < m.out4) partials[at + 1u] = bias1;
#endif
}
