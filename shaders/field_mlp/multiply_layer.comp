// A matrix of the field mlp times rows of activations, or, in the variant VW_BACK, gradients of its outputs times the
// matrix: TILE_FROM4 rows of them in one dispatch, the others in dispatches that follow and add. A workgroup holds a
// tile of the matrix in shared memory and is at 256 samples; an invocation is at one sample. No loop is live around the
// products: see README.md, "Conventions".
#include "networks/activations.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
layout(set = 0, binding = VW_SLOT_LAYER_ROWS_TEXEL) uniform samplerBuffer layer_rows_texel;
#ifdef VW_BACK
BUFFER(VW_SLOT_LAYER_ROWS) readonly buffer LayerRows { vec4 layer_rows[]; };
BUFFER(VW_SLOT_D_LAYER_ROWS) buffer DLayerRows { vec4 d_layer_rows[]; };
layout(set = 0, binding = VW_SLOT_D_LAYER_ROWS_TEXEL) uniform samplerBuffer d_layer_rows_texel;
#define ROWS d_layer_rows
#define ROWS_AS_TEXELS d_layer_rows_texel
#define ROWS_OF_SAMPLE D_LAYER_ROWS
#define PRODUCT(block, v) ((v) * (block))
#else
BUFFER(VW_SLOT_LAYER_ROWS) buffer LayerRows { vec4 layer_rows[]; };
BUFFER(VW_SLOT_CODE_SHIFT) readonly buffer CodeShift { vec4 code_shift[]; };
#define ROWS layer_rows
#define ROWS_AS_TEXELS layer_rows_texel
#define ROWS_OF_SAMPLE LAYER_ROWS
#define PRODUCT(block, v) ((block) * (v))
#endif
PUSH uniform Push { vw_push_multiply push; };

shared vec4 tile[4u * TILE_TO4 * TILE_FROM4];

void load_tile(uint first_to) {
    for (uint i = gl_LocalInvocationID.x; i < TILE_TO4 * TILE_FROM4; i += gl_WorkGroupSize.x) {
        uint to = i / TILE_FROM4, from = i % TILE_FROM4;
        uint at = push.first_weight + 4u * ((first_to + to) * push.to_stride + from * push.from_stride);
        [[unroll]] for (uint column = 0u; column < 4u; column++) tile[4u * i + column] = weights[at + column];
    }
}

vec4 value_at(uint place) { return ROWS_TEXEL != 0u ? texelFetch(ROWS_AS_TEXELS, int(place)) : ROWS[place]; }

// Returns the initial value of a row.
vec4 begin(uint to, uint place) {
    vec4 bias = vec4(0.0);
#ifndef VW_BACK
    bias = weights[push.first_bias + to];
    if (EFFECT_APPEARANCE_ENCODER != 0u || (EFFECT_APPEARANCE_CODE != 0u && TRAINING != 0u)) // see mix_code, pool_photo
        if ((push.form & VW_MULTIPLY_SHIFTS) != 0u) bias += code_shift[to];
#endif
    return mix(bias, value_at(place), bvec4((push.form & VW_MULTIPLY_ADDS) != 0u));
}

vec4 end(uint to, uint slot, vec4 sum) {
#ifdef VW_BACK
    uint place = VW_ROW_PLACE(LAYER_ROWS, push.gate_row + to, slot);
    vec4 value = ROWS_TEXEL != 0u ? texelFetch(layer_rows_texel, int(place)) : layer_rows[place];
    vec4 ended = mix(vec4(0.0), sum, greaterThan(value, vec4(0.0)));
#else
    vec4 ended = rectify(sum);
#endif
    return mix(sum, ended, bvec4((push.form & VW_MULTIPLY_GATES) != 0u));
}

void main() {
    uint group = workgroup_index(); // never folded: a chunk has too few of them
    uint tiles = push.to4 / TILE_TO4, of_samples = group / tiles;
    uint first_to = (group - of_samples * tiles) * TILE_TO4;
    uint slot = of_samples * VW_FIELD_GROUP + gl_LocalInvocationID.x;
    load_tile(first_to);
    barrier();
    vec4 value[TILE_FROM4];
    [[unroll]] for (uint k = 0u; k < TILE_FROM4; k++) value[k] =
        value_at(VW_ROW_PLACE(ROWS_OF_SAMPLE, push.from_row + k, slot));
    [[unroll]] for (uint j = 0u; j < TILE_TO4; j++) {
        uint place = VW_ROW_PLACE(ROWS_OF_SAMPLE, push.to_row + first_to + j, slot);
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < TILE_FROM4; k++) {
            uint at = 4u * (j * TILE_FROM4 + k);
            sum += PRODUCT(mat4(tile[at], tile[at + 1u], tile[at + 2u], tile[at + 3u]), value[k]);
        }
        ROWS[place] = end(first_to + j, slot, begin(first_to + j, place) + sum);
    }
}
