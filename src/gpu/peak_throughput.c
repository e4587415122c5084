#include "gpu/peak_throughput.h"

#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/memory.h"
#include "gpu/compute.h"
#include "gpu/shaders.h"
#include "interface.h"

enum {
    INVOCATIONS = 1 << 18,     // enough to fill any device
    COPY_BYTES_MIN = 64 << 20, // within the smallest storage binding
    COPY_BYTES_MAX = 1 << 30,  // beyond the caches of GPUs
    CACHE_FACTOR = 8,
    CACHE_BYTES_USUAL = 32 << 20, // where the system does not tell
    WINDOWS_MAX = 64,
    ROUNDS_MIN = 2,
    ROUNDS_MAX = 5,
};

static const double BUDGET_S = 0.25; // time for the rounds of one measurement, beyond the least number

// Returns the seconds that the device's own timer has counted for the pass; 0 without timers.
static double timed_s(const struct vw_gpu *gpu, const struct vw_pass *pass) {
    uint32_t count = 0;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(timers[i].name, vw_pass_name(pass))) return 1e-3 * timers[i].total_ms;
    return 0.0;
}

// Measures the shortest of a few rounds, after one to warm up: a peak is the best that was reached. It uses the
// device's clock if there is one, since a fast device is done before the host has noticed.
static enum vw_status time_passes(struct vw_gpu *gpu, struct vw_submission *submission, struct vw_pass *const *passes,
                                  uint32_t count, const struct vw_push_peak *push, uint64_t invocations,
                                  double *shortest_s) {
    enum vw_status status = VW_OK;
    double first_s = vw_now_s();
    for (int round = 0; round <= ROUNDS_MAX && !status; round++) {
        double started_s = vw_now_s(), timed_before_s = timed_s(gpu, passes[0]);
        if (round > ROUNDS_MIN && started_s - first_s > BUDGET_S) break;
        vw_submission_begin(submission);
        for (uint32_t i = 0; i < count; i++)
            vw_submission_dispatch(submission, passes[i], push, push ? sizeof *push : 0, invocations);
        status = vw_submission_submit(submission);
        if (!status) status = vw_submission_wait(submission);
        double passed_s = vw_now_s() - started_s, device_s = timed_s(gpu, passes[0]) - timed_before_s;
        if (device_s > 0.0) passed_s = device_s;
        if (round == 1 || (round > 1 && passed_s < *shortest_s)) *shortest_s = passed_s;
    }
    return status;
}

static enum vw_status measure_multiplies(struct vw_gpu *gpu, double *per_s) {
    const struct vw_push_peak push = {.start = 0.25f, .factor = 0.75f}; // a chain that stays between 0 and 8
    struct vw_buffer *to = NULL;
    struct vw_pass *pass = NULL;
    struct vw_submission *submission = NULL;
    double shortest_s = 0.0;
    enum vw_status status =
        vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "peak_to", .size_bytes = 16 * INVOCATIONS}, &to);
    const struct vw_binding binding = {.slot = VW_SLOT_PEAK_TO, .buffer = to};
    const struct vw_pass_params params = {
        .shader = &vw_shader_multiply_registers, .bindings = &binding, .binding_count = 1};
    if (!status) status = vw_pass_create(gpu, &params, &pass);
    if (!status) status = vw_submission_create(gpu, &submission);
    if (!status) status = time_passes(gpu, submission, &pass, 1, &push, INVOCATIONS, &shortest_s);
    if (!status) *per_s = 8.0 * 4.0 * VW_PEAK_TRIPS * VW_PEAK_REPEATS * INVOCATIONS / shortest_s;
    vw_submission_destroy(&submission);
    vw_pass_destroy(&pass);
    vw_buffer_destroy(&to);
    return status;
}

// ---- Copies ---------------------------------------------------------------------------------------------------------

uint64_t vw_peak_copy_bytes(const struct vw_gpu_info *info, const struct vw_gpu_limits *limits, uint64_t cache_bytes) {
    uint64_t bytes = info->kind == VW_GPU_CPU ? CACHE_FACTOR * cache_bytes : COPY_BYTES_MAX;
    uint64_t most = limits->buffer_bytes < info->memory_bytes / 4 ? limits->buffer_bytes : info->memory_bytes / 4;
    if (bytes > most) bytes = most;
    if (bytes < COPY_BYTES_MIN) bytes = COPY_BYTES_MIN;
    return bytes / COPY_BYTES_MIN * COPY_BYTES_MIN;
}

