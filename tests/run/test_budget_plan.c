// Time budgets: how they are read, and which setting and how many epochs they buy.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "run/plan/plan.h"

TEST(times_are_read) {
    static const struct {
        const char *text;
        double seconds;
    } cases[] = {{"90s", 90},   {"10min", 600},    {"1.5h", 5400},  {"10s", 10},
                 {"10.0s", 10}, {"1000h", 3600e3}, {"0.25min", 15}, {"10.s", 10}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        double seconds = -1;
        ASSERT_OK(vw_budget_parse(cases[i].text, &seconds));
        assert_true(seconds == cases[i].seconds);
    }
}

TEST(other_texts_are_refused) {
    static const struct {
        const char *text, *word;
    } cases[] = {
        {"", "as 90s"},         {"s", "as 90s"},         {"nan", "as 90s"},
        {"nans", "as 90s"},     {"infs", "as 90s"},      {"-90s", "as 90s"},
        {"+90s", "as 90s"},     {" 90s", "as 90s"},      {"90s ", "as 90s"},
        {"90 s", "as 90s"},     {"90sec", "as 90s"},     {"90S", "as 90s"},
        {"90m", "as 90s"},      {"1e3s", "as 90s"},      {"1e999s", "as 90s"},
        {"0x20s", "as 90s"},    {"1.2.3min", "as 90s"},  {".5h", "as 90s"},
        {"90s10min", "as 90s"}, {"90,5s", "as 90s"},     {"90", "its unit"},
        {"600.5", "its unit"},  {"0s", "10s to"},        {"9.999s", "10s to"},
        {"0.1min", "10s to"},   {"1000.1h", "to 1000h"}, {"99999999999999999999999999999999999999999999h", "to 1000h"},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        double seconds = -1;
        if (vw_budget_parse(cases[i].text, &seconds) != VW_ERROR_USAGE)
            fail_msg("\"%s\" was taken for %g s", cases[i].text, seconds);
        if (!strstr(vw_error_message(), cases[i].word)) fail_msg("\"%s\": %s", cases[i].text, vw_error_message());
        assert_true(seconds == -1);
    }
    char digits[600]; // more than a double holds
    memset(digits, '9', sizeof digits);
    memcpy(digits + sizeof digits - 2, "h", 2);
    double seconds = -1;
    assert_int_equal(vw_budget_parse(digits, &seconds), VW_ERROR_USAGE);
}

static const struct vw_budget_candidate ladder[] = {{0.01, 10}, {0.02, 14}, {0.04, 20}, {0.4, 27}};
static const double NO = 1e9;

static void assert_plan(double left_s, uint32_t photos, uint32_t epochs_most, uint32_t candidate, uint32_t epochs) {
    struct vw_budget_plan plan = {99, 99};
    const struct vw_budget_task task = {left_s, photos, 1, epochs_most};
    ASSERT_OK(vw_budget_plan(ladder, VW_ARRAY_COUNT(ladder), &task, &plan));
    if (plan.candidate != candidate || plan.epochs != epochs)
        fail_msg("%g s for %u photos: candidate %u with %u epochs, not %u with %u", left_s, photos, plan.candidate,
                 plan.epochs, candidate, epochs);
}

// With 100 photos an epoch takes 1, 2, 4 and 40 s; candidates want 10, 14, 20 and 27 of those.
TEST(the_dearest_that_fits_is_chosen) {
    assert_plan(2.5, 100, 1000, 0, 2);      // burn-in and one
    assert_plan(27.9, 100, 1000, 0, 27);    // 13 epochs of quick are too few
    assert_plan(28.1, 100, 1000, 1, 14);    // 14 are enough
    assert_plan(79.9, 100, 1000, 1, 39);    // 19 of 20 are not
    assert_plan(80.1, 100, 1000, 2, 20);    // 20 are
    assert_plan(1079.0, 100, 1000, 2, 269); // 26 of 27 are not
    assert_plan(1080.1, 100, 1000, 3, 27);  // 27 are
    assert_plan(1e9, 100, 1000, 3, 1000);   // no more than are asked for
    assert_plan(1e300, 100, UINT32_MAX, 3, UINT32_MAX);
    assert_plan(2.5, 1, 1000, 2, 62);
    assert_plan(80.1, 100, 9, 0,
                9); // where --epochs is below what candidates want, it is for the caller to lower what they want
}

TEST(where_none_fits_it_is_the_cheapest_or_none) {
    static const double left_s[] = {1.99, 0, -5, (double)NAN, -(double)INFINITY};
    for (size_t i = 0; i < VW_ARRAY_COUNT(left_s); i++) {
        struct vw_budget_plan plan;
        const struct vw_budget_task task = {left_s[i], 100, 1, 1000};
        ASSERT_FAILS(vw_budget_plan(ladder, VW_ARRAY_COUNT(ladder), &task, &plan), VW_ERROR_USAGE, "allow more time");
    }
    struct vw_budget_plan plan;
    // Burn-in can be longer than what a candidate wants.
    const struct vw_budget_task late = {100, 100, 39, 1000};
    ASSERT_OK(vw_budget_plan(ladder, VW_ARRAY_COUNT(ladder), &late, &plan));
    assert_true(plan.candidate == 1 && plan.epochs == 50);
    // An effort that was not measured is never chosen.
    const struct vw_budget_candidate unknown[] = {{0.01, 15}, {(double)NAN, 20}, {0, 20}};
    const struct vw_budget_task task = {1000, 100, 1, 2000};
    ASSERT_OK(vw_budget_plan(unknown, VW_ARRAY_COUNT(unknown), &task, &plan));
    assert_true(plan.candidate == 0 && plan.epochs == 1000);
}

TEST(segments_shorten_towards_the_end) {
    assert_int_equal(vw_budget_segment(100, 1, 1000), 50);
    assert_int_equal(vw_budget_segment(3.9, 1, 1000), 1);
    assert_int_equal(vw_budget_segment(1.01, 1, 1000), 1);
    assert_int_equal(vw_budget_segment(0.99, 1, 1000), 0);
    assert_int_equal(vw_budget_segment(-1, 1, 1000), 0);
    assert_int_equal(vw_budget_segment(100, 1, 0), 0);
    assert_int_equal(vw_budget_segment(100, 1, 1), 1);
    assert_int_equal(vw_budget_segment(NO, 1e-300, UINT32_MAX), UINT32_MAX / 2);
    // A run at an even pace ends within an epoch of its time, and not after it.
    for (double left_s = 1; left_s < 200; left_s += 0.37) {
        double passed_s = 0;
        for (uint32_t epochs; (epochs = vw_budget_segment(left_s - passed_s, 0.83, 1000)) > 0;)
            passed_s += 0.83 * epochs;
        assert_true(passed_s <= left_s + 1e-9 && passed_s > left_s - 0.83 - 1e-9); // 1e-9: rounding of sums
    }
}
