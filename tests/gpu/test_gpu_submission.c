// Submissions: derived barriers, folding, copies, order, sticky failures, submitting again, timers.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "gpu/command_list.h"
#include "support/gpu_fixture.h"

#include "gather_texels.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "scale_values.h"
#include "sum_windows.h"

static const struct vw_shader scale_values = {"scale_values", scale_values_code, sizeof scale_values_code};
static const struct vw_shader gather_texels = {"gather_texels", gather_texels_code, sizeof gather_texels_code};
static const struct vw_shader sum_windows = {"sum_windows", sum_windows_code, sizeof sum_windows_code};

enum { VALUES = 256, VALUE_BYTES = VALUES * 4 };

struct scale_push {
    uint32_t count;
    uint32_t factor;
};

// Three buffers a, b, c, where a[i] = i + 1, and passes between them.
struct bench {
    struct vw_gpu *gpu;
    struct vw_buffer *a, *b, *c;
    struct vw_pass *a_to_b, *a_to_c, *b_to_c, *b_to_a, *gather_b_to_c, *add_a_to_b;
    struct vw_submission *submission;
};

static struct vw_buffer *make_buffer(struct vw_gpu *gpu, const char *name) {
    return test_buffer(gpu, name, VALUE_BYTES);
}

static struct vw_pass *make_pass(struct vw_gpu *gpu, const struct vw_shader *shader, struct vw_binding source,
                                 struct vw_binding target) {
    const uint32_t specialization[] = {16, 64}; // for sum_windows
    return test_pass(gpu, (struct vw_pass_params){.shader = shader,
                                                  .specialization = specialization,
                                                  .specialization_count = 2,
                                                  .bindings = (struct vw_binding[]){source, target},
                                                  .binding_count = 2});
}

static struct vw_pass *make_scale(struct vw_gpu *gpu, struct vw_buffer *source, struct vw_buffer *target) {
    return make_pass(gpu, &scale_values, (struct vw_binding){.slot = 0, .buffer = source},
                     (struct vw_binding){.slot = 3, .buffer = target});
}

static struct bench open_bench(struct vw_gpu *gpu) {
    struct bench bench = {
        .gpu = gpu, .a = make_buffer(gpu, "a"), .b = make_buffer(gpu, "b"), .c = make_buffer(gpu, "c")};
    bench.a_to_b = make_scale(gpu, bench.a, bench.b);
    bench.a_to_c = make_scale(gpu, bench.a, bench.c);
    bench.b_to_c = make_scale(gpu, bench.b, bench.c);
    bench.b_to_a = make_scale(gpu, bench.b, bench.a);
    bench.gather_b_to_c =
        make_pass(gpu, &gather_texels, (struct vw_binding){.slot = 1, .buffer = bench.b, .texel = VW_TEXEL_UINT1},
                  (struct vw_binding){.slot = 2, .buffer = bench.c});
    bench.add_a_to_b = make_pass(gpu, &sum_windows, (struct vw_binding){.slot = 0, .buffer = bench.a},
                                 (struct vw_binding){.slot = 1, .buffer = bench.b});
    uint32_t values[VALUES];
    for (uint32_t i = 0; i < VALUES; i++) values[i] = i + 1;
    ASSERT_OK(vw_buffer_write(bench.a, 0, values, VALUE_BYTES));
    bench.submission = test_submission(gpu);
    return bench;
}

static struct bench begin_bench(struct vw_gpu *gpu) {
    struct bench bench = open_bench(gpu);
    vw_submission_begin(bench.submission);
    return bench;
}

static void scale(struct vw_submission *submission, const struct vw_pass *pass, uint32_t factor) {
    vw_submission_dispatch(submission, pass, &(struct scale_push){VALUES, factor}, sizeof(struct scale_push), VALUES);
}

static void finish(struct vw_submission *submission) {
    ASSERT_OK(vw_submission_submit(submission));
    ASSERT_OK(vw_submission_wait(submission));
}

