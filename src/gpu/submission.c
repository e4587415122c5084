#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/command_list.h"
#include "gpu/instance.h"
#include "gpu/state.h"
#include "gpu/transfer.h"

// ---- Push blocks ---------------------------------------------------------------------------------------------------

// The values that PUSH of shaders/common.glsl declares, one block for each dispatch. They are in a buffer that the
// submission owns and its commands bind, so that other values need no other commands.
struct pushes {
    struct vw_buffer *buffer; // owned; NULL: nothing was pushed yet
    VkDescriptorPool pool;
    VkDescriptorSet set;
};

enum { BUFFER_BYTES_LEAST = 256 }; // it doubles, since another buffer voids what all submissions have recorded

enum vw_status vw_pushes_open(struct vw_gpu *gpu) {
    const VkDescriptorSetLayoutBinding block = {.descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                                .descriptorCount = 1,
                                                .stageFlags = VK_SHADER_STAGE_COMPUTE_BIT};
    const VkDescriptorSetLayoutCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &block};
    VkResult result = vkCreateDescriptorSetLayout(gpu->device, &info, NULL, &gpu->push_layout);
    return result ? vw_gpu_fail(result, "vkCreateDescriptorSetLayout", "push blocks") : VW_OK;
}

void vw_pushes_close(struct vw_gpu *gpu) { vkDestroyDescriptorSetLayout(gpu->device, gpu->push_layout, NULL); }

static enum vw_status create_pushes(struct vw_gpu *gpu, struct pushes *pushes) {
    const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = 1,
                                             .poolSizeCount = 1,
                                             .pPoolSizes =
                                                 &(VkDescriptorPoolSize){VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, 1}};
    VkResult result = vkCreateDescriptorPool(gpu->device, &pool, NULL, &pushes->pool);
    if (result) return vw_gpu_fail(result, "vkCreateDescriptorPool", "push blocks");
    const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = pushes->pool,
                                             .descriptorSetCount = 1,
                                             .pSetLayouts = &gpu->push_layout};
    result = vkAllocateDescriptorSets(gpu->device, &set, &pushes->set);
    return result ? vw_gpu_fail(result, "vkAllocateDescriptorSets", "push blocks") : VW_OK;
}

// Makes room: whatever block a dispatch binds, its range is as long as the largest one.
static enum vw_status reserve_pushes(struct vw_gpu *gpu, struct pushes *pushes, size_t size_bytes) {
    struct vw_buffer_params params = {
        .name = "push blocks", .size_bytes = BUFFER_BYTES_LEAST, .memory = VW_BUFFER_SHARED};
    while (params.size_bytes < size_bytes + VW_PUSH_BYTES_MAX) params.size_bytes *= 2;
    if (pushes->buffer && vw_buffer_size_bytes(pushes->buffer) >= params.size_bytes) return VW_OK;
    vw_buffer_destroy(&pushes->buffer);
    enum vw_status status = vw_buffer_create(gpu, &params, &pushes->buffer);
    if (status) return status;
    const VkDescriptorBufferInfo range = {pushes->buffer->handle, 0, VW_PUSH_BYTES_MAX};
    const VkWriteDescriptorSet write = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = pushes->set,
                                        .descriptorCount = 1,
                                        .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                        .pBufferInfo = &range};
    vkUpdateDescriptorSets(gpu->device, 1, &write, 0, NULL);
    return VW_OK;
}

// Copies the blocks to where the device reads them, which no submission in flight may do. When they need another
// buffer, the one before is destroyed, so that gpu->destroyed says that commands which bind it are void.
static enum vw_status write_pushes(struct vw_gpu *gpu, struct pushes *pushes, const void *blocks, size_t size_bytes) {
    if (!size_bytes) return VW_OK;
    enum vw_status status = reserve_pushes(gpu, pushes, size_bytes);
    if (!status) memcpy(vw_buffer_map(pushes->buffer), blocks, size_bytes);
    return status;
}

// ---- The submission ------------------------------------------------------------------------------------------------

