// Waits of the device for the host, which are counted, and waits of the host that end although the device hangs.
#include "support/cmocka_test.h"

#include "base/clock.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "multiply_registers.h"
#include "support/gpu_fixture.h"

static const struct vw_shader multiply_registers = {"multiply_registers", multiply_registers_code,
                                                    sizeof multiply_registers_code};

// ---- Host-bound submissions -----------------------------------------------------------------------------------------

enum { BUSY_INVOCATIONS = 1 << 16 }; // a tenth of a second of two CPUs

// Submits the pass; returns whether that was host-bound.
static bool is_host_bound(struct vw_submission *submission, const struct vw_pass *pass, uint64_t invocations) {
    static const float push[] = {0.25f, 0.75f}; // start and factor
    struct vw_submission_counts before = vw_gpu_submission_counts(test_gpu());
    vw_submission_begin(submission);
    vw_submission_dispatch(submission, pass, push, sizeof push, invocations);
    ASSERT_OK(vw_submission_submit(submission));
    struct vw_submission_counts after = vw_gpu_submission_counts(test_gpu());
    assert_int_equal(after.submitted - before.submitted, 1);
    return after.host_bound > before.host_bound;
}

TEST(submissions_to_a_device_that_waits_are_counted) {
    struct vw_submission *one = test_submission(test_gpu()), *other = test_submission(test_gpu());
    struct vw_buffer *buffer = test_buffer(test_gpu(), "to", 16 * BUSY_INVOCATIONS);
    const struct vw_binding to = {.slot = 0, .buffer = buffer};
    const struct vw_pass *pass = test_pass(
        test_gpu(), (struct vw_pass_params){.shader = &multiply_registers, .bindings = &to, .binding_count = 1});
    uint32_t word;
    bool beside = true;
    assert_true(is_host_bound(one, pass, 1));
    ASSERT_OK(vw_submission_wait(one));
    assert_true(is_host_bound(one, pass, 1));
    ASSERT_OK(vw_buffer_read(buffer, 0, &word, sizeof word)); // ends what it does not wait for
    assert_true(is_host_bound(other, pass, 1));
    for (int attempt = 0; attempt < 10 && beside; attempt++) { // since the host may lose its core for that long
        ASSERT_OK(vw_submission_wait(other));
        ASSERT_OK(vw_submission_wait(one));
        assert_true(is_host_bound(one, pass, BUSY_INVOCATIONS));
        beside = is_host_bound(other, pass, 1);
    }
    ASSERT_OK(vw_submission_wait(other));
    ASSERT_OK(vw_submission_wait(one));
    assert_false(beside);
}

// ---- Waits that end ------------------------------------------------------------------------------------------------

static const char LIMIT_NAME[] = "VIEWWORTH_DEVICE_TIMEOUT_S";

TEST(a_limit_that_is_no_time_is_refused) {
    static const char *const limits[] = {"", "soon", "0", "-1", "1e30", "nan", "5 s"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(limits); i++) {
        struct vw_gpu *gpu = NULL;
        assert_int_equal(setenv(LIMIT_NAME, limits[i], 1), 0);
        ASSERT_FAILS(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu), VW_ERROR_USAGE, LIMIT_NAME);
        assert_null(gpu);
    }
    unsetenv(LIMIT_NAME);
}

// A pass that takes longer than the limit stands for a device that hangs. The report comes while it runs; what follows
// fails at once, and nothing that it uses is destroyed, which the device would not survive.
TEST(a_device_that_hangs_is_reported_and_closed) {
    enum { INVOCATIONS = 1 << 27 };             // more than a second of two CPUs, many times the limit
    static const float push[] = {0.25f, 0.75f}; // start and factor
    struct vw_gpu *gpu = NULL;
    struct vw_submission *submission = NULL, *second = NULL;
    struct vw_pass *pass = NULL;
    struct vw_buffer *to = NULL;
    assert_int_equal(setenv(LIMIT_NAME, "0.3", 1), 0);
    ASSERT_OK(vw_gpu_open(&(struct vw_gpu_params){0}, &gpu));
    unsetenv(LIMIT_NAME);
    ASSERT_OK(vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "to", .size_bytes = 16}, &to));
    ASSERT_OK(vw_pass_create(gpu,
                             &(struct vw_pass_params){.shader = &multiply_registers,
                                                      .bindings = &(struct vw_binding){.slot = 0, .buffer = to},
                                                      .binding_count = 1},
                             &pass));
    ASSERT_OK(vw_submission_create(gpu, &submission));
    ASSERT_OK(vw_submission_create(gpu, &second));
    vw_submission_begin(submission);
    vw_submission_dispatch(submission, pass, push, sizeof push, INVOCATIONS);
    ASSERT_OK(vw_submission_submit(submission));
    double started_s = vw_now_s();
    ASSERT_FAILS(vw_submission_wait(submission), VW_ERROR_DEVICE_LOST,
                 "did not finish a submission of 1 commands in 0.3 s; if it is only slow");
    vw_submission_begin(second);
    ASSERT_FAILS(vw_submission_submit(second), VW_ERROR_DEVICE_LOST, "did not finish an earlier submission");
    uint32_t word;
    ASSERT_FAILS(vw_buffer_read(to, 0, &word, sizeof word), VW_ERROR_DEVICE_LOST, "did not finish buffer to");
    vw_submission_destroy(&submission);
    vw_submission_destroy(&second);
    vw_pass_destroy(&pass);
    vw_buffer_destroy(&to);
    ASSERT_OK(vw_gpu_close(&gpu));
    assert_null(gpu);
    print_message("reported and closed in %.3f s\n", vw_now_s() - started_s);
}

TEST_GROUP(NULL, test_gpu_close)
