// The density at one random point of each occupancy cell, one cell per invocation: the larger of it and what remains of
// the old one. This is forward_field's way from position to density.
#include "field_hash/grid_pair.glsl"
#include "random.glsl"
layout(local_size_x = VW_FIELD_GROUP) in;

BUFFER(VW_SLOT_GRID) readonly buffer Grid { GRID_PAIR grid[]; };
layout(set = 0, binding = VW_SLOT_GRID_TEXEL) uniform samplerBuffer grid_texel;
BUFFER(VW_SLOT_WEIGHTS) readonly buffer Weights { vec4 weights[]; };
BUFFER(VW_SLOT_OCCUPANCY) buffer Occupancy { float occupancy[]; };
PUSH uniform Push { vw_push_refresh push; };
#define GRID_READS
#include "field_hash/hash_grid.glsl"
#define WEIGHTS_SHARED
#include "networks/mlp.glsl"

vec3 point_in_cell(uint cell) {
    uvec3 corner =
        uvec3(cell, cell / VW_OCCUPANCY_SIDE, cell / (VW_OCCUPANCY_SIDE * VW_OCCUPANCY_SIDE)) % VW_OCCUPANCY_SIDE;
    uvec4 words = random_words(RANDOM_OCCUPANCY, push.key, cell, 0u);
    vec3 offset = vec3(random_unit(words.x), random_unit(words.y), random_unit(words.z));
    return (vec3(corner) + offset) / float(VW_OCCUPANCY_SIDE);
}

void main() {
    for (uint i = gl_LocalInvocationID.x; i < COLOUR1; i += gl_WorkGroupSize.x)
        weight[i] = weights[i]; // the density MLP's
    barrier();
    uint cell = invocation_index();
    vec3 position = point_in_cell(cell);
    vec4 encoding[ENC4];
    [[unroll]] for (uint k = 0u; k < ENC4; k++) {
        uint pair = 2u * k;
        encoding[k] = vec4(grid_encode(position, pair / FEATURE_PAIRS, pair % FEATURE_PAIRS),
                           grid_encode(position, (pair + 1u) / FEATURE_PAIRS, (pair + 1u) % FEATURE_PAIRS));
    }
    vec4 geo = vec4(0.0);
    [[unroll]] for (uint j = 0u; j < WIDTH4; j++) {
        vec4 sum = vec4(0.0);
        [[unroll]] for (uint k = 0u; k < ENC4; k++) sum += weight_block(DENSITY1, j, ENC4, k) * encoding[k];
        geo += weight_block(DENSITY2, 0u, WIDTH4, j) * rectify(sum);
    }
    float density = at_most(exp(at_most(geo.x, 80.0)), DENSITY_MAX);
    float remaining = push.remains * occupancy[cell];
    occupancy[cell] = remaining > density ? remaining : density; // NaN comes in, and goes once the field has none
}