struct vw_submission {
    struct vw_gpu *gpu;
    VkCommandPool pool;
    VkCommandBuffer commands;
    VkFence fence;
    struct vw_submission_timer timer;
    bool in_flight;
    struct vw_command_list list;
    struct pushes pushes;
    bool recorded;      // `commands` are those that the list wrote last
    uint64_t destroyed; // that of the device when they were recorded
    uint64_t recordings;
    enum vw_status status; // the first failure of this recording
    char message[512];
};

uint32_t vw_submission_commands(const struct vw_submission *submission) { return (uint32_t)submission->list.count; }

uint64_t vw_submission_recordings(const struct vw_submission *submission) { return submission->recordings; }

const struct vw_command_list *vw_submission_list(const struct vw_submission *submission) { return &submission->list; }

// ---- Recording ------------------------------------------------------------------------------------------------------

// Keeps a failure just recorded with vw_fail() for vw_submission_submit(); VW_OK leaves the submission as it is.
static void keep_failure(struct vw_submission *submission, enum vw_status status) {
    if (!status) return;
    submission->status = status;
    snprintf(submission->message, sizeof submission->message, "%s", vw_error_message());
}

// Returns false once something failed; all later commands are then skipped.
static bool can_record(struct vw_submission *submission) {
    if (!submission->status && submission->gpu->recording != submission)
        keep_failure(
            submission,
            vw_fail(VW_ERROR_DEVICE,
                    "only one submission can record at a time, between vw_submission_begin and vw_submission_submit"));
    return !submission->status;
}

static enum vw_status begin(struct vw_submission *submission) {
    struct vw_gpu *gpu = submission->gpu;
    enum vw_status status = vw_wait_check(gpu, "an earlier submission");
    if (status) return status;
    if (submission->in_flight)
        return vw_fail(VW_ERROR_DEVICE, "the submission is still in flight; call vw_submission_wait first");
    if (!gpu->recording) gpu->recording = submission;
    if (!can_record(submission)) return submission->status;

    vw_command_list_begin(&submission->list, ++gpu->stage, submission->timer.queries != VK_NULL_HANDLE);
    return VW_OK;
}

void vw_submission_begin(struct vw_submission *submission) {
    submission->status = VW_OK;
    keep_failure(submission, begin(submission));
}

// Chooses as few rows as the device allows, of even length.
static enum vw_status split_into_rows(const struct vw_pass *pass, uint64_t invocations, struct vw_workgroups *groups) {
    const struct vw_gpu_limits *limits = &pass->gpu->chosen.limits;
    uint64_t count = invocations / pass->workgroup_invocations + (invocations % pass->workgroup_invocations != 0);
    uint64_t rows = (count + limits->workgroup_count_x - 1) / limits->workgroup_count_x;
    uint64_t row = rows ? (count + rows - 1) / rows : 0;
    if (count > UINT32_MAX || rows > limits->workgroup_count_y || rows * row * pass->workgroup_invocations > UINT32_MAX)
        return vw_fail(VW_ERROR_DEVICE, "pass %s: %llu invocations are too many for one dispatch", pass->name,
                       (unsigned long long)invocations);
    *groups = (struct vw_workgroups){.x = (uint32_t)row, .y = (uint32_t)rows};
    return VW_OK;
}

static enum vw_status dispatch(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                               size_t push_bytes, struct vw_workgroups groups) {
    if (push_bytes != pass->push_bytes)
        return vw_fail(VW_ERROR_DEVICE, "pass %s: %zu bytes pushed, the shader has %u", pass->name, push_bytes,
                       pass->push_bytes);
    return vw_command_list_add_dispatch(&submission->list, pass, push, groups);
}

void vw_submission_dispatch(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                            size_t push_bytes, uint64_t invocations) {
    if (!can_record(submission)) return;
    struct vw_workgroups groups;
    enum vw_status status = split_into_rows(pass, invocations, &groups);
    if (!status && groups.x) status = dispatch(submission, pass, push, push_bytes, groups);
    keep_failure(submission, status);
}

