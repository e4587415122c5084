// Counter-based random numbers, the same as src/base/random.c: Philox4x32-10 (Salmon et al., SC 2011).
#ifndef RANDOM_GLSL
#define RANDOM_GLSL

// Returns random words; `seed_step` is the key of the push block.
uvec4 random_words(uint purpose, uvec4 seed_step, uint a, uint b) {
    uvec2 key = seed_step.xy;
    uvec4 counter = uvec4(seed_step.z, seed_step.w | purpose << 24, a, b);
    [[unroll]] for (int round = 0; round < 10; round++) {
        uint high0, low0, high1, low1;
        umulExtended(0xD2511F53u, counter.x, high0, low0);
        umulExtended(0xCD9E8D57u, counter.z, high1, low1);
        counter = uvec4(high1 ^ counter.y ^ key.x, low1, high0 ^ counter.w ^ key.y, low0);
        key += uvec2(0x9E3779B9u, 0xBB67AE85u);
    }
    return counter;
}

float random_unit(uint word) { return float(word >> 8) * (1.0 / 16777216.0); }

#endif
