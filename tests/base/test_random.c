// Philox4x32-10 against the known-answer vectors published with Random123, and what is made from its words.
#include "support/cmocka_test.h"

#include "base/random.h"

static void assert_words(const uint32_t words[4], uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const uint32_t expected[4] = {a, b, c, d};
    assert_memory_equal(words, expected, sizeof expected);
}

// The vectors' counters and keys, spelt through the packing: counter = (step low, step high | purpose << 24, a, b), key
// = seed.
TEST(words_match_the_published_vectors) {
    uint32_t words[4];
    vw_random_words(0, (enum vw_random_purpose)0, 0, 0, 0, words);
    assert_words(words, 0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8);
    vw_random_words(UINT64_MAX, (enum vw_random_purpose)0xff, 0x00ffffffffffffff, UINT32_MAX, UINT32_MAX, words);
    assert_words(words, 0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd);
    // The digits of pi: counter 243f6a88 85a308d3 13198a2e 03707344, key a4093822 299f31d0.
    vw_random_words(0x299f31d0a4093822, (enum vw_random_purpose)0x85, 0x00a308d3243f6a88, 0x13198a2e, 0x03707344,
                    words);
    assert_words(words, 0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1);
}

TEST(every_argument_matters) {
    uint32_t words[7][4];
    vw_random_words(1, VW_RANDOM_PIXEL, 2, 3, 4, words[0]);
    vw_random_words(2, VW_RANDOM_PIXEL, 2, 3, 4, words[1]);
    vw_random_words(1 + (1ull << 32), VW_RANDOM_PIXEL, 2, 3, 4, words[2]);
    vw_random_words(1, VW_RANDOM_JITTER, 2, 3, 4, words[3]);
    vw_random_words(1, VW_RANDOM_PIXEL, 2 + (1ull << 32), 3, 4, words[4]);
    vw_random_words(1, VW_RANDOM_PIXEL, 2, 4, 4, words[5]);
    vw_random_words(1, VW_RANDOM_PIXEL, 2, 3, 5, words[6]);
    for (int i = 0; i < 7; i++)
        for (int j = 0; j < i; j++) assert_memory_not_equal(words[i], words[j], sizeof words[i]);
}

TEST(unit_numbers_stay_below_one) {
    assert_true(vw_random_unit(0) == 0.0f);
    assert_true(vw_random_unit(UINT32_MAX) < 1.0f);
    assert_true(vw_random_unit(0x80000000u) == 0.5f);
    assert_true(vw_random_unit(0x000000ffu) == 0.0f); // only the top 24 bits count
}

TEST(below_covers_its_range_evenly) {
    assert_int_equal(vw_random_below(0, 7), 0);
    assert_int_equal(vw_random_below(UINT32_MAX, 7), 6);
    assert_int_equal(vw_random_below(UINT32_MAX, 1), 0);
    assert_int_equal(vw_random_below(UINT32_MAX, UINT32_MAX), UINT32_MAX - 1);
    int counts[7] = {0};
    for (uint32_t i = 0; i < 70000; i++) {
        uint32_t words[4];
        vw_random_words(11, VW_RANDOM_PIXEL, 0, i, 0, words);
        counts[vw_random_below(words[0], 7)]++;
    }
    for (int i = 0; i < 7; i++) assert_in_range(counts[i], 10000 - 500, 10000 + 500); // 5 standard deviations
}

TEST(an_order_is_a_permutation_of_its_own) {
    enum { COUNT = 100 };
    uint32_t order[COUNT], again[COUNT], other[COUNT];
    vw_random_order(5, 3, COUNT, order);
    vw_random_order(5, 3, COUNT, again);
    assert_memory_equal(order, again, sizeof order);
    vw_random_order(5, 4, COUNT, other);
    assert_memory_not_equal(order, other, sizeof order);
    vw_random_order(6, 3, COUNT, other);
    assert_memory_not_equal(order, other, sizeof order);
    bool seen[COUNT] = {false};
    for (int i = 0; i < COUNT; i++) {
        assert_in_range(order[i], 0, COUNT - 1);
        assert_false(seen[order[i]]);
        seen[order[i]] = true;
    }
    vw_random_order(5, 3, 1, order);
    assert_int_equal(order[0], 0);
    vw_random_order(5, 3, 0, order); // nothing to do
}

// Each of the 6 orders of 3 comes up about equally often over the epochs.
TEST(orders_are_even) {
    int counts[9] = {0};
    for (uint64_t epoch = 0; epoch < 12000; epoch++) {
        uint32_t order[3];
        vw_random_order(8, epoch, 3, order);
        counts[order[0] * 3 + order[1]]++;
    }
    for (int i = 0; i < 9; i++) {
        if (i % 4 == 0) assert_int_equal(counts[i], 0);          // the same photo twice
        else assert_in_range(counts[i], 2000 - 210, 2000 + 210); // 5 standard deviations
    }
}
