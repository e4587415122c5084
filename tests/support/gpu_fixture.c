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

int test_gpu_close(void **state) {
    (void)state;
    test_release_to(0); // buffers before their device
    if (!vw_gpu_close(&shared_gpu)) return 0;
    fprintf(stderr, "%s\n", vw_error_message());
    return -1;
}
