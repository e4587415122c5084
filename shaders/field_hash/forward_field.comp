// The field at one sample per invocation: hash grid, density MLP, spherical harmonics, colour MLP. It also stores what
// the backward passes need, where STORES_ROWS asks for it. Chunks are padded to whole workgroups, since control flow
// around the MLP costs more than the work it saves.
#include "bfloat.glsl"
#include "rays/sample_places.glsl"
#include "networks/spherical_harmonics.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_RAYS) readonly buffer Rays { vw_ray rays[]; };
BUFFER(VW_SLOT_GRID) readonly buffer Grid { vec2 grid[]; };
layout(set = 0, binding = VW_SLOT_GRID_TEXEL) uniform samplerBuffer grid_texel;
BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_FIELD) writeonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_ROWS) writeonly buffer Rows { uvec2 rows[]; };
BUFFER(VW_SLOT_GRID_ROWS) writeonly buffer GridRows { vec4 grid_rows[]; };
BUFFER(VW_SLOT_CODE_SHIFT) readonly buffer CodeShift { vec4 code_shift[]; };
PUSH uniform Push { vw_push_samples push; };

#define GRID_READS
#include "field_hash/hash_grid.glsl"
#define WEIGHTS_SHARED
#include "networks/mlp.glsl"

void store_packed(uint row, uint slot, uvec2 value) {
    if (STORES_ROWS != 0u) rows[VW_ROW_PLACE(ROW_COUNT, row, slot)] = value;
}

void store(uint row, uint slot, vec4 value) { store_packed(row, slot, pack_bfloats(value)); }

// Sets bit i of the result if hidden unit 4 * block + i is above 0.
uint active_bits(vec4 value) {
    return uint(value.x > 0.0) | uint(value.y > 0.0) << 1 | uint(value.z > 0.0) << 2 | uint(value.w > 0.0) << 3;
}

void main() {
    for (uint i = gl_LocalInvocationID.x; i < WEIGHT_COLUMNS; i += gl_WorkGroupSize.x) weight[i] = weights[i];
    if (EFFECT_APPEARANCE_ENCODER != 0u ||
        (EFFECT_APPEARANCE_CODE != 0u && TRAINING != 0u)) { // see mix_code, pool_photo
        barrier();
        uint unit4 = gl_LocalInvocationID.x;
        if (unit4 < WIDTH4) weight[SHIFT_COLUMN + SHIFT_STRIDE * unit4] += code_shift[unit4];
    }
    barrier();
    uint slot = invocation_index();
    uint ray_index = push.first_ray + slot / SAMPLES;
    uint sample_in_ray = slot - slot / SAMPLES * SAMPLES;
    vw_ray ray = rays[ray_index];
    vec3 position = position_at(ray, sample_place(slot, ray_index, sample_in_ray, push.key));
    if (STORES_ROWS != 0u) grid_rows[VW_ROW_PLACE(GRID_ROW_COUNT, GRID_ROW_POSITION, slot)] = vec4(position, 0.0);

    vec4 encoding[ENC4];
    [[unroll]] for (uint k = 0u; k < ENC4; k++) {
        uint pair = 2u * k; // two feature pairs to a vec4; FEATURE_PAIRS is 1 or 2
        encoding[k] = vec4(grid_encode(position, pair / FEATURE_PAIRS, pair % FEATURE_PAIRS),
                           grid_encode(position, (pair + 1u) / FEATURE_PAIRS, (pair + 1u) % FEATURE_PAIRS));
        store(ROW_ENCODING + k, slot, encoding[k]);
    }

    uvec2 bits1 = uvec2(0u), bits2 = uvec2(0u);
    vec4 hidden[WIDTH4];
    [[unroll]] for (uint j = 0u; j < WIDTH4; j++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < ENC4; k++) sum += weight_block(DENSITY1, j, ENC4, k) * encoding[k];
        hidden[j] = rectify(sum);
        if (STORES_ROWS != 0u) bits1[j / 8u] |= active_bits(sum) << (j % 8u * 4u);
        store(ROW_HIDDEN1 + j, slot, hidden[j]);
    }

    vec4 colour_in[COLOUR4];
    [[unroll]] for (uint j = 0u; j < GEO4; j++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < WIDTH4; k++) sum += weight_block(DENSITY2, j, WIDTH4, k) * hidden[k];
        colour_in[j] = sum;
    }
    float density = density_of(colour_in[0].x);
    colour_in[0].x = SH_BAND0; // the raw density's place
    spherical_harmonics(ray.direction_stride.xyz, colour_in[GEO4], colour_in[GEO4 + 1u]);
    [[unroll]] for (uint j = 0u; j < COLOUR4; j++) store(ROW_COLOUR_IN + j, slot, colour_in[j]);

    vec4 logit = vec4(0.0);
    [[unroll]] for (uint j = 0u; j < WIDTH4; j++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < COLOUR4; k++) sum += weight_block(COLOUR1, j, COLOUR4, k) * colour_in[k];
        vec4 value = rectify(sum);
        if (STORES_ROWS != 0u) bits2[j / 8u] |= active_bits(sum) << (j % 8u * 4u);
        store(ROW_HIDDEN2 + j, slot, value);
        logit += weight_block(COLOUR2, 0u, WIDTH4, j) * value;
    }
    vec3 rgb = vec3(sigmoid(logit.x), sigmoid(logit.y), sigmoid(logit.z));
    field[slot] = vec4(rgb, density);
    store_packed(ROW_ACTIVE1, slot, bits1);
    store_packed(ROW_ACTIVE2, slot, bits2);
}