static void assert_values(struct vw_buffer *buffer, uint32_t factor) {
    uint32_t values[VALUES];
    ASSERT_OK(vw_buffer_read(buffer, 0, values, VALUE_BYTES));
    for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], factor * (i + 1));
}

// ---- Barriers: synchronization validation watches what the counts only claim ----------------------------------------

static uint64_t earliest(struct vw_ranges *ranges, uint64_t offset_bytes, uint64_t size_bytes, bool writes) {
    uint32_t index = 0;
    ASSERT_OK(vw_ranges_find(ranges, offset_bytes, size_bytes, &index));
    return vw_ranges_earliest(ranges, index, writes);
}

static void note(struct vw_ranges *ranges, uint64_t offset_bytes, uint64_t size_bytes, bool writes, uint64_t epoch) {
    uint32_t index = 0;
    ASSERT_OK(vw_ranges_find(ranges, offset_bytes, size_bytes, &index));
    vw_ranges_note(ranges, index, writes, epoch);
}

TEST(hazards_are_all_but_read_after_read) {
    struct vw_ranges ranges = {0};
    assert_int_equal(earliest(&ranges, 0, 100, true), 0); // untouched
    note(&ranges, 0, 100, false, 5);
    note(&ranges, 0, 100, false, 3); // recorded later, runs earlier
    assert_int_equal(earliest(&ranges, 0, 100, false), 0);
    assert_int_equal(earliest(&ranges, 0, 100, true), 6);
    note(&ranges, 0, 100, true, 6);
    assert_int_equal(earliest(&ranges, 0, 100, false), 7);
    assert_int_equal(earliest(&ranges, 0, 100, true), 7);
    free(ranges.list);
}

TEST(ranges_that_do_not_overlap_are_apart) {
    struct vw_ranges ranges = {0};
    note(&ranges, 0, 100, true, 4);
    note(&ranges, 100, 50, true, 9);
    assert_int_equal(earliest(&ranges, 0, 100, false), 5);
    assert_int_equal(earliest(&ranges, 50, 50, false), 5); // within
    assert_int_equal(earliest(&ranges, 100, 50, false), 10);
    assert_int_equal(earliest(&ranges, 99, 2, false), 10); // over both
    assert_int_equal(earliest(&ranges, 150, 1, true), 0);  // after both
    assert_int_equal(ranges.count, 5);
    free(ranges.list);
}

static void assert_epochs(const struct bench *bench, uint32_t commands, uint32_t barriers) {
    assert_int_equal(vw_submission_commands(bench->submission), commands);
    assert_int_equal(vw_command_list_barriers(vw_submission_list(bench->submission)), barriers);
}

TEST(a_read_after_a_write_waits_once) {
    struct bench bench = begin_bench(test_gpu());
    scale(bench.submission, bench.a_to_b, 3);
    scale(bench.submission, bench.b_to_c, 5);
    scale(bench.submission, bench.b_to_a, 1); // in parallel: b is visible already, and a was read before that barrier
    finish(bench.submission);
    assert_epochs(&bench, 3, 1);
    assert_values(bench.b, 3);
    assert_values(bench.c, 15);
    assert_values(bench.a, 3);
}

TEST(a_write_after_a_read_or_a_write_waits) {
    struct bench bench = begin_bench(test_gpu());
    scale(bench.submission, bench.b_to_c, 1);
    scale(bench.submission, bench.a_to_b, 3); // b was read
    scale(bench.submission, bench.a_to_b, 4); // b was written
    scale(bench.submission, bench.a_to_c, 7); // in parallel with the first write of b: c was written before
    finish(bench.submission);
    assert_epochs(&bench, 4, 2);
    assert_values(bench.b, 4);
    assert_values(bench.c, 7);
}

