// When a run is given up: by its steps alone, at the same one however they come.
#include "support/cmocka_test.h"

#include "value/series.h"

// Returns the first step, counting from 1, after which a run whose step s is flagged as flagged(s) says is given up; 0
// when it never is.
static uint64_t give_up_step(bool (*flagged)(uint64_t step), uint64_t steps) {
    struct vw_step_statistics statistics = vw_step_statistics_begin();
    for (uint64_t step = 0; step <= steps; step++) {
        vw_step_statistics_add(&statistics, &(struct vw_step_record){
                                                .step = step, .nonfinite = step > 0 && flagged(step), .val_psnr = NAN});
        if (vw_step_statistics_should_abort(&statistics)) return step;
    }
    return 0;
}

static bool always(uint64_t step) { return step > 0; }
static bool never(uint64_t step) { return step > UINT64_MAX - 1; }
static bool from_37(uint64_t step) { return step >= 37; }
static bool from_1001(uint64_t step) { return step >= 1001; }
static bool every_tenth(uint64_t step) { return step % 10 == 0; }
static bool every_ninth(uint64_t step) { return step % 9 == 0; }
static bool the_first_twenty(uint64_t step) { return step <= 20; }

TEST(a_run_is_given_up_past_a_tenth) {
    assert_int_equal(give_up_step(always, 1000), 21); // twenty may be chance
    assert_int_equal(give_up_step(never, 1000), 0);
    assert_int_equal(give_up_step(from_37, 1000), 57);      // 21 of 57
    assert_int_equal(give_up_step(from_1001, 5000), 1112);  // 112 of 1112 is the first share above a tenth
    assert_int_equal(give_up_step(every_tenth, 5000), 0);   // a tenth is allowed
    assert_int_equal(give_up_step(every_ninth, 5000), 189); // the 21st
    assert_int_equal(give_up_step(the_first_twenty, 5000), 0);
}

static bool is_void(uint64_t steps, bool (*flagged)(uint64_t step)) {
    struct vw_step_statistics statistics = vw_step_statistics_begin();
    for (uint64_t step = 0; step <= steps; step++)
        vw_step_statistics_add(&statistics, &(struct vw_step_record){.step = step, .nonfinite = flagged(step)});
    return vw_step_statistics_are_void(&statistics);
}
static bool first_and_second(uint64_t step) { return step < 2; }

TEST(a_run_without_a_finite_step_is_void) {
    for (uint64_t steps = 1; steps < 40; steps++) assert_true(is_void(steps, always));
    assert_false(is_void(0, first_and_second)); // no step was taken
    assert_true(is_void(1, first_and_second));
    assert_false(is_void(2, first_and_second));
}

TEST(statistics_count_the_steps_of_a_run) {
    struct vw_step_statistics statistics = vw_step_statistics_begin();
    assert_true(isnan(statistics.first_val_psnr_db) && isnan(statistics.last_val_psnr_db));
    const struct vw_step_record records[] = {
        {.step = 0, .val_psnr = 7.5},
        {.step = 1, .val_psnr = 8.5, .floored_views = 2, .clamped_count = 3},
        {.step = 2, .val_psnr = NAN, .nonfinite = true, .clamped_count = 4},
    };
    for (int i = 0; i < 3; i++) vw_step_statistics_add(&statistics, &records[i]);
    assert_int_equal(statistics.steps, 2);
    assert_int_equal(statistics.nonfinite, 1);
    assert_int_equal(statistics.floored, 1);
    assert_int_equal(statistics.clamped, 7);
    assert_true(statistics.first_val_psnr_db == 7.5 && statistics.last_val_psnr_db == 8.5);
}
