#include "gpu/command_list.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/state.h"
#include "gpu/transfer.h"

void vw_command_list_begin(struct vw_command_list *list, uint64_t first_stage, bool one_by_one) {
    list->count = list->push_bytes = list->stage_count = 0;
    list->first_stage = list->last_stage = first_stage;
    list->one_by_one = one_by_one;
}

void vw_command_list_free(struct vw_command_list *list) {
    free(list->commands);
    free(list->pushes);
    free(list->stages);
    *list = (struct vw_command_list){0};
}

// ---- Placing --------------------------------------------------------------------------------------------------------

// The part of a buffer that a command reads or writes.
struct access {
    struct vw_buffer *buffer;
    uint32_t range;
    bool writes;
};

static uint64_t later(uint64_t a, uint64_t b) { return a > b ? a : b; }

static uint64_t earliest(const struct vw_command_list *list, uint64_t so_far, struct access access) {
    uint64_t allowed = vw_ranges_earliest(&access.buffer->ranges, access.range, access.writes);
    return later(list->first_stage, later(so_far, allowed));
}

// Makes room for the stages up to one.
static enum vw_status grow_stages(struct vw_command_list *list, uint64_t count) {
    enum vw_status status = vw_grow((void **)&list->stages, &list->stage_capacity, count, sizeof *list->stages);
    for (; !status && list->stage_count < count; list->stage_count++)
        list->stages[list->stage_count] = (struct vw_stage){VW_NO_COMMAND, VW_NO_COMMAND, false};
    return status;
}

static bool is_equal(const struct vw_command *a, const struct vw_command *b) {
    if (a->pass != b->pass || a->stage != b->stage) return false;
    return a->pass ? !memcmp(&a->groups, &b->groups, sizeof a->groups) : !memcmp(&a->copy, &b->copy, sizeof a->copy);
}

// Adds a command. Lists are often equal to the one before, so it is compared with what it replaces.
static enum vw_status append(struct vw_command_list *list, struct vw_command command) {
    enum vw_status status = vw_grow((void **)&list->commands, &list->capacity, list->count + 1, sizeof *list->commands);
    if (!status) status = grow_stages(list, command.stage + 1);
    if (status) return status;
    struct vw_stage *stage = &list->stages[command.stage];
    uint32_t number = (uint32_t)list->count++;
    if (stage->last == VW_NO_COMMAND) stage->first = number;
    else list->commands[stage->last].next = number;
    stage->last = number;
    stage->indirect |= command.pass && command.groups.listed;
    command.next = VW_NO_COMMAND;
    list->last_stage = later(list->last_stage, list->first_stage + command.stage);
    list->differs |= number >= list->written_count || !is_equal(&list->commands[number], &command);
    list->commands[number] = command;
    return VW_OK;
}

static uint64_t own_stage(const struct vw_command_list *list) { return list->last_stage + (list->count > 0); }

enum vw_status vw_command_list_add_dispatch(struct vw_command_list *list, const struct vw_pass *pass, const void *push,
                                            struct vw_workgroups groups) {
    struct vw_command command = {.pass = pass, .groups = groups, .push_offset_bytes = (uint32_t)list->push_bytes};
    struct access counts = {.buffer = groups.listed};
    uint32_t alignment_bytes = pass->gpu->chosen.limits.push_offset_alignment_bytes;
    size_t push_bytes = (size_t)(pass->push_bytes + alignment_bytes - 1) / alignment_bytes * alignment_bytes;
    enum vw_status status = vw_grow((void **)&list->pushes, &list->push_capacity, list->push_bytes + push_bytes, 1);
    if (!status && groups.listed)
        status = vw_ranges_find(&groups.listed->ranges, groups.offset_bytes, sizeof(VkDispatchIndirectCommand),
                                &counts.range);
    if (status) return status;
    if (pass->push_bytes) memcpy(list->pushes + list->push_bytes, push, pass->push_bytes);
    list->push_bytes += push_bytes;

    uint64_t stage = list->one_by_one ? own_stage(list) : list->first_stage;
    if (groups.listed) stage = earliest(list, stage, counts);
    for (uint32_t i = 0; i < pass->slot_count; i++)
        stage =
            earliest(list, stage, (struct access){pass->slots[i].buffer, pass->slots[i].range, pass->slots[i].writes});
    for (uint32_t i = 0; i < pass->slot_count; i++)
        vw_ranges_note(&pass->slots[i].buffer->ranges, pass->slots[i].range, pass->slots[i].writes, stage);
    if (groups.listed) vw_ranges_note(&groups.listed->ranges, counts.range, false, stage);
    command.stage = (uint32_t)(stage - list->first_stage);
    return append(list, command);
}

