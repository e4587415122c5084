// Counter-based random numbers (Philox4x32-10: Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
// shaders/random.glsl gives the same numbers: a draw is a pure function of (seed, purpose, step, a, b), in any order.
#ifndef VIEWWORTH_BASE_RANDOM_H
#define VIEWWORTH_BASE_RANDOM_H

#include <stdint.h>

enum vw_random_purpose {
    VW_RANDOM_INITIALISATION, // a = parameter index
    VW_RANDOM_ORDER,          // step = epoch, a = position
    VW_RANDOM_PIXEL,          // step = step, a = ray, b = draw
    VW_RANDOM_JITTER,         // step = step, a = ray, b = sample / 4
    VW_RANDOM_VALIDATION,     // a = view, b = ray; keyed by seed 0 unless a run varies its validation pixels
    VW_RANDOM_RECIPE,         // a = view, b = use
    VW_RANDOM_BACKGROUND,     // step = step, a = ray: rgb
    VW_RANDOM_IMPORTANCE = 9, // step = step, a = ray, b = sample / 4; 7 and 8 have no use now
    VW_RANDOM_GIVEN_PHOTO,    // step = step; of the consistency loss
    VW_RANDOM_PROJECTION,     // a = channel of features; keyed by seed 0
    VW_RANDOM_POSE, // a = view, b = 2 draw and 2 draw + 1; of places for the next photos; step = draw: of turns
};

// Draws four 32-bit words. Key: the seed's two halves. Counter: (step's low word, step's high word | purpose << 24, a,
// b); step < 2^56.
void vw_random_words(uint64_t seed, enum vw_random_purpose purpose, uint64_t step, uint32_t a, uint32_t b,
                     uint32_t words[4]);
// Returns the top 24 bits as a float in [0,1), the same on host and device.
float vw_random_unit(uint32_t word);
// Returns a number in [0, limit) with negligible bias: (word * limit) >> 32.
uint32_t vw_random_below(uint32_t word, uint32_t limit);
// Writes a permutation of 0..count-1 (Fisher-Yates) into `order`.
void vw_random_order(uint64_t seed, uint64_t epoch, uint32_t count, uint32_t *order);

#endif