TEST(a_command_runs_as_early_as_it_may) {
    struct bench bench = open_bench(test_gpu());
    struct vw_buffer *d = make_buffer(bench.gpu, "d");
    vw_submission_begin(bench.submission);
    scale(bench.submission, bench.a_to_b, 3);
    scale(bench.submission, bench.b_to_c, 5);
    scale(bench.submission, bench.a_to_b, 7);                            // third epoch
    vw_submission_copy(bench.submission, bench.a, 0, d, 0, VALUE_BYTES); // recorded last, runs in the first epoch
    finish(bench.submission);
    assert_epochs(&bench, 4, 2);
    assert_values(bench.b, 7);
    assert_values(bench.c, 15);
    assert_values(d, 1);
}

TEST(slots_that_are_left_alone_wait_for_nobody) {
    struct bench bench = open_bench(test_gpu());
    struct vw_pass *to_nowhere = make_pass(bench.gpu, &scale_values, (struct vw_binding){.slot = 0, .buffer = bench.b},
                                           (struct vw_binding){.slot = 3, .unused = true});
    vw_submission_begin(bench.submission);
    for (int i = 0; i < 3; i++) {
        scale(bench.submission, bench.a_to_b, 3);
        vw_submission_dispatch(bench.submission, to_nowhere, &(struct scale_push){0, 1}, sizeof(struct scale_push),
                               VALUES);
    }
    finish(bench.submission);
    assert_epochs(&bench, 6, 5); // b is written, read, written ...
    to_nowhere = make_pass(bench.gpu, &scale_values, (struct vw_binding){.slot = 0, .unused = true},
                           (struct vw_binding){.slot = 3, .buffer = bench.c});
    vw_submission_begin(bench.submission);
    scale(bench.submission, bench.a_to_b, 3);
    vw_submission_dispatch(bench.submission, to_nowhere, &(struct scale_push){0, 1}, sizeof(struct scale_push), VALUES);
    finish(bench.submission);
    assert_epochs(&bench, 2, 0);
}

TEST(accumulation_and_texel_reads_wait) {
    struct bench bench = begin_bench(test_gpu());
    for (int i = 0; i < 3; i++) vw_submission_dispatch(bench.submission, bench.add_a_to_b, NULL, 0, VALUES);
    vw_submission_dispatch(bench.submission, bench.gather_b_to_c, NULL, 0, VALUES);
    finish(bench.submission);
    assert_epochs(&bench, 4, 3);
    assert_values(bench.c, 3);
}

TEST(copies_wait) {
    struct bench bench = open_bench(test_gpu());
    struct vw_buffer *back = test_buffer_of(
        bench.gpu, (struct vw_buffer_params){.name = "back", .size_bytes = VALUE_BYTES, .memory = VW_BUFFER_READBACK});
    vw_submission_begin(bench.submission);
    scale(bench.submission, bench.a_to_b, 3);
    vw_submission_copy(bench.submission, bench.b, 0, bench.c, 0, VALUE_BYTES);
    scale(bench.submission, bench.b_to_a, 2);                                   // in parallel with the copy
    vw_submission_copy(bench.submission, bench.c, 0, back, 0, VALUE_BYTES / 2); // the two halves go side by side
    vw_submission_copy(bench.submission, bench.a, VALUE_BYTES / 2, back, VALUE_BYTES / 2, VALUE_BYTES / 2);
    finish(bench.submission);
    assert_epochs(&bench, 5, 2);
    const uint32_t *values = vw_buffer_map(back);
    for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], (i < VALUES / 2 ? 3 : 6) * (i + 1));
}

