// How many steps a batch holds: as many as there is room and time for.
#include "support/cmocka_test.h"

#include "train/schedule.h"

static const struct batch_room tiny_steps = {.pixels_per_step = 8, .bytes_per_step = 400, .batch_bytes = 1 << 20};

// What batches grow to when a step takes `step_s`, and the batch with number `stalled` (0: none) is asked for late.
static uint32_t grown(const struct batch_room *room, double step_s, uint32_t stalled) {
    struct schedule schedule = {0};
    schedule_set_batches(&schedule, room, 0);
    for (uint32_t batch = 1; batch < 40; batch++)
        schedule_adapt_batches(&schedule, schedule.batch_steps,
                               schedule.batch_steps * step_s + (stalled && batch >= stalled ? 10 : 0));
    assert_true(schedule.batch_steps <= schedule.batch_steps_max);
    return schedule.batch_steps;
}

static void batches_grow_to_a_quarter_of_a_second(void **state) {
    (void)state;
    assert_int_equal(grown(&tiny_steps, 0.0001, 0), 1024);
    assert_int_equal(grown(&tiny_steps, 0.001, 0), 256);
    assert_int_equal(grown(&tiny_steps, 0.02, 0), 16);
    assert_int_equal(grown(&tiny_steps, 1.0, 0), 1);
}

static void a_slow_disk_does_not_keep_them_small(void **state) {
    (void)state;
    assert_int_equal(grown(&tiny_steps, 0.001, 2), 256);
}

static void batches_have_the_room_that_they_need(void **state) {
    (void)state;
    struct batch_room room = tiny_steps;
    room.bytes_per_step = 4096;
    assert_int_equal(grown(&room, 1e-6, 0), 256);
    room.bytes_per_step = 1 << 20; // there is room for 64 in any case,
    assert_int_equal(grown(&room, 1e-6, 0), 64);
    room.pixels_per_step = 1 << 16; // unless they have too many pixels
    assert_int_equal(grown(&room, 1e-6, 0), 16);
}

static void a_given_size_stays(void **state) {
    (void)state;
    struct schedule schedule = {0};
    schedule_set_batches(&schedule, &tiny_steps, 8);
    for (int i = 0; i < 4; i++) schedule_adapt_batches(&schedule, 8, 1e-3);
    assert_int_equal(schedule.batch_steps, 8);
    schedule_set_batches(&schedule, &tiny_steps, 5000);
    assert_int_equal(schedule.batch_steps, 1024);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_grow_to_a_quarter_of_a_second),
        cmocka_unit_test(a_slow_disk_does_not_keep_them_small),
        cmocka_unit_test(batches_have_the_room_that_they_need),
        cmocka_unit_test(a_given_size_stays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