static uint64_t cache_bytes(void) {
#ifdef _SC_LEVEL3_CACHE_SIZE
    long bytes = sysconf(_SC_LEVEL3_CACHE_SIZE);
    if (bytes > 0) return (uint64_t)bytes;
#endif
    return CACHE_BYTES_USUAL;
}

// A copy from one buffer to another, in windows that fit a binding.
struct copy {
    struct vw_buffer *from, *to;
    struct vw_pass *windows[WINDOWS_MAX];
    uint32_t window_count;
    uint64_t window_bytes, size_bytes;
};

static void destroy_copy(struct copy *copy) {
    for (uint32_t i = 0; i < WINDOWS_MAX; i++) vw_pass_destroy(&copy->windows[i]);
    vw_buffer_destroy(&copy->from);
    vw_buffer_destroy(&copy->to);
}

// Retries with fewer bytes, since other programs may use memory that the device reports as free.
static enum vw_status create_buffers(struct vw_gpu *gpu, struct copy *copy) {
    enum vw_status status;
    copy->size_bytes = vw_peak_copy_bytes(vw_gpu_get_info(gpu), vw_gpu_get_limits(gpu), cache_bytes());
    do {
        const struct vw_buffer_params from = {.name = "peak_from", .size_bytes = copy->size_bytes},
                                      to = {.name = "peak_to", .size_bytes = copy->size_bytes};
        status = vw_buffer_create(gpu, &from, &copy->from);
        if (!status) status = vw_buffer_create(gpu, &to, &copy->to);
        if (status != VW_ERROR_MEMORY || copy->size_bytes <= COPY_BYTES_MIN) return status;
        vw_buffer_destroy(&copy->from);
        copy->size_bytes = copy->size_bytes / 2 / COPY_BYTES_MIN * COPY_BYTES_MIN;
    } while (copy->size_bytes);
    return status;
}

static enum vw_status create_windows(struct vw_gpu *gpu, struct copy *copy) {
    enum vw_status status = VW_OK;
    uint64_t binding_bytes = vw_gpu_get_limits(gpu)->storage_binding_bytes;
    copy->window_bytes = copy->size_bytes;
    while (copy->window_bytes > binding_bytes) copy->window_bytes /= 2; // sizes are multiples of a large power of two
    copy->window_count = (uint32_t)(copy->size_bytes / copy->window_bytes);
    if (copy->window_count > WINDOWS_MAX) copy->window_count = WINDOWS_MAX;
    for (uint32_t i = 0; i < copy->window_count && !status; i++) {
        const struct vw_binding bindings[] = {{.slot = VW_SLOT_PEAK_FROM,
                                               .buffer = copy->from,
                                               .offset_bytes = i * copy->window_bytes,
                                               .size_bytes = copy->window_bytes},
                                              {.slot = VW_SLOT_PEAK_TO,
                                               .buffer = copy->to,
                                               .offset_bytes = i * copy->window_bytes,
                                               .size_bytes = copy->window_bytes}};
        const struct vw_pass_params params = {
            .shader = &vw_shader_copy_memory, .bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
        status = vw_pass_create(gpu, &params, &copy->windows[i]);
    }
    return status;
}

static enum vw_status measure_copies(struct vw_gpu *gpu, double *bytes_per_s) {
    struct copy copy = {0};
    struct vw_submission *submission = NULL;
    double shortest_s = 0.0;
    enum vw_status status = create_buffers(gpu, &copy);
    if (!status) status = create_windows(gpu, &copy);
    if (!status) status = vw_submission_create(gpu, &submission);
    if (!status)
        status =
            time_passes(gpu, submission, copy.windows, copy.window_count, NULL, copy.window_bytes / 16, &shortest_s);
    if (!status) *bytes_per_s = 2.0 * (double)copy.window_count * (double)copy.window_bytes / shortest_s;
    vw_submission_destroy(&submission);
    destroy_copy(&copy);
    return status;
}

enum vw_status vw_gpu_measure_peaks(struct vw_gpu *gpu, struct vw_gpu_peaks *peaks) {
    struct vw_gpu_peaks measured = {0};
    enum vw_status status = measure_multiplies(gpu, &measured.multiply_adds_per_s);
    if (!status) status = measure_copies(gpu, &measured.copy_bytes_per_s);
    if (!status) *peaks = measured;
    return status;
}