TEST(submissions_in_flight_run_in_order) {
    struct bench bench = open_bench(test_gpu());
    struct vw_submission *second = test_submission(test_gpu());
    for (int round = 0; round < 4; round++) { // each submission is recorded again and again
        vw_submission_begin(bench.submission);
        scale(bench.submission, bench.a_to_b, 2);
        ASSERT_OK(vw_submission_submit(bench.submission));
        vw_submission_begin(second);
        scale(second, bench.b_to_a, 3);
        ASSERT_OK(vw_submission_submit(second));
        ASSERT_OK(vw_submission_wait(bench.submission));
        ASSERT_OK(vw_submission_wait(second));
    }
    assert_values(bench.a, 6 * 6 * 6 * 6);
}

// ---- Dispatching ----------------------------------------------------------------------------------------------------

TEST(a_dispatch_folds_into_y) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.workgroup_count_x = 3; // VALUES take 4 workgroups
    struct bench bench = begin_bench(test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = &clamp}));
    scale(bench.submission, bench.a_to_b, 9);
    finish(bench.submission);
    assert_values(bench.b, 9);
}

TEST(a_fold_covers_every_workgroup_beyond_the_clamp) {
    struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
    clamp.workgroup_count_x = 2;
    clamp.workgroup_count_y = 2;
    struct bench bench = begin_bench(test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = &clamp}));
    scale(bench.submission, bench.a_to_b, 2);
    finish(bench.submission);
    assert_values(bench.b, 2);
    vw_submission_begin(bench.submission);
    vw_submission_dispatch(bench.submission, bench.a_to_b, &(struct scale_push){VALUES, 1}, sizeof(struct scale_push),
                           VALUES + 1);
    ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE,
                 "pass scale_values: 257 invocations are too many");
}

static void dispatch_listed(struct bench *bench, const struct vw_pass *pass, struct vw_buffer *groups,
                            uint64_t offset_bytes) {
    vw_submission_dispatch_indirect(bench->submission, pass, &(struct scale_push){VALUES, 3}, sizeof(struct scale_push),
                                    groups, offset_bytes);
}

// Runs a_to_b over as many workgroups of 64 as b's neighbour c says, and expects the first `count` values.
static void assert_listed_groups(uint32_t x, uint32_t y, uint32_t z, uint32_t count) {
    struct bench bench = open_bench(test_gpu());
    const uint32_t groups[] = {9, x, y, z};
    uint32_t values[VALUES];
    ASSERT_OK(vw_buffer_write(bench.c, 0, groups, sizeof groups));
    vw_submission_begin(bench.submission);
    dispatch_listed(&bench, bench.a_to_b, bench.c, 4);
    finish(bench.submission);
    ASSERT_OK(vw_buffer_read(bench.b, 0, values, VALUE_BYTES));
    for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], i < count ? 3 * (i + 1) : 0);
}

TEST(listed_workgroups_run) {
    assert_listed_groups(0, 1, 1, 0);
    assert_listed_groups(4, 0, 1, 0);
    assert_listed_groups(1, 1, 1, 64);
    assert_listed_groups(3, 1, 1, 192);
    assert_listed_groups(2, 2, 1, 256); // folded
    assert_listed_groups(3, 1, 2, 192); // z repeats
}

TEST(listed_workgroups_wait_for_who_lists_them) {
    struct bench bench = open_bench(test_gpu());
    uint32_t values[VALUES];
    vw_submission_begin(bench.submission);
    scale(bench.submission, bench.a_to_c, 1); // 1, 2, 3
    dispatch_listed(&bench, bench.a_to_b, bench.c, 0);
    scale(bench.submission, bench.a_to_c, 2); // overwrites what was read, so it waits: 2, 4, 6
    dispatch_listed(&bench, bench.a_to_b, bench.c, 8);
    scale(bench.submission, bench.b_to_c, 0);          // writes c and reads b
    dispatch_listed(&bench, bench.a_to_b, bench.c, 0); // none
    finish(bench.submission);
    assert_epochs(&bench, 6, 5);
    ASSERT_OK(vw_buffer_read(bench.b, 0, values, VALUE_BYTES));
    for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], 3 * (i + 1)); // 6 x 8 workgroups cover all
}

