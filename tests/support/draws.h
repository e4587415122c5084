// Random numbers of tests: functions of a seed and two counts.
#ifndef VIEWWORTH_TESTS_SUPPORT_DRAWS_H
#define VIEWWORTH_TESTS_SUPPORT_DRAWS_H

#include "support/cmocka_test.h"

#include "base/random.h"

// Returns a number in [-1, 1).
static inline double test_draw(uint64_t seed, uint32_t a, uint32_t b) {
    uint32_t words[4];
    vw_random_words(seed, VW_RANDOM_JITTER, a, b, 0, words);
    return 2.0 * vw_random_unit(words[0]) - 1.0;
}

// Returns a number that is nearly normal, with mean 0 and variance 1.
static inline double test_normal(uint64_t seed, uint32_t a, uint32_t b) {
    uint32_t words[4];
    vw_random_words(seed, VW_RANDOM_JITTER, a, b, 0, words);
    double sum = -2; // sum of four uniform numbers, shifted to mean 0: variance 1/3
    for (int i = 0; i < 4; i++) sum += (double)vw_random_unit(words[i]);
    return sum * sqrt(3);
}

#endif
