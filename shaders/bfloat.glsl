// Numbers as bfloats, the upper halves of floats: 8 binary digits and the whole range of exponents. Activations and
// their gradients are kept so between passes; sums are floats. Rounded by integers, so that no driver decides.
#ifndef BFLOAT_GLSL
#define BFLOAT_GLSL

// Rounds to the nearest, halves away from 0; cuts non-finite values, which so stay non-finite.
uint bfloat_bits(float x) {
    uint bits = floatBitsToUint(x);
    return bits + ((bits & 0x7F800000u) == 0x7F800000u ? 0u : 0x8000u);
}

uvec2 pack_bfloats(vec4 v) {
    return uvec2(bfloat_bits(v.x) >> 16 | (bfloat_bits(v.y) & 0xFFFF0000u),
                 bfloat_bits(v.z) >> 16 | (bfloat_bits(v.w) & 0xFFFF0000u));
}

vec4 unpack_bfloats(uvec2 packed) {
    return uintBitsToFloat(uvec4(packed.x << 16, packed.x & 0xFFFF0000u, packed.y << 16, packed.y & 0xFFFF0000u));
}

#endif