TEST(listed_workgroups_out_of_place_are_refused) {
    struct bench bench = open_bench(test_gpu());
    static const struct {
        uint64_t offset_bytes;
        const char *part;
    } wrong[] = {{2, "not a multiple of 4"}, {VALUE_BYTES - 8, "buffer c"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(wrong); i++) {
        vw_submission_begin(bench.submission);
        dispatch_listed(&bench, bench.a_to_b, bench.c, wrong[i].offset_bytes);
        ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE, wrong[i].part);
    }
    vw_submission_begin(bench.submission);
    vw_submission_dispatch_indirect(bench.submission, bench.a_to_b, NULL, 0, bench.c, 0);
    ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE, "0 bytes pushed");
}

TEST(nothing_to_do_is_done) {
    struct bench bench = open_bench(test_gpu());
    ASSERT_OK(vw_submission_wait(bench.submission)); // never submitted
    vw_submission_begin(bench.submission);
    vw_submission_dispatch(bench.submission, bench.a_to_b, &(struct scale_push){0}, sizeof(struct scale_push), 0);
    vw_submission_copy(bench.submission, bench.a, VALUE_BYTES, bench.b, 0, 0);
    finish(bench.submission);
    assert_values(bench.b, 0);
}

TEST(the_first_failure_sticks_until_submit) {
    struct bench bench = begin_bench(test_gpu());
    vw_submission_dispatch(bench.submission, bench.a_to_b, &(uint32_t){0}, 4, VALUES);
    vw_submission_copy(bench.submission, bench.a, 4, bench.b, 0, VALUE_BYTES);
    scale(bench.submission, bench.a_to_b, 3);
    ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE,
                 "pass scale_values: 4 bytes pushed, the shader has 8");
    assert_values(bench.b, 0);

    vw_submission_begin(bench.submission);
    vw_submission_copy(bench.submission, bench.a, 4, bench.b, 0, VALUE_BYTES);
    ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE, "buffer a");

    vw_submission_begin(bench.submission); // begin forgives
    scale(bench.submission, bench.a_to_b, 3);
    finish(bench.submission);
    assert_values(bench.b, 3);
}

TEST(one_submission_records_at_a_time) {
    struct bench bench = open_bench(test_gpu());
    struct vw_submission *second = NULL;
    ASSERT_OK(vw_submission_create(test_gpu(), &second));
    ASSERT_FAILS(vw_submission_submit(second), VW_ERROR_DEVICE, "vw_submission_begin"); // never begun
    vw_submission_begin(bench.submission);
    vw_submission_begin(second);
    scale(second, bench.a_to_b, 2);
    ASSERT_FAILS(vw_submission_submit(second), VW_ERROR_DEVICE, "only one submission can record at a time");
    scale(bench.submission, bench.a_to_b, 3);
    ASSERT_OK(vw_submission_submit(bench.submission));
    vw_submission_begin(bench.submission);
    ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE, "in flight");
    ASSERT_OK(vw_submission_wait(bench.submission));
    vw_submission_begin(second);
    vw_submission_destroy(&second); // an abandoned recording makes room
    vw_submission_begin(bench.submission);
    scale(bench.submission, bench.b_to_c, 2);
    finish(bench.submission);
    assert_values(bench.c, 6);
}

// ---- Submitting again -----------------------------------------------------------------------------------------------

static void submit_scale(const struct bench *bench, const struct vw_pass *pass, uint32_t factor, uint64_t invocations) {
    vw_submission_begin(bench->submission);
    vw_submission_dispatch(bench->submission, pass, &(struct scale_push){VALUES, factor}, sizeof(struct scale_push),
                           invocations);
    finish(bench->submission);
}

static void assert_recordings(const struct bench *bench, uint64_t recordings) {
    assert_int_equal(vw_submission_recordings(bench->submission), recordings);
}

