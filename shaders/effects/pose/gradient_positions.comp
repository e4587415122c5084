// The gradient by the position of a sample, one per invocation, from those by its encoding: through the trilinear
// weights of the cells that it lies in. What also depends on a position is left out: the view dependence of colours is
// the direction's, not the position's.
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_GRID) readonly buffer Grid { vec2 grid[]; };
layout(set = 0, binding = VW_SLOT_GRID_TEXEL) uniform samplerBuffer grid_texel;
BUFFER(VW_SLOT_D_POSITIONS) writeonly buffer DPositions { vec4 d_positions[]; };

#define GRID_READS
#include "field_hash/hash_grid.glsl"
#include "networks/mlp.glsl"
#define ROWS_OF_GRID
#include "networks/rows.glsl"

void main() {
    uint slot = invocation_index();
    vec3 position = grid_row(GRID_ROW_POSITION, slot).xyz, sum = vec3(0.0);
    [[unroll]] for (uint k = 0u; k < ENC4; k++) {
        uint pair = 2u * k; // as in forward_field
        vec4 d_encoding = grid_row(GRID_ROW_D_ENCODING + k, slot);
        sum += grid_encode_back(position, pair / FEATURE_PAIRS, pair % FEATURE_PAIRS, d_encoding.xy) +
               grid_encode_back(position, (pair + 1u) / FEATURE_PAIRS, (pair + 1u) % FEATURE_PAIRS, d_encoding.zw);
    }
    d_positions[slot] = vec4(sum, 0.0);
}
