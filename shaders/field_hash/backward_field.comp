// The mirror of forward_field, one sample per invocation: from the gradients of rgb and raw density to those of every
// layer's output, stored for gradient_weights, and of the encoding, stored for scatter_grid. In the variant
// VW_TRANSIENT the features have a gradient already, from the transient head.
#include "bfloat.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_FIELD) readonly buffer Field { vec4 field[]; };
BUFFER(VW_SLOT_D_FIELD) readonly buffer DField { vec4 d_field[]; };
BUFFER(VW_SLOT_ROWS) buffer Rows { uvec2 rows[]; };
BUFFER(VW_SLOT_GRID_ROWS) writeonly buffer GridRows { vec4 grid_rows[]; };

#ifdef VW_TRANSIENT
BUFFER(VW_SLOT_D_LAYER_ROWS) readonly buffer DLayerRows { vec4 d_layer_rows[]; };
#endif

#define WEIGHTS_SHARED
#include "networks/mlp.glsl"

void store(uint row, uint slot, vec4 value) { rows[VW_ROW_PLACE(ROW_COUNT, row, slot)] = pack_bfloats(value); }

// Passes the gradient of hidden units that were above 0.
vec4 gate(vec4 gradient, uvec2 bits, uint block) {
    uint four = bits[block / 8u] >> (block % 8u * 4u);
    return vec4((four & 1u) != 0u ? gradient.x : 0.0, (four & 2u) != 0u ? gradient.y : 0.0,
                (four & 4u) != 0u ? gradient.z : 0.0, (four & 8u) != 0u ? gradient.w : 0.0);
}

void main() {
    for (uint i = gl_LocalInvocationID.x; i < WEIGHT_COLUMNS; i += gl_WorkGroupSize.x) weight[i] = weights[i];
    barrier();
    uint slot = invocation_index();
    vec4 out_gradient = d_field[slot];
    vec4 rgb_density = field[slot];
    uvec2 bits1 = rows[VW_ROW_PLACE(ROW_COUNT, ROW_ACTIVE1, slot)],
          bits2 = rows[VW_ROW_PLACE(ROW_COUNT, ROW_ACTIVE2, slot)];
    float d_raw = raw_gradient(rgb_density, out_gradient);
    vec4 d_logit = logit_gradient(rgb_density, out_gradient);
    store(ROW_D_LOGIT, slot, d_logit);

    vec4 d_hidden[WIDTH4];
    [[unroll]] for (uint j = 0u; j < WIDTH4; j++) {
        d_hidden[j] = gate(d_logit * weight_block(COLOUR2, 0u, WIDTH4, j), bits2, j);
        store(ROW_D_HIDDEN2 + j, slot, d_hidden[j]);
    }
    vec4 d_geo[GEO4];
    [[unroll]] for (uint k = 0u; k < GEO4; k++) {
        vec4 sum = vec4(0.0);
#ifdef VW_TRANSIENT
        sum = d_layer_rows[VW_ROW_PLACE(D_LAYER_ROWS, D_FEATURE_ROW + k, slot)];
#endif
        [[unroll]] for (uint j = 0u; j < WIDTH4; j++) sum += d_hidden[j] * weight_block(COLOUR1, j, COLOUR4, k);
        d_geo[k] = sum;
    }
    d_geo[0].x = d_raw; // SH band 0 stood in the raw density's place
    [[unroll]] for (uint k = 0u; k < GEO4; k++) store(ROW_D_GEO + k, slot, d_geo[k]);

    [[unroll]] for (uint k = 0u; k < WIDTH4; k++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint j = 0u; j < GEO4; j++) sum += d_geo[j] * weight_block(DENSITY2, j, WIDTH4, k);
        d_hidden[k] = gate(sum, bits1, k);
        store(ROW_D_HIDDEN1 + k, slot, d_hidden[k]);
    }
    [[unroll]] for (uint k = 0u; k < ENC4; k++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint j = 0u; j < WIDTH4; j++) sum += d_hidden[j] * weight_block(DENSITY1, j, ENC4, k);
        grid_rows[VW_ROW_PLACE(GRID_ROW_COUNT, GRID_ROW_D_ENCODING + k, slot)] = sum;
    }
}
