#version 460
#extension GL_GOOGLE_include_directive : require
// Weight gradients: d_W = sum over samples of d_out x in. Each invocation holds one tile of 2x2 blocks (8x8 weights) in registers and
// walks one slice of SLICE_SAMPLES samples; reduce_weights adds the slices in order.
#include "common.glsl"
#include "mlp.glsl"
#include "rows.glsl"
layout(local_size_x = 64) in;

BUFFER(VW_SLOT_WEIGHT_PARTIALS) writeonly buffer Partials { vec4 partials[]; };
BUFFER(VW_SLOT_KEPT) readonly buffer Kept { vw_kept kept; };
PUSH uniform Push { vw_push_samples push; };

struct matrix_tiles {
    uint first_weight, out_row, in_row; // where the matrix and its operands begin
    uint out4, in4;                     // its size in blocks
};

// The matrix that holds `tile`, which becomes the tile within it.
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

void write_block(matrix_tiles m, uint slice, uint out_block, uint in_block, mat4 block) {
    if (out_block >= m.out4 || in_block >= m.in4) return;
    uint at = slice * WEIGHT_COLUMNS + m.first_weight + 4u * (out_block * m.in4 + in_block);
    for (uint column = 0u; column < 4u; column++) partials[at + column] = block[column];
}

void main() {
    const uint tiles = VW_WEIGHT_TILES(ENC4, WIDTH4);
    uint index = invocation_index();
    uint slice = index / tiles;
    uint tile = index - slice * tiles;
    uint samples = push.ray_count * SAMPLES;
    if (EFFECT_OCCUPANCY != 0u) samples = kept.slots;
    if (slice * SLICE_SAMPLES >= samples) return;

    matrix_tiles m = find_matrix(tile);
    uint in_tiles = (m.in4 + 1u) / 2u;
    uint out_block = 2u * (tile / in_tiles);
    uint in_block = 2u * (tile - tile / in_tiles * in_tiles);
    uint out0 = m.out_row + out_block, out1 = m.out_row + min(out_block + 1u, m.out4 - 1u);
    uint in0 = m.in_row + in_block, in1 = m.in_row + min(in_block + 1u, m.in4 - 1u);

    mat4 sum00 = mat4(0.0), sum01 = mat4(0.0), sum10 = mat4(0.0), sum11 = mat4(0.0);
    uint first = slice * SLICE_SAMPLES; // a slice lies in one workgroup of rows
    for (uint i = 0u; i < SLICE_SAMPLES; i += 4u) {
        uint at_out0 = row_place(out0, first + i), at_out1 = row_place(out1, first + i);
        uint at_in0 = row_place(in0, first + i), at_in1 = row_place(in1, first + i);
        vec4 d_out0[4], d_out1[4], value0[4], value1[4];
        [[unroll]] for (uint s = 0u; s < 4u; s++) {
            d_out0[s] = row_at(at_out0 + s), d_out1[s] = row_at(at_out1 + s);
            value0[s] = row_at(at_in0 + s), value1[s] = row_at(at_in1 + s);
        }
        // Weight by weight, each over the four samples, so that a sum is loaded and stored once where registers do not hold all of them.
        [[unroll]] for (uint column = 0u; column < 4u; column++) {
            [[unroll]] for (uint row = 0u; row < 4u; row++) {
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum00[column][row] += d_out0[s][row] * value0[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum01[column][row] += d_out0[s][row] * value1[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum10[column][row] += d_out1[s][row] * value0[s][column];
                [[unroll]] for (uint s = 0u; s < 4u; s++) sum11[column][row] += d_out1[s][row] * value1[s][column];
            }
        }
    }
    write_block(m, slice, out_block, in_block, sum00);
    write_block(m, slice, out_block, in_block + 1u, sum01);
    write_block(m, slice, out_block + 1u, in_block, sum10);
    write_block(m, slice, out_block + 1u, in_block + 1u, sum11);
}
