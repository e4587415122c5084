// Vulkan devices: which there are, what they can do, and opening one.
#ifndef VIEWWORTH_GPU_H
#define VIEWWORTH_GPU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "viewworth/status.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

struct vw_gpu;

// The limits of a device that viewworth needs. Sizes are in bytes unless named otherwise.
struct vw_gpu_limits {
    uint64_t storage_binding_bytes; // largest range of one storage-buffer binding
    uint64_t buffer_bytes;          // largest single buffer (and memory allocation)
    uint32_t texel_elements;        // most texels of one texel-buffer view
    uint32_t shared_memory_bytes;   // per workgroup
    uint32_t workgroup_invocations; // most invocations of one workgroup
    uint32_t workgroup_size_x;
    uint32_t workgroup_count_x; // most workgroups of one dispatch in x and in y
    uint32_t workgroup_count_y;
    uint32_t storage_buffers; // per stage
    uint32_t texel_buffers;   // sampled, per stage
    uint32_t storage_offset_alignment_bytes;
    uint32_t texel_offset_alignment_bytes;
    uint32_t push_offset_alignment_bytes;
    bool int64;         // 64-bit integers in shaders
    bool int64_atomics; // 64-bit integer atomics on storage buffers (implies int64)
    bool timestamps;    // the compute queue can write timestamps
    bool keeps_nan;     // shaders can demand that NaN, infinity and the sign of zero are kept
    bool unrolls_loops; // drivers are asked to unroll loops; not so with VIEWWORTH_LOOPS=kept, for slow compilers
    bool resubmits;     // commands that equal the last ones are submitted again, not written again
};

// The floor viewworth runs on: Vulkan 1.2 with the limits of the Roadmap 2022 profile and no optional feature; of
// storage buffers, as many as the passes of a run without effects declare.
extern const struct vw_gpu_limits vw_gpu_floor_limits;

enum vw_gpu_kind {
    VW_GPU_DISCRETE,
    VW_GPU_INTEGRATED,
    VW_GPU_VIRTUAL,
    VW_GPU_OTHER,
    VW_GPU_CPU
}; // in order of preference

// The properties, beside the device's name and driver, that decide the bits of a run: what a shader can demand of
// float32 arithmetic.
struct vw_gpu_arithmetic {
    bool keeps_nan; // and infinity and the sign of zero; the only one that viewworth demands
    bool keeps_denormals, flushes_denormals;
    bool rounds_to_even;
    bool int64_atomics; // else sums are split over two words of 32 bits, with equal bits
    uint32_t subgroup_size;
    uint32_t driver_version; // encoded as the driver likes
};

struct vw_gpu_info {
    uint32_t index; // as --device takes it: rank in order of preference, 0 first
    enum vw_gpu_kind kind;
    char name[256];   // Vulkan deviceName; for a CPU device followed by " on <CPU model>", since its code depends on it
    char driver[600]; // "<driverName> <driverInfo> <driverVersion>", and ", loops kept" without unrolls_loops
    uint64_t memory_bytes;               // size of its largest device-local heap
    struct vw_gpu_arithmetic arithmetic; // all 0 where it cannot be asked, before Vulkan 1.2
    char unsupported_reason[128];        // "" when it meets the floor, else the first limit that it misses
};

struct vw_gpu_params {
    const char *device; // NULL, "gpu", "cpu": the first fit one, of that kind; else its index or a part of its name
    bool validation;    // Khronos validation with synchronization validation; a missing layer is an error and
                        // any message of severity warning or error makes the next submit, wait or close fail
    bool timers;        // time every pass with timestamps, where the device has them
    const struct vw_gpu_limits
        *clamp; // NULL, or upper bounds on the queried limits (and feature bits) for tests of fallbacks
};

// Lists the Vulkan devices, most preferred first (discrete, integrated, virtual, other, CPU; then in driver order).
// `*infos` is owned by the caller (free). No device at all, or no loader, is VW_ERROR_NO_DEVICE.
enum vw_status vw_gpu_list(struct vw_gpu_info **infos, uint32_t *count);

// Opens a device. If LP_NATIVE_VECTOR_WIDTH is set and MESA_SHADER_CACHE_DIR is not, it sets the latter: lavapipe would
// otherwise read shaders from its cache that were compiled for another width.
enum vw_status vw_gpu_open(const struct vw_gpu_params *params, struct vw_gpu **gpu);
// Waits for the device. Returns VW_ERROR_DEVICE if validation complained since opening (the messages went to stderr).
enum vw_status vw_gpu_close(struct vw_gpu **gpu);
const struct vw_gpu_info *vw_gpu_get_info(const struct vw_gpu *gpu);
const struct vw_gpu_limits *vw_gpu_get_limits(const struct vw_gpu *gpu); // after clamping

VW_PUBLIC_END

#endif
