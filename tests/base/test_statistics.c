// Medians, quantiles, spreads and correlations of numbers worked out by hand.
#include "base/statistics.h"
#include "support/cmocka_test.h"
#include "support/ledger_fixture.h"

static void assert_real(double value, double expected) {
    if (!(fabs(value - expected) <= 1e-15 * fabs(expected))) fail_msg("%.17g is not %.17g", value, expected);
}

TEST(medians_and_quantiles) {
    double odd[] = {3, -1, 2}, even[] = {4, 1, 3, 2}, one[] = {7}, sorted[] = {0, 10, 20, 40};
    assert_real(vw_median(odd, 3), 2);
    assert_true(odd[0] == -1 && odd[1] == 2 && odd[2] == 3);
    assert_real(vw_median(even, 4), 2.5);
    assert_real(vw_median(one, 1), 7);
    assert_true(isnan(vw_median(NULL, 0)));
    assert_real(vw_quantile_of_sorted(sorted, 4, 0), 0);
    assert_real(vw_quantile_of_sorted(sorted, 4, 0.5), 15);
    assert_real(vw_quantile_of_sorted(sorted, 4, 0.75), 25);
    assert_real(vw_quantile_of_sorted(sorted, 4, 1), 40);
}

TEST(a_far_value_moves_no_robust_spread) {
    double near[] = {1, 2, 3, 4, 5}, far[] = {1, 2, 3, 4, 5e9}, equal[] = {6, 6, 6};
    assert_real(vw_robust_spread(near, 5), VW_NORMAL_SPREAD);
    assert_real(vw_robust_spread(far, 5), VW_NORMAL_SPREAD);
    assert_real(vw_robust_spread(equal, 3), 0);
    assert_true(isnan(vw_robust_spread(NULL, 0)));
}

TEST(correlations_and_ties) {
    const double a[] = {1, 2, 3, 4, 5}, line[] = {11, 9, 7, 5, 3}, cubes[] = {1, 8, 27, 64, 125},
                 flat[] = {2, 2, 2, 2, 2};
    const double tied[] = {5, 1, 5, 1, 9}, b[] = {2, 1, 4, 3, 5};
    double ranks[5], r;
    assert_real(vw_pearson(a, line, 5), -1);
    assert_real(vw_pearson(a, b, 5), 0.8);
    assert_true(vw_pearson(a, cubes, 5) < 0.95);
    assert_true(isnan(vw_pearson(a, flat, 5)) && isnan(vw_pearson(a, b, 1)) && isnan(vw_pearson(a, b, 0)));
    ASSERT_OK(vw_spearman(a, cubes, 5, &r));
    assert_real(r, 1);
    ASSERT_OK(vw_spearman(a, b, 5, &r));
    assert_real(r, 0.8);
    ASSERT_OK(vw_ranks(tied, 5, ranks));
    const double expected[] = {3.5, 1.5, 3.5, 1.5, 5};
    for (int i = 0; i < 5; i++) assert_real(ranks[i], expected[i]);
    ASSERT_OK(vw_spearman(a, flat, 5, &r));
    assert_true(isnan(r));
}

// Values are from tables of Student's distribution; the expansion is good to 0.2 %.
TEST(students_quantiles) {
    static const struct {
        double degrees, quantile, quantile_95, quantile_99;
    } rows[] = {{1, 12.7062, 6.31375, 31.8205},  {2, 4.30265, 2.91999, 6.96456}, {3, 3.18245, 2.35336, 4.54070},
                {4, 2.77645, 2.13185, 3.74695},  {9, 2.26216, 1.83311, 2.82144}, {49, 2.00958, 1.67655, 2.40489},
                {1e6, 1.95997, 1.64485, 2.32635}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double tolerance = rows[i].degrees < 3 ? 1e-5 : 2e-3;
        assert_near(vw_student_quantile(rows[i].degrees) / rows[i].quantile, 1, tolerance);
        assert_near(vw_student_quantile_95(rows[i].degrees) / rows[i].quantile_95, 1, tolerance);
        assert_near(vw_student_quantile_99(rows[i].degrees) / rows[i].quantile_99, 1, 5 * tolerance);
    }
}

// ---- Pareto fronts -------------------------------------------------------------------------------------------------

// The Pareto front: against a slow definition over many drawn sets with ties and missing values, and by hand.
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
