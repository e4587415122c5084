// The state of an open device and of its buffers, shared by the files of src/gpu. Each of them changes its own part.
#ifndef VIEWWORTH_GPU_STATE_H
#define VIEWWORTH_GPU_STATE_H

#include "gpu/compute.h"
#include "gpu/instance.h"
#include "viewworth/types.h"

// A physical device as listed.
struct vw_device_candidate {
    VkPhysicalDevice physical;
    uint32_t queue_family;
    struct vw_gpu_info info;
    struct vw_gpu_limits limits; // as queried
    uint32_t timestamp_bits;
    double timestamp_ns; // per tick
};

struct vw_gpu {
    struct vw_instance instance;
    VkDevice device;
    VkQueue queue;
    struct vw_device_candidate chosen; // with the limits clamped
    VkPhysicalDeviceMemoryProperties memory;
    bool timers_wanted;
    double wait_limit_s;
    bool hung;                  // see transfer.h
    struct vw_gpu *hung_before; // list of hung devices, which are never freed
    VkPipelineCache pipeline_cache;
    char pipeline_cache_name[64];               // name of its file in the cache folder
    uint8_t pipeline_cache_hash[VW_HASH_BYTES]; // hash of the file as it was read
    VkCommandPool transfer_pool;
    VkCommandBuffer transfer;          // for copies that the host waits for
    VkFence transfer_fence;            // signalled when they are done
    struct vw_buffer *staging;         // made at the first such copy
    VkDescriptorSetLayout push_layout; // layout of the set of push blocks
    uint64_t buffer_bytes;             // sum over all live buffers
    uint64_t destroyed;                // how many passes and buffers were: another may have their address
    uint64_t stage;                    // the newest one given out
    struct vw_pipeline *pipelines;     // owned; a list (pipeline.h)
    double pipeline_s;                 // seconds that the driver compiled them
    struct vw_submission *recording;   // one submission records at a time, so that recording order is submission order
    struct vw_submission *newest;      // the last one submitted; NULL: none, or it is gone
    struct vw_submission_counts submission_counts;
    struct vw_gpu_timer *timers;
    size_t timer_count;
    size_t timer_capacity;
};

// Creates and destroys what the push blocks of all submissions share, gpu->push_layout (submission.c).
enum vw_status vw_pushes_open(struct vw_gpu *gpu);
void vw_pushes_close(struct vw_gpu *gpu);

// ---- Buffers -------------------------------------------------------------------------------------------------------

// Buffers remember, by the ranges that are bound or copied, the last stages that read and wrote them (command_list.h).
struct vw_range {
    uint64_t offset_bytes, size_bytes;
    uint64_t read_stage, write_stage; // the last ones; 0: never
};

struct vw_ranges {
    struct vw_range *list; // owned
    size_t count, capacity;
};

struct vw_buffer {
    struct vw_gpu *gpu;
    char *name;
    uint64_t size_bytes;
    VkBuffer handle;
    VkDeviceMemory memory;
    void *mapped;            // NULL for VW_BUFFER_DEVICE
    struct vw_ranges ranges; // that passes and copies have used
};

enum vw_status vw_buffer_check_range(const struct vw_buffer *buffer, uint64_t offset_bytes, uint64_t size_bytes);

// Finds the index of a range, which is added when it is new. VW_ERROR_MEMORY.
enum vw_status vw_ranges_find(struct vw_ranges *ranges, uint64_t offset_bytes, uint64_t size_bytes, uint32_t *index);
// Returns the earliest stage in which the range may be read or written: after every overlapping write, and, if it is
// written, after every read of it. 0: any.
uint64_t vw_ranges_earliest(const struct vw_ranges *ranges, uint32_t index, bool writes);
void vw_ranges_note(struct vw_ranges *ranges, uint32_t index, bool writes, uint64_t stage);

// ---- Choosing a device ----

// Returns the index of the queue family to compute on: the first without graphics that has timestamps, otherwise the
// first that computes; -1 without any.
int vw_queue_family_choose(const VkQueueFamilyProperties *families, uint32_t count);

#endif
