#include <string.h>

#include "gpu/shaders.h"
#include "interface.h"
#include "viewworth/gpu.h"
#include "base/clock.h"
#include "gpu/compute.h"
#include "base/memory.h"

// Enough invocations to fill any device, and buffers beyond most caches but within the smallest storage binding.
enum { INVOCATIONS = 1 << 18, COPY_BYTES = 64 << 20, ROUNDS = 5 };

// What the device's own timer has counted for the pass; 0 without timers.
static double timed_s(const struct vw_gpu *gpu, const struct vw_pass *pass) {
    uint32_t count = 0;
    const struct vw_gpu_timer *timers = vw_gpu_timers(gpu, &count);
    for (uint32_t i = 0; i < count; i++)
        if (!strcmp(timers[i].name, vw_pass_name(pass))) return 1e-3 * timers[i].total_ms;
    return 0.0;
}

// The shortest of a few rounds, after one to warm up: a peak is what was once reached. By the device's clock where it
// has one, since a fast device is done before the host has noticed.
static enum vw_status time_pass(struct vw_gpu *gpu, struct vw_batch *batch, const struct vw_pass *pass,
                                const struct vw_push_peak *push, uint64_t invocations, double *shortest_s) {
    enum vw_status status = VW_OK;
    for (int round = 0; round <= ROUNDS && status == VW_OK; round++) {
        double started_s = vw_now_s(), timed_before_s = timed_s(gpu, pass);
        vw_batch_begin(batch);
        vw_batch_dispatch(batch, pass, push, push ? sizeof *push : 0, invocations);
        status = vw_batch_submit(batch);
        if (status == VW_OK) status = vw_batch_wait(batch);
        double passed_s = vw_now_s() - started_s, device_s = timed_s(gpu, pass) - timed_before_s;
        if (device_s > 0.0) passed_s = device_s;
        if (round == 1 || (round > 1 && passed_s < *shortest_s)) *shortest_s = passed_s;
    }
    return status;
}

static enum vw_status measure(struct vw_gpu *gpu, const struct vw_shader *shader, const struct vw_binding *bindings,
                              uint32_t binding_count, const struct vw_push_peak *push, uint64_t invocations,
                              double *shortest_s) {
    struct vw_pass *pass = NULL;
    struct vw_batch *batch = NULL;
    const struct vw_pass_params params = {.shader = shader, .bindings = bindings, .binding_count = binding_count};
    enum vw_status status = vw_pass_create(gpu, &params, &pass);
    if (status == VW_OK) status = vw_batch_create(gpu, &batch);
    if (status == VW_OK) status = time_pass(gpu, batch, pass, push, invocations, shortest_s);
    vw_batch_destroy(&batch);
    vw_pass_destroy(&pass);
    return status;
}

enum vw_status vw_gpu_measure_peaks(struct vw_gpu *gpu, struct vw_gpu_peaks *peaks) {
    struct vw_buffer *from = NULL, *to = NULL;
    double multiply_s = 0.0, copy_s = 0.0;
    const struct vw_push_peak push = {.start = 0.25f, .factor = 0.75f}; // a chain that stays between 0 and 8
    enum vw_status status =
        vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "peak_from", .size_bytes = COPY_BYTES}, &from);
    if (status == VW_OK)
        status = vw_buffer_create(gpu, &(struct vw_buffer_params){.name = "peak_to", .size_bytes = COPY_BYTES}, &to);
    const struct vw_binding bindings[] = {{.slot = VW_SLOT_PEAK_FROM, .buffer = from},
                                          {.slot = VW_SLOT_PEAK_TO, .buffer = to}};
    if (status == VW_OK)
        status = measure(gpu, &vw_shader_multiply_registers, bindings, VW_ARRAY_COUNT(bindings), &push, INVOCATIONS,
                         &multiply_s);
    if (status == VW_OK)
        status =
            measure(gpu, &vw_shader_copy_memory, bindings, VW_ARRAY_COUNT(bindings), NULL, COPY_BYTES / 16, &copy_s);
    vw_buffer_destroy(&from);
    vw_buffer_destroy(&to);
    if (status != VW_OK) return status;
    peaks->multiply_adds_per_s = 8.0 * 4.0 * VW_PEAK_TRIPS * VW_PEAK_REPEATS * INVOCATIONS / multiply_s;
    peaks->copy_bytes_per_s = 2.0 * COPY_BYTES / copy_s;
    return VW_OK;
}