void vw_submission_dispatch_rows(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                                 size_t push_bytes, uint64_t invocations, uint32_t rows) {
    if (!can_record(submission)) return;
    struct vw_workgroups groups;
    enum vw_status status = split_into_rows(pass, invocations, &groups);
    if (!status && (groups.y > 1 || rows > pass->gpu->chosen.limits.workgroup_count_y))
        status = vw_fail(VW_ERROR_DEVICE, "pass %s: %u rows of %llu invocations are too many for one dispatch",
                         pass->name, rows, (unsigned long long)invocations);
    groups.y = rows;
    if (!status && groups.x && rows) status = dispatch(submission, pass, push, push_bytes, groups);
    keep_failure(submission, status);
}

void vw_submission_dispatch_indirect(struct vw_submission *submission, const struct vw_pass *pass, const void *push,
                                     size_t push_bytes, struct vw_buffer *groups, uint64_t offset_bytes) {
    if (!can_record(submission)) return;
    enum vw_status status = vw_buffer_check_range(groups, offset_bytes, sizeof(VkDispatchIndirectCommand));
    if (!status && offset_bytes % 4)
        status =
            vw_fail(VW_ERROR_DEVICE, "pass %s: workgroups are listed at byte %llu of %s, which is not a multiple of 4",
                    pass->name, (unsigned long long)offset_bytes, groups->name);
    if (!status)
        status = dispatch(submission, pass, push, push_bytes,
                          (struct vw_workgroups){.listed = groups, .offset_bytes = offset_bytes});
    keep_failure(submission, status);
}

static enum vw_status copy(struct vw_submission *submission, struct vw_buffer *from, struct vw_buffer *to,
                           VkBufferCopy region) {
    enum vw_status status = vw_buffer_check_range(from, region.srcOffset, region.size);
    if (!status) status = vw_buffer_check_range(to, region.dstOffset, region.size);
    return status || !region.size ? status : vw_command_list_add_copy(&submission->list, from, to, region);
}

void vw_submission_copy(struct vw_submission *submission, struct vw_buffer *from, uint64_t from_offset_bytes,
                        struct vw_buffer *to, uint64_t to_offset_bytes, uint64_t size_bytes) {
    if (can_record(submission))
        keep_failure(submission,
                     copy(submission, from, to, (VkBufferCopy){from_offset_bytes, to_offset_bytes, size_bytes}));
}

// ---- Submitting -----------------------------------------------------------------------------------------------------

// Returns whether the commands recorded last do what the list says. What is destroyed may be replaced by something else
// at the same address. Times are asked for anew each time.
static bool is_recorded(const struct vw_submission *submission) {
    const struct vw_gpu *gpu = submission->gpu;
    return submission->recorded && gpu->chosen.limits.resubmits && !submission->timer.queries &&
           submission->destroyed == gpu->destroyed && vw_command_list_is_written(&submission->list);
}

static enum vw_status record(struct vw_submission *submission) {
    struct vw_gpu *gpu = submission->gpu;
    submission->recorded = false;
    VkResult result = vkResetCommandPool(gpu->device, submission->pool, 0);
    if (result) return vw_gpu_fail(result, "vkResetCommandPool", "submission");
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    result = vkBeginCommandBuffer(submission->commands, &info);
    if (result) return vw_gpu_fail(result, "vkBeginCommandBuffer", "submission");
    vw_submission_timer_reset(gpu, &submission->timer);
    vw_command_list_write(&submission->list, submission->commands, submission->pushes.set, &submission->timer);
    result = vkEndCommandBuffer(submission->commands);
    if (result) return vw_gpu_fail(result, "vkEndCommandBuffer", "submission");
    submission->recorded = true;
    submission->destroyed = gpu->destroyed;
    submission->recordings++;
    return vw_instance_check(&gpu->instance);
}

struct vw_submission_counts vw_gpu_submission_counts(const struct vw_gpu *gpu) {
    return gpu->submission_counts;
}

// Returns whether the device has done all that was submitted: submissions end in order. It is counted and nothing else.
static bool device_waits(const struct vw_gpu *gpu) {
    const struct vw_submission *newest = gpu->newest;
    return !newest || !newest->in_flight || vkGetFenceStatus(gpu->device, newest->fence) == VK_SUCCESS;
}

