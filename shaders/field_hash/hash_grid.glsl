// Multiresolution hash grid (Mueller et al., "Instant neural graphics primitives", SIGGRAPH 2022, section 3): per level
// the eight corners of the sample's cell, trilinearly weighted. Levels whose lattice fits the table are stored densely,
// the others hashed.
#ifndef HASH_GRID_GLSL
#define HASH_GRID_GLSL

// Returns a level's specialization constant: folded if the compiler knows the level, otherwise a few selects.
uint pick_level(uint level, uvec4 a, uvec4 b, uvec4 c, uvec4 d) {
    return (level < 8u ? level < 4u ? a : b : level < 12u ? c : d)[level & 3u];
}

uint level_resolution(uint level) {
    return pick_level(level, uvec4(RESOLUTION_0, RESOLUTION_1, RESOLUTION_2, RESOLUTION_3),
                      uvec4(RESOLUTION_4, RESOLUTION_5, RESOLUTION_6, RESOLUTION_7),
                      uvec4(RESOLUTION_8, RESOLUTION_9, RESOLUTION_10, RESOLUTION_11),
                      uvec4(RESOLUTION_12, RESOLUTION_13, RESOLUTION_14, RESOLUTION_15));
}

uint level_first_pair(uint level) {
    return pick_level(level, uvec4(FIRST_PAIR_0, FIRST_PAIR_1, FIRST_PAIR_2, FIRST_PAIR_3),
                      uvec4(FIRST_PAIR_4, FIRST_PAIR_5, FIRST_PAIR_6, FIRST_PAIR_7),
                      uvec4(FIRST_PAIR_8, FIRST_PAIR_9, FIRST_PAIR_10, FIRST_PAIR_11),
                      uvec4(FIRST_PAIR_12, FIRST_PAIR_13, FIRST_PAIR_14, FIRST_PAIR_15));
}

struct grid_cell {
    uvec3 axis_low, axis_high; // per axis, what the lower and the upper corner contribute to the index
    vec3 fraction;             // position within the cell
};

// Locates a cell, precise as grid_weight: two passes find the same cell and place, whatever a compiler fuses in either.
grid_cell grid_locate(vec3 position, uint resolution, bool dense) {
    precise vec3 scaled = position * float(resolution);
    uvec3 low = min(uvec3(scaled), uvec3(resolution - 1u)); // position 1.0 belongs to the last cell
    uvec3 factor =
        dense ? uvec3(1u, resolution + 1u, (resolution + 1u) * (resolution + 1u)) : uvec3(1u, 2654435761u, 805459861u);
    grid_cell cell;
    cell.axis_low = low * factor;
    cell.axis_high = cell.axis_low + factor;
    precise vec3 fraction = scaled - vec3(low);
    cell.fraction = fraction;
    return cell;
}

bvec3 upper_axes(uint corner) { return notEqual(uvec3(corner) & uvec3(1u, 2u, 4u), uvec3(0u)); }

// Returns the index within the level of corner 0..7 (bit a set: upper corner on axis a).
uint grid_corner(grid_cell cell, uint corner, bool dense) {
    uvec3 c = mix(cell.axis_low, cell.axis_high, upper_axes(corner));
    return mix((c.x ^ c.y ^ c.z) & TABLE_MASK, c.x + c.y + c.z, dense);
}

float grid_weight(grid_cell cell, uint corner) {
    vec3 share = mix(1.0 - cell.fraction, cell.fraction, upper_axes(corner));
    precise float weight = share.x * share.y * share.z;
    return weight;
}

#ifdef GRID_READS // the including pass declares the bindings
// Reads the values at a cell's corners, with one branch for all of them: see README.md, "Weak compilers".
void grid_gather(grid_cell cell, uint first, bool dense, out vec2 values[8]) {
    if (GRID_TEXEL != 0u) {
        [[unroll]] for (uint corner = 0u; corner < 8u; corner++) values[corner] =
            texelFetch(grid_texel, int(first + grid_corner(cell, corner, dense) * FEATURE_PAIRS)).xy;
    } else {
        [[unroll]] for (uint corner = 0u; corner < 8u; corner++) {
            uint index = first + grid_corner(cell, corner, dense) * FEATURE_PAIRS;
            values[corner] = grid[index];
        }
    }
}

// Encodes a position at one level, feature pair `pair`.
vec2 grid_encode(vec3 position, uint level, uint pair) {
    bool dense = level < DENSE_LEVELS;
    grid_cell cell = grid_locate(position, level_resolution(level), dense);
    vec2 values[8], sum = vec2(0.0);
    grid_gather(cell, level_first_pair(level) + pair, dense, values);
    [[unroll]] for (uint corner = 0u; corner < 8u; corner++) sum += grid_weight(cell, corner) * values[corner];
    return sum;
}

// Converts the gradient `d_pair` by this encoding to that by the position. At the border of two cells it is that of the
// upper one.
vec3 grid_encode_back(vec3 position, uint level, uint pair, vec2 d_pair) {
    bool dense = level < DENSE_LEVELS;
    uint resolution = level_resolution(level);
    grid_cell cell = grid_locate(position, resolution, dense);
    vec2 values[8];
    vec3 sum = vec3(0.0);
    grid_gather(cell, level_first_pair(level) + pair, dense, values);
    [[unroll]] for (uint corner = 0u; corner < 8u; corner++) {
        bvec3 upper = upper_axes(corner);
        vec3 share = mix(1.0 - cell.fraction, cell.fraction, upper);
        sum += dot(values[corner], d_pair) * mix(vec3(-1.0), vec3(1.0), upper) * share.yzx * share.zxy;
    }
    return float(resolution) * sum;
}
#endif

#endif
