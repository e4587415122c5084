// Solid textures: the colour of a shape at a point, relative to the shape's centre, in box edges.
#ifndef RECIPE_TEXTURES_GLSL
#define RECIPE_TEXTURES_GLSL

// Scrambles the bits of a word (the finaliser of MurmurHash3, A. Appleby).
uint mix_bits(uint word) {
    word = (word ^ (word >> 16)) * 0x85EBCA6Bu;
    word = (word ^ (word >> 13)) * 0xC2B2AE35u;
    return word ^ (word >> 16);
}

float lattice_value(ivec3 corner, uint seed) {
    uvec3 c = uvec3(corner);
    return random_unit(mix_bits(c.x + mix_bits(c.y + mix_bits(c.z + seed))));
}

// Interpolates smoothly between random values at integer points; in [0,1).
float value_noise(vec3 p, uint seed) {
    ivec3 cell = ivec3(floor(p));
    vec3 w = smoothstep(0.0, 1.0, p - floor(p));
    float value = 0.0;
    [[unroll]] for (int i = 0; i < 8; i++) {
        ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 share = mix(1.0 - w, w, vec3(corner));
        value += share.x * share.y * share.z * lattice_value(cell + corner, seed);
    }
    return value;
}

vec3 texture_colour(vw_recipe_shape shape, vec3 position, uint seed) {
    vec3 p = position / shape.colour_a.w;
    float share = 0.0; // share of the second colour
    if (shape.texture == TEXTURE_CHECKER) {
        ivec3 cell = ivec3(floor(p));
        share = float((cell.x ^ cell.y ^ cell.z) & 1);
    } else if (shape.texture == TEXTURE_STRIPES) {
        share = float(int(floor(dot(p, shape.stripe_axis.xyz))) & 1);
    } else if (shape.texture == TEXTURE_NOISE) {
        share = 0.65 * value_noise(p, seed) + 0.35 * value_noise(2.7 * p, seed);
        share = smoothstep(0.2, 0.8, share);
    }
    return mix(shape.colour_a.rgb, shape.colour_b.rgb, share);
}

#endif
