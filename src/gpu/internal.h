// What the files of src/gpu share. Nothing outside this folder includes it.
#ifndef VIEWWORTH_GPU_INTERNAL_H
#define VIEWWORTH_GPU_INTERNAL_H

#include <stdatomic.h>
#include <volk.h>

#include "gpu/hazard.h"
#include "gpu/result.h"
#include "gpu/compute.h"
#include "viewworth/gpu.h"

// ---- The device
// ------------------------------------------------------------------------------------------------------

// An instance with its validation; `complaints` counts the messages of the validation layer.
struct vw_instance {
    VkInstance handle;
    VkDebugUtilsMessengerEXT messenger;
    bool debug_utils; // object names and labels can be set
    atomic_uint complaints;
};

// `instance` must stay where it is until vw_instance_close(), which accepts a half-open or zeroed one.
enum vw_status vw_instance_open(struct vw_instance *instance, bool validation);
void vw_instance_close(struct vw_instance *instance);

// A physical device as listed.
struct vw_candidate {
    VkPhysicalDevice physical;
    uint32_t queue_family;
    struct vw_gpu_info info;
    struct vw_gpu_limits limits; // as queried
    uint32_t timestamp_bits;
    double timestamp_ns; // per tick
};

// Fills in everything but info.index.
void vw_candidate_query(VkPhysicalDevice physical, struct vw_candidate *candidate);

void vw_limits_clamp(struct vw_gpu_limits *limits, const struct vw_gpu_limits *clamp);
// The name of the first limit that is below the floor, NULL when none is.
const char *vw_limits_missed(const struct vw_gpu_limits *limits);

struct vw_gpu {
    struct vw_instance instance;
    VkDevice device;
    VkQueue queue;
    struct vw_candidate chosen; // with the limits clamped
    VkPhysicalDeviceMemoryProperties memory;
    bool timers_wanted;
    VkPipelineCache pipeline_cache;
    char *pipeline_cache_path;       // owned; NULL: not kept
    uint8_t pipeline_cache_hash[32]; // of the file as it was read
    VkCommandPool transfer_pool;
    VkCommandBuffer transfer;   // for copies that the host waits for
    struct vw_buffer *staging;  // made at the first such copy
    uint64_t buffer_bytes;      // of all live buffers
    uint64_t epoch;             // the newest one given out
    struct vw_batch *recording; // one batch records at a time, so that recording order is submission order
    struct vw_gpu_timer *timers;
    size_t timer_count;
    size_t timer_capacity;
};

// VW_OK, or VW_ERROR_DEVICE once validation has complained.
enum vw_status vw_gpu_check_validation(struct vw_gpu *gpu);
void vw_gpu_set_name(struct vw_gpu *gpu, VkObjectType type, uint64_t handle, const char *name);
// Ends every command buffer, so that none has to know what those before it did, and the host may read what it wrote.
void vw_end_barrier(VkCommandBuffer commands);

// ---- Objects
// -----------------------------------------------------------------------------------------------------------

struct vw_buffer {
    struct vw_gpu *gpu;
    char *name;
    uint64_t size_bytes;
    VkBuffer handle;
    VkDeviceMemory memory;
    void *mapped; // NULL for VW_BUFFER_DEVICE
    struct vw_last_access last;
};

enum vw_status vw_buffer_check_range(const struct vw_buffer *buffer, uint64_t offset_bytes, uint64_t size_bytes);

struct vw_pass_slot {
    struct vw_buffer *buffer;
    bool writes;       // else it only reads
    VkBufferView view; // of a texel buffer
};

struct vw_pass {
    struct vw_gpu *gpu;
    const char *name, *role;
    VkDescriptorSetLayout set_layout;
    VkDescriptorPool pool;
    VkDescriptorSet set;
    VkPipelineLayout layout;
    VkPipeline pipeline;
    uint32_t push_bytes;
    uint32_t workgroup_invocations;
    struct vw_pass_slot *slots;
    uint32_t slot_count;
};

// By its static texts, since the pass may be gone when its times are collected.
struct vw_timed_pass {
    const char *name, *role;
};

// Timestamps of one batch: two queries around each dispatch, as many as fit.
struct vw_batch_timer {
    VkQueryPool queries;              // VK_NULL_HANDLE: not timed
    struct vw_timed_pass *dispatches; // those that are timed
    uint32_t count;
};

struct vw_batch {
    struct vw_gpu *gpu;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    struct vw_batch_timer timer;
    bool in_flight;
    uint64_t epoch;
    uint32_t barrier_count;
    enum vw_status status; // the first failure of this recording
    char message[512];
};

enum vw_status vw_batch_timer_create(struct vw_gpu *gpu, struct vw_batch_timer *timer);
void vw_batch_timer_destroy(struct vw_gpu *gpu, struct vw_batch_timer *timer);
void vw_batch_timer_reset(struct vw_gpu *gpu, struct vw_batch_timer *timer);
// Returns whether the dispatch is timed, that is, whether _stop must follow.
bool vw_batch_timer_start(struct vw_batch_timer *timer, VkCommandBuffer commands, const struct vw_pass *pass);
void vw_batch_timer_stop(struct vw_batch_timer *timer, VkCommandBuffer commands);
// Adds the times of a finished batch to the device's timers.
enum vw_status vw_batch_timer_collect(struct vw_gpu *gpu, struct vw_batch_timer *timer);

#endif
