// All of space in a ball: the contraction of mip-NeRF 360 (Barron et al., "Mip-NeRF 360: unbounded anti-aliased neural
// radiance fields", CVPR 2022, equation 10). With q = 2 * box - 1, whose unit ball is the scene's inner region
// (src/train/effects/field_box.c):
//   c = q where |q| <= 1, else (2 - 1 / |q|) q / |q|
// so that |c| < 2, and the field is read at c / 4 + 1 / 2. Directions stay as they are. There is no backward pass:
// sample positions are not trained, so that no gradient goes through them.
#ifndef CONTRACTION_GLSL
#define CONTRACTION_GLSL

// Maps box coordinates, over the whole range of floats, to the unit cube. Lengths are those of q / size, since squares
// overflow beyond 1e19. Both are made smaller before, since division by more than 2^126 is not defined in Vulkan: GPUs
// multiply by a reciprocal, which they flush to 0.
vec3 contract(vec3 box) {
    precise vec3 q = 2.0 * box - 1.0;
    float size = max(1.0, max(abs(q.x), max(abs(q.y), abs(q.z))));
    float smaller = size > 1e30 ? 1e-30 : 1.0;
    vec3 scaled = (q * smaller) / (size * smaller);
    float scaled_length = length(scaled); // 0 at the centre alone, which is not divided by it
    float q_length = size * scaled_length;
    vec3 c = q;
    if (q_length > 1.0) c = (2.0 - 1.0 / q_length) * (scaled / scaled_length);
    precise vec3 contracted = 0.25 * c + 0.5;
    return contracted;
}

#endif