enum vw_status vw_command_list_add_copy(struct vw_command_list *list, struct vw_buffer *from, struct vw_buffer *to,
                                        VkBufferCopy region) {
    struct access read = {.buffer = from}, write = {.buffer = to, .writes = true};
    enum vw_status status = vw_ranges_find(&from->ranges, region.srcOffset, region.size, &read.range);
    if (!status) status = vw_ranges_find(&to->ranges, region.dstOffset, region.size, &write.range);
    if (status) return status;
    uint64_t stage = list->one_by_one ? own_stage(list) : list->first_stage;
    stage = earliest(list, earliest(list, stage, read), write);
    vw_ranges_note(&from->ranges, read.range, false, stage);
    vw_ranges_note(&to->ranges, write.range, true, stage);
    return append(list,
                  (struct vw_command){.stage = (uint32_t)(stage - list->first_stage), .copy = {from, to, region}});
}

uint32_t vw_command_list_barriers(const struct vw_command_list *list) {
    return list->stage_count ? (uint32_t)list->stage_count - 1 : 0;
}

// ---- Comparing ------------------------------------------------------------------------------------------------------

bool vw_command_list_is_written(const struct vw_command_list *list) {
    return !list->differs && list->count == list->written_count;
}

// ---- Writing --------------------------------------------------------------------------------------------------------

// Binds the buffers of the pass and its push block, where it has any.
static void bind_sets(const struct vw_command *command, VkDescriptorSet pushes, VkCommandBuffer commands) {
    const struct vw_pass *pass = command->pass;
    const VkDescriptorSet sets[] = {pass->set, [VW_PUSH_SET] = pushes};
    uint32_t first = pass->slot_count ? 0 : VW_PUSH_SET, end = pass->push_bytes ? VW_PUSH_SET + 1 : VW_PUSH_SET;
    if (first < end)
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass->pipeline->layout, first, end - first,
                                sets + first, pass->push_bytes ? 1 : 0, &command->push_offset_bytes);
}

static void write_dispatch(const struct vw_command *command, VkDescriptorSet pushes, VkCommandBuffer commands,
                           struct vw_submission_timer *timer) {
    const struct vw_pass *pass = command->pass;
    const VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = pass->name};
    bool labelled = pass->gpu->instance.debug_utils;
    if (labelled) vkCmdBeginDebugUtilsLabelEXT(commands, &label);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pass->pipeline->handle);
    bind_sets(command, pushes, commands);
    bool timed = vw_submission_timer_start(timer, commands, pass);
    const struct vw_workgroups *groups = &command->groups;
    if (groups->listed) vkCmdDispatchIndirect(commands, groups->listed->handle, groups->offset_bytes);
    else vkCmdDispatch(commands, groups->x, groups->y, 1);
    if (timed) vw_submission_timer_stop(timer, commands);
    if (labelled) vkCmdEndDebugUtilsLabelEXT(commands);
}

static void write_command(const struct vw_command *command, VkDescriptorSet pushes, VkCommandBuffer commands,
                          struct vw_submission_timer *timer) {
    const struct vw_copy *copy = &command->copy;
    if (command->pass) write_dispatch(command, pushes, commands, timer);
    else vkCmdCopyBuffer(commands, copy->from->handle, copy->to->handle, 1, &copy->region);
}

void vw_command_list_write(struct vw_command_list *list, VkCommandBuffer commands, VkDescriptorSet pushes,
                           struct vw_submission_timer *timer) {
    bool indirect_before = false;
    for (size_t s = 0; s < list->stage_count; s++) {
        const struct vw_stage *stage = &list->stages[s];
        if (s > 0)
            vw_barrier_record(commands, (struct vw_barrier_params){.indirect = stage->indirect || indirect_before});
        for (uint32_t i = stage->first; i != VW_NO_COMMAND; i = list->commands[i].next)
            write_command(&list->commands[i], pushes, commands, timer);
        indirect_before = stage->indirect;
    }
    vw_barrier_record(commands, (struct vw_barrier_params){.indirect = true, .host_reads = true});
    list->written_count = list->count;
    list->differs = false;
}