TEST(equal_commands_are_submitted_again_with_other_pushes) {
    for (int forbidden = 0; forbidden < 2; forbidden++) {
        struct vw_gpu_limits clamp = *vw_gpu_get_limits(test_gpu());
        clamp.resubmits = !forbidden;
        struct bench bench = open_bench(test_gpu_open((struct vw_gpu_params){.validation = true, .clamp = &clamp}));
        for (uint32_t round = 1; round <= 3; round++) {
            vw_submission_begin(bench.submission);
            scale(bench.submission, bench.a_to_b, round);
            scale(bench.submission, bench.b_to_c, 5);
            vw_submission_copy(bench.submission, bench.b, 0, bench.a, 0, VALUE_BYTES);
            finish(bench.submission);
            assert_epochs(&bench, 3, 1);
            assert_recordings(&bench, forbidden ? round : 1);
        }
        assert_values(bench.a, 1 * 2 * 3);
        assert_values(bench.c, 1 * 2 * 3 * 5);
    }
}

TEST(other_commands_are_recorded) {
    struct bench bench = open_bench(test_gpu());
    const uint32_t groups[] = {1, 1, 1, 1, 1};
    uint64_t recordings = 0;
    ASSERT_OK(vw_buffer_write(bench.c, 0, groups, sizeof groups));
    for (uint64_t offset_bytes = 0; offset_bytes <= 4; offset_bytes += 4) { // listed elsewhere
        vw_submission_begin(bench.submission);
        dispatch_listed(&bench, bench.a_to_b, bench.c, offset_bytes);
        finish(bench.submission);
        assert_recordings(&bench, ++recordings);
    }
    submit_scale(&bench, bench.a_to_b, 0, VALUES); // not listed
    assert_recordings(&bench, ++recordings);
    assert_values(bench.b, 0);
    submit_scale(&bench, bench.a_to_b, 9, VALUES / 2); // fewer workgroups
    assert_recordings(&bench, ++recordings);
    submit_scale(&bench, bench.a_to_c, 7, VALUES / 2); // another pass
    assert_recordings(&bench, ++recordings);
    for (uint64_t from_bytes = 0; from_bytes < VALUE_BYTES; from_bytes += VALUE_BYTES / 2) { // other copies
        vw_submission_begin(bench.submission);
        vw_submission_copy(bench.submission, bench.b, 0, bench.c, from_bytes, VALUE_BYTES / 2);
        finish(bench.submission);
        assert_recordings(&bench, ++recordings);
    }
    uint32_t values[VALUES];
    ASSERT_OK(vw_buffer_read(bench.c, 0, values, VALUE_BYTES));
    for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], 9 * (i % (VALUES / 2) + 1));
}

TEST(more_and_fewer_commands_are_recorded) {
    static const uint32_t counts[] = {1, 200, 199, 1}; // with more pushes than there was room for
    struct bench bench = open_bench(test_gpu());
    uint32_t values[VALUES];
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(counts); i++) {
        vw_submission_begin(bench.submission);
        for (uint32_t k = 0; k < counts[i]; k++) // the k-th reaches the first values
            vw_submission_dispatch(bench.submission, bench.a_to_b, &(struct scale_push){counts[i] - k, i + k},
                                   sizeof(struct scale_push), VALUES);
        finish(bench.submission);
        assert_recordings(&bench, i + 1);
        ASSERT_OK(vw_buffer_read(bench.b, 0, values, VALUE_BYTES));
        for (uint32_t k = 0; k < counts[i]; k++) assert_int_equal(values[k], (i + counts[i] - 1 - k) * (k + 1));
    }
}

