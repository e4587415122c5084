#include "support/gpu_fixture.h"
#include "support/cmocka_test.h"

static struct vw_gpu *shared_gpu;

struct vw_gpu *test_gpu(void) {
    // The layer compares submissions with each other only when its own setting says so.
    setenv("VK_LAYER_ENABLES", "VALIDATION_CHECK_ENABLE_SYNCHRONIZATION_VALIDATION_QUEUE_SUBMIT", 0);
    if (!shared_gpu && vw_gpu_open(&(struct vw_gpu_params){.validation = true}, &shared_gpu))
        fail_msg("%s", vw_error_message());
    return shared_gpu;
}

static void close_gpu(void *gpu) { ASSERT_OK(vw_gpu_close(&(struct vw_gpu *){gpu})); }

struct vw_gpu *test_gpu_open(struct vw_gpu_params params) {
    struct vw_gpu *gpu = NULL;
    ASSERT_OK(vw_gpu_open(&params, &gpu));
    return test_own(gpu, close_gpu);
}

static void destroy_buffer(void *buffer) { vw_buffer_destroy(&(struct vw_buffer *){buffer}); }
static void destroy_pass(void *pass) { vw_pass_destroy(&(struct vw_pass *){pass}); }
static void destroy_submission(void *submission) { vw_submission_destroy(&(struct vw_submission *){submission}); }

struct vw_buffer *test_buffer_of(struct vw_gpu *gpu, struct vw_buffer_params params) {
    struct vw_buffer *buffer = NULL;
    ASSERT_OK(vw_buffer_create(gpu, &params, &buffer));
    return test_own(buffer, destroy_buffer);
}

struct vw_buffer *test_buffer(struct vw_gpu *gpu, const char *name, uint64_t size_bytes) {
    return test_buffer_of(gpu, (struct vw_buffer_params){.name = name, .size_bytes = size_bytes});
}

struct vw_pass *test_pass(struct vw_gpu *gpu, struct vw_pass_params params) {
    struct vw_pass *pass = NULL;
    ASSERT_OK(vw_pass_create(gpu, &params, &pass));
    return test_own(pass, destroy_pass);
}

struct vw_submission *test_submission(struct vw_gpu *gpu) {
    struct vw_submission *submission = NULL;
    ASSERT_OK(vw_submission_create(gpu, &submission));
    return test_own(submission, destroy_submission);
}

void test_submit(struct vw_submission *submission) {
    ASSERT_OK(vw_submission_submit(submission));
    ASSERT_OK(vw_submission_wait(submission));
}

void *test_read(struct vw_buffer *buffer) {
    uint64_t size_bytes = vw_buffer_size_bytes(buffer);
    void *data = test_allocate(1, size_bytes);
    ASSERT_OK(vw_buffer_read(buffer, 0, data, size_bytes));
    return data;
}

void test_write(struct vw_buffer *buffer, const void *data) {
    ASSERT_OK(vw_buffer_write(buffer, 0, data, vw_buffer_size_bytes(buffer)));
}

int test_gpu_close(void **state) {
    (void)state;
    test_release_to(0); // buffers before their device
    if (!vw_gpu_close(&shared_gpu)) return 0;
    fprintf(stderr, "%s\n", vw_error_message());
    return -1;
}
