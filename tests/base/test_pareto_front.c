// The Pareto front: against a slow definition over many drawn sets with ties and missing values, and by hand.
#include "support/ledger_fixture.h"

#include "base/statistics.h"

enum { SEED = 7, SETS = 500, COUNT_MAX = 12, LEVELS = 5 };

TEST(a_front_by_hand) {
    const double costs[] = {1, 2, 3, 3, 2, 4, NAN, 0.5}, worths[] = {1, 3, 4, 2, 3, 4, 9, NAN};
    const bool wanted[] = {true, true, true, false, true, false, false, false}; // equals stay; NaN is never on it
    bool on_front[8];
    vw_pareto_front_mark(costs, worths, 8, on_front);
    for (int i = 0; i < 8; i++) assert_int_equal(on_front[i], wanted[i]);
}

static bool is_beaten(const double *costs, const double *worths, uint32_t count, uint32_t i) {
    for (uint32_t j = 0; j < count; j++) {
        bool cheaper = costs[j]<costs[i], better = worths[j]> worths[i];
        if ((cheaper && !(worths[j] < worths[i])) || (better && !(costs[j] > costs[i]))) return true;
    }
    return false;
}

TEST(drawn_fronts) {
    double costs[COUNT_MAX], worths[COUNT_MAX];
    bool on_front[COUNT_MAX];
    for (uint32_t set = 0; set < SETS; set++) {
        uint32_t count = 1 + set % COUNT_MAX, members = 0;
        for (uint32_t i = 0; i < count; i++) {
            uint32_t words[4];
            vw_random_words(SEED, VW_RANDOM_RECIPE, set, i, 0, words);
            costs[i] = words[0] % LEVELS, worths[i] = words[1] % LEVELS;
        }
        vw_pareto_front_mark(costs, worths, count, on_front);
        for (uint32_t i = 0; i < count; i++) {
            members += on_front[i];
            if (on_front[i] == is_beaten(costs, worths, count, i)) fail_msg("set %u: choice %u of %u", set, i, count);
        }
        assert_true(members > 0);
    }
}

TEST(nothing_has_no_front) {
    bool untouched = true;
    vw_pareto_front_mark(NULL, NULL, 0, &untouched);
    assert_true(untouched);
}
