// The layout of the hash grid's feature pairs in memory: two floats, or in the half form of the passes that touch the
// grid (VW_HALF_GRID, --table-precision float16) two halves in 32 bits. Arithmetic is the same in both.
#ifndef GRID_PAIR_GLSL
#define GRID_PAIR_GLSL

#ifdef VW_HALF_GRID
// Returns the nearest half, the even one of two; infinity for NaN and for values that round beyond the largest half. It
// works on bits, since packHalf2x16 rounds as the driver likes.
uint half_bits(float value) {
    uint bits = floatBitsToUint(value), size = bits & 0x7FFFFFFFu;
    uint normal =
        (size + 0xFFFu + (size >> 13 & 1u) - 0x38000000u) >> 13; // 13 digits fewer, and an exponent's bias 112 lower
    uint subnormal = uint(roundEven(abs(value) * 16777216.0));   // below 2^-14: a multiple of 2^-24
    return (bits >> 16 & 0x8000u) | (size < 0x38800000u ? subnormal : min(normal, 0x7C00u));
}

uint pack_halves(vec2 pair) { return half_bits(pair.x) | half_bits(pair.y) << 16; }

#define GRID_PAIR uint
#define LOAD_PAIR(stored) unpackHalf2x16(stored)
#define STORE_PAIR(pair) pack_halves(pair)
#else
#define GRID_PAIR vec2
#define LOAD_PAIR(stored) stored
#define STORE_PAIR(pair) pair
#endif

#endif