static enum vw_status submit(struct vw_submission *submission) {
    struct vw_gpu *gpu = submission->gpu;
    VkResult result = vkResetFences(gpu->device, 1, &submission->fence);
    if (result) return vw_gpu_fail(result, "vkResetFences", "submission");
    const VkSubmitInfo info = {
        .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &submission->commands};
    bool host_bound = device_waits(gpu);
    result = vkQueueSubmit(gpu->queue, 1, &info, submission->fence);
    if (result) return vw_gpu_fail(result, "vkQueueSubmit", "submission");
    submission->in_flight = true;
    gpu->newest = submission;
    gpu->submission_counts.submitted++;
    gpu->submission_counts.host_bound += host_bound;
    return vw_instance_check(&gpu->instance);
}

enum vw_status vw_submission_submit(struct vw_submission *submission) {
    bool good = can_record(submission);
    if (submission->gpu->recording == submission) {
        submission->gpu->recording = NULL;
        submission->gpu->stage = submission->list.last_stage;
    }
    if (!good) return vw_fail(submission->status, "%s", submission->message);
    const struct vw_command_list *list = &submission->list;
    enum vw_status status = write_pushes(submission->gpu, &submission->pushes, list->pushes, list->push_bytes);
    if (!status && !is_recorded(submission)) status = record(submission);
    return status ? status : submit(submission);
}

enum vw_status vw_submission_wait(struct vw_submission *submission) {
    if (!submission->in_flight) return VW_OK;
    char work[64];
    snprintf(work, sizeof work, "a submission of %" PRIu32 " commands", vw_submission_commands(submission));
    enum vw_status status = vw_wait_for_fence(submission->gpu, submission->fence, work);
    submission->in_flight = false;
    if (!status) status = vw_submission_timer_collect(submission->gpu, &submission->timer);
    return status ? status : vw_instance_check(&submission->gpu->instance);
}

// ---- Life -----------------------------------------------------------------------------------------------------------

static enum vw_status create_commands(struct vw_submission *submission) {
    VkDevice device = submission->gpu->device;
    const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                          .queueFamilyIndex = submission->gpu->chosen.queue_family};
    VkResult result = vkCreateCommandPool(device, &pool, NULL, &submission->pool);
    if (result) return vw_gpu_fail(result, "vkCreateCommandPool", "submission");
    const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                  .commandPool = submission->pool,
                                                  .commandBufferCount = 1};
    result = vkAllocateCommandBuffers(device, &commands, &submission->commands);
    if (result) return vw_gpu_fail(result, "vkAllocateCommandBuffers", "submission");
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    result = vkCreateFence(device, &fence, NULL, &submission->fence);
    return result ? vw_gpu_fail(result, "vkCreateFence", "submission") : VW_OK;
}

enum vw_status vw_submission_create(struct vw_gpu *gpu, struct vw_submission **submission) {
    struct vw_submission *made = vw_allocate(1, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    made->gpu = gpu;
    enum vw_status status = create_commands(made);
    if (!status) status = create_pushes(gpu, &made->pushes);
    if (!status) status = vw_submission_timer_create(gpu, &made->timer);
    if (status) {
        vw_submission_destroy(&made);
        return status;
    }
    *submission = made;
    return VW_OK;
}

void vw_submission_destroy(struct vw_submission **submission) {
    struct vw_submission *dying = *submission;
    if (!dying) return;
    if (!dying->gpu->hung) vw_submission_wait(dying);
    if (dying->gpu->recording == dying) dying->gpu->recording = NULL;
    if (dying->gpu->newest == dying) dying->gpu->newest = NULL;
    if (!dying->gpu->hung) { // by now
        vkDestroyFence(dying->gpu->device, dying->fence, NULL);
        vkDestroyCommandPool(dying->gpu->device, dying->pool, NULL); // frees its command buffer
        vw_submission_timer_destroy(dying->gpu, &dying->timer);
        vkDestroyDescriptorPool(dying->gpu->device, dying->pushes.pool, NULL);
    }
    vw_buffer_destroy(&dying->pushes.buffer);
    vw_command_list_free(&dying->list);
    free(dying);
    *submission = NULL;
}
