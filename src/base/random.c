#include "base/random.h"

void vw_random_words(uint64_t seed, enum vw_random_purpose purpose, uint64_t step, uint32_t a, uint32_t b,
                     uint32_t words[4]) {
    uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    uint32_t counter[4] = {(uint32_t)step, (uint32_t)(step >> 32) | (uint32_t)purpose << 24, a, b};
    for (int round = 0; round < 10; round++) {
        uint64_t product0 = (uint64_t)0xD2511F53u * counter[0];
        uint64_t product1 = (uint64_t)0xCD9E8D57u * counter[2];
        uint32_t next0 = (uint32_t)(product1 >> 32) ^ counter[1] ^ key[0];
        uint32_t next2 = (uint32_t)(product0 >> 32) ^ counter[3] ^ key[1];
        counter[0] = next0;
        counter[1] = (uint32_t)product1;
        counter[2] = next2;
        counter[3] = (uint32_t)product0;
        key[0] += 0x9E3779B9u;
        key[1] += 0xBB67AE85u;
    }
    for (int i = 0; i < 4; i++) words[i] = counter[i];
}

float vw_random_unit(uint32_t word) { return (float)(word >> 8) * (1.0f / 16777216.0f); }

uint32_t vw_random_below(uint32_t word, uint32_t limit) { return (uint32_t)(((uint64_t)word * limit) >> 32); }

void vw_random_order(uint64_t seed, uint64_t epoch, uint32_t count, uint32_t *order) {
    for (uint32_t i = 0; i < count; i++) order[i] = i;
    for (uint32_t i = count; i > 1; i--) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_ORDER, epoch, i, 0, words);
        uint32_t j = vw_random_below(words[0], i);
        uint32_t swapped = order[i - 1];
        order[i - 1] = order[j];
        order[j] = swapped;
    }
}
