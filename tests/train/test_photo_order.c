// The photo that each step takes when photos are left out, and the number of steps in a submission: as many as there is
// room and time for.
// label: host
#include "support/cmocka_test.h"

#include "train/photo_order.h"

static const struct vw_submission_room tiny_steps = {
    .pixels_per_step = 8, .bytes_per_step = 400, .submission_bytes = 1 << 20};

// Returns what submissions grow to when a step takes `step_s` and number `stalled` (0: none) is asked for late.
static uint32_t grown(const struct vw_submission_room *room, double step_s, uint32_t stalled) {
    struct vw_photo_order photo_order = {0};
    vw_photo_order_set_submissions(&photo_order, room, 0);
    for (uint32_t submission = 1; submission < 40; submission++)
        vw_photo_order_adapt_submissions(&photo_order, photo_order.submission_steps,
                                         photo_order.submission_steps * step_s +
                                             (stalled && submission >= stalled ? 10 : 0));
    assert_true(photo_order.submission_steps <= photo_order.submission_steps_max);
    return photo_order.submission_steps;
}

TEST(submissions_grow_to_a_quarter_of_a_second) {
    assert_int_equal(grown(&tiny_steps, 0.0001, 0), 1024);
    assert_int_equal(grown(&tiny_steps, 0.001, 0), 256);
    assert_int_equal(grown(&tiny_steps, 0.02, 0), 16);
    assert_int_equal(grown(&tiny_steps, 1.0, 0), 1);
}

TEST(a_slow_disk_does_not_keep_them_small) { assert_int_equal(grown(&tiny_steps, 0.001, 2), 256); }

TEST(submissions_have_the_room_that_they_need) {
    struct vw_submission_room room = tiny_steps;
    room.bytes_per_step = 4096;
    assert_int_equal(grown(&room, 1e-6, 0), 256);
    room.bytes_per_step = 1 << 20; // there is room for 64 in any case,
    assert_int_equal(grown(&room, 1e-6, 0), 64);
    room.pixels_per_step = 1 << 16; // unless they have too many pixels
    assert_int_equal(grown(&room, 1e-6, 0), 16);
}

TEST(a_given_size_stays) {
    struct vw_photo_order photo_order = {0};
    vw_photo_order_set_submissions(&photo_order, &tiny_steps, 8);
    for (int i = 0; i < 4; i++) vw_photo_order_adapt_submissions(&photo_order, 8, 1e-3);
    assert_int_equal(photo_order.submission_steps, 8);
    vw_photo_order_set_submissions(&photo_order, &tiny_steps, 5000);
    assert_int_equal(photo_order.submission_steps, 1024);
}

// ---- Left out -------------------------------------------------------------------------------------------------------

enum { VIEWS = 9, EPOCHS = 40 };

static struct vw_photo_order make_schedule(const uint32_t *left_out, uint32_t count, enum vw_status expected) {
    static const uint32_t views[VIEWS] = {1, 2, 4, 5, 7, 8, 9, 11, 12};
    const struct vw_scene scene = {.view_count = 13};
    struct vw_config config = vw_config_of_field(VW_FIELD_HASH);
    struct vw_photo_order photo_order;
    config.epochs = EPOCHS;
    config.seed = 5;
    ASSERT_OK(vw_photo_order_create(&scene, views, VIEWS, &config, &photo_order));
    assert_int_equal(vw_photo_order_leave_out(left_out, count, &photo_order), expected);
    return photo_order;
}

TEST(others_take_the_steps_of_those_left_out) {
    static const uint32_t left_out[] = {2, 9, 12};
    struct vw_photo_order all = make_schedule(NULL, 0, VW_OK), some = make_schedule(left_out, 3, VW_OK);
    uint32_t visits[13] = {0}, given[13] = {0};
    assert_int_equal(vw_photo_order_total_steps(&some), VIEWS * EPOCHS);
    for (uint64_t step = 1; step <= VIEWS * EPOCHS; step++) {
        uint32_t view = vw_photo_order_view_of_step(&some, step), before = vw_photo_order_view_of_step(&all, step);
        visits[view]++;
        if (before == 2 || before == 9 || before == 12) given[view]++;
        else assert_int_equal(view, before);
    }
    for (uint32_t view = 0; view < 13; view++) {
        bool kept = view == 1 || view == 4 || view == 5 || view == 7 || view == 8 || view == 11;
        assert_int_equal(given[view], kept ? 3 * EPOCHS / 6 : 0);
        assert_int_equal(visits[view], kept ? EPOCHS + 3 * EPOCHS / 6 : 0);
    }
    vw_photo_order_destroy(&all);
    vw_photo_order_destroy(&some);
}

TEST(one_photo_can_take_all_steps) {
    static const uint32_t left_out[] = {1, 2, 4, 5, 8, 9, 11, 12};
    struct vw_photo_order photo_order = make_schedule(left_out, 8, VW_OK);
    for (uint64_t step = 1; step <= VIEWS * EPOCHS; step++)
        assert_int_equal(vw_photo_order_view_of_step(&photo_order, step), 7);
    vw_photo_order_destroy(&photo_order);
}

TEST(wrong_lists_are_refused) {
    static const uint32_t unknown[] = {2, 3}, unordered[] = {9, 2}, all[] = {1, 2, 4, 5, 7, 8, 9, 11, 12};
    struct vw_photo_order photo_order = make_schedule(unknown, 2, VW_ERROR_USAGE);
    assert_non_null(strstr(vw_error_message(), "left_out_views[1]"));
    vw_photo_order_destroy(&photo_order);
    photo_order = make_schedule(unordered, 2, VW_ERROR_USAGE);
    vw_photo_order_destroy(&photo_order);
    photo_order = make_schedule(all, VIEWS, VW_ERROR_USAGE);
    vw_photo_order_destroy(&photo_order);
}