// Another pass may be where one was.
TEST(what_was_destroyed_is_not_submitted_again) {
    struct bench bench = open_bench(test_gpu());
    const struct vw_binding bindings[] = {{.slot = 0, .buffer = bench.a}, {.slot = 3, .buffer = bench.b}};
    for (uint32_t offset = 1; offset <= 4; offset++) {
        const uint32_t specialization[] = {0, 0, offset};
        struct vw_pass *pass = NULL;
        ASSERT_OK(vw_pass_create(bench.gpu,
                                 &(struct vw_pass_params){.shader = &scale_values,
                                                          .specialization = specialization,
                                                          .specialization_count = 3,
                                                          .bindings = bindings,
                                                          .binding_count = 2},
                                 &pass));
        submit_scale(&bench, pass, 3, VALUES);
        uint32_t values[VALUES];
        ASSERT_OK(vw_buffer_read(bench.b, 0, values, VALUE_BYTES));
        for (uint32_t i = 0; i < VALUES; i++) assert_int_equal(values[i], 3 * (i + 1) + offset);
        vw_pass_destroy(&pass);
    }
    assert_recordings(&bench, 4);
    for (int i = 0; i < 2; i++) submit_scale(&bench, bench.a_to_c, 2, VALUES);
    assert_recordings(&bench, 5);
    struct vw_buffer *buffer = NULL;
    ASSERT_OK(vw_buffer_create(bench.gpu, &(struct vw_buffer_params){.name = "any", .size_bytes = 4}, &buffer));
    vw_buffer_destroy(&buffer);
    submit_scale(&bench, bench.a_to_c, 2, VALUES);
    assert_recordings(&bench, 6);
}

TEST(a_failure_between_leaves_no_trace) {
    struct bench bench = open_bench(test_gpu());
    const struct vw_pass *const begun[] = {bench.a_to_b, bench.a_to_c}; // the same as before, and another
    submit_scale(&bench, bench.a_to_b, 2, VALUES);
    for (uint32_t i = 0; i < 2; i++) {
        vw_submission_begin(bench.submission);
        scale(bench.submission, begun[i], 7);
        vw_submission_dispatch(bench.submission, bench.a_to_b, NULL, 0, VALUES);
        ASSERT_FAILS(vw_submission_submit(bench.submission), VW_ERROR_DEVICE, "0 bytes pushed");
        submit_scale(&bench, bench.a_to_b, 3 + i, VALUES);
        assert_values(bench.b, 3 + i);
        assert_recordings(&bench, 1 + i);
    }
    assert_values(bench.c, 0);
}

// ---- Timers ---------------------------------------------------------------------------------------------------------

TEST(timers_add_up_by_pass_name) {
    if (!vw_gpu_get_limits(test_gpu())->timestamps) skip();
    struct vw_gpu *gpu = test_gpu_open((struct vw_gpu_params){.validation = true, .timers = true});
    struct bench bench = open_bench(gpu);
    uint32_t count = 99;
    vw_gpu_timers(gpu, &count);
    assert_int_equal(count, 0);
    for (int round = 0; round < 2; round++) {
        vw_submission_begin(bench.submission);
        scale(bench.submission, bench.a_to_b, 2);
        vw_submission_dispatch(bench.submission, bench.gather_b_to_c, NULL, 0, VALUES);
        scale(bench.submission, bench.b_to_c, 2);
        finish(bench.submission);
    }
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    assert_int_equal(count, 2);
    assert_string_equal(timers[0].name, "scale_values");
    assert_int_equal(timers[0].dispatches, 4);
    assert_string_equal(timers[1].name, "gather_texels");
    assert_int_equal(timers[1].dispatches, 2);
    for (uint32_t i = 0; i < count; i++) assert_true(timers[i].total_ms > 0 && timers[i].total_ms < 60000);
    assert_recordings(&bench, 2);
}

TEST(there_are_no_timers_unless_asked) {
    struct bench bench = begin_bench(test_gpu());
    scale(bench.submission, bench.a_to_b, 2);
    finish(bench.submission);
    uint32_t count = 99;
    vw_gpu_timers(test_gpu(), &count);
    assert_int_equal(count, 0);
}

TEST_GROUP(NULL, test_gpu_close)
