// Gradients of grid entries as integers, so that atomics add them in any order to the same bits (decisions 2 and 3).
//
// Narrow: one 64-bit word carries both features of a pair as 32-bit fixed point: word = first + (second << 32) in two's
// complement, whose parts come apart exactly as long as neither sum leaves 32 bits. Wide: one 64-bit word per feature.
// The host chooses quantum and clamp (src/train/model.c) so that the sum of all contributions of a step cannot leave
// its bits.
#ifndef FIXED_POINT_GLSL
#define FIXED_POINT_GLSL

const uint WORDS_PER_PAIR = WIDE_GRADIENT != 0u ? 2u : 1u;

// Returns a signed integer below 2^62 in size as two words, low first.
uvec2 to_fixed(float quanta) {
    float rounded = roundEven(quanta);
    if (WIDE_GRADIENT == 0u) { // fits 32 bits
        int narrow = int(rounded);
        return uvec2(uint(narrow), narrow < 0 ? 0xFFFFFFFFu : 0u);
    }
    float size = abs(rounded);
    float high = floor(size * (1.0 / 4294967296.0));
    uvec2 word = uvec2(uint(size - high * 4294967296.0), uint(high));
    return rounded < 0.0 ? uvec2(~word.x + 1u, ~word.y + (word.x == 0u ? 1u : 0u)) : word;
}

float from_fixed(uvec2 word) {
    bool negative = (word.y & 0x80000000u) != 0u;
    if (negative) word = uvec2(~word.x + 1u, ~word.y + (word.x == 0u ? 1u : 0u));
    float size = float(word.y) * 4294967296.0 + float(word.x);
    return negative ? -size : size;
}

// Packs both features in one word (the narrow form); unpack_pair is its inverse.
uvec2 pack_pair(uvec2 first, uvec2 second) {
    // first + (second << 32): the sign extension of the first borrows from the second.
    return uvec2(first.x, first.y + second.x);
}

vec2 unpack_pair(uvec2 word) {
    uint borrow = (word.x & 0x80000000u) != 0u ? 0xFFFFFFFFu : 0u;
    return vec2(float(int(word.x)), float(int(word.y - borrow)));
}

#endif
