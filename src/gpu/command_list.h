// The commands of a submission, kept until it is submitted. A *stage* is the work between two full barriers. A command
// belongs into the earliest stage that the ranges of its buffers allow, also before commands that were recorded
// earlier. All work runs on one queue, where any barrier drains the device in practice, so a full barrier between
// stages serves every buffer at once.
#ifndef VIEWWORTH_GPU_COMMAND_LIST_H
#define VIEWWORTH_GPU_COMMAND_LIST_H

#include "gpu/pass.h"
#include "gpu/timer.h"

// The number of workgroups of a dispatch: x and y, or the content of a buffer when it starts.
struct vw_workgroups {
    uint32_t x, y;
    struct vw_buffer *listed; // NULL: as above
    uint64_t offset_bytes;
};

struct vw_copy {
    struct vw_buffer *from, *to;
    VkBufferCopy region;
};

struct vw_command {
    const struct vw_pass *pass; // NULL: a copy
    uint32_t stage;             // from the first of its list on
    uint32_t next;              // the stage's next command in the order of recording; VW_NO_COMMAND: none
    uint32_t push_offset_bytes; // place of its push block
    union {
        struct vw_workgroups groups;
        struct vw_copy copy;
    };
};

enum { VW_NO_COMMAND = UINT32_MAX };

struct vw_stage {
    uint32_t first, last; // commands; VW_NO_COMMAND: it has none
    bool indirect;        // one of them reads its number of workgroups
};

struct vw_command_list {
    struct vw_command *commands; // owned, as pushes and stages
    uint8_t *pushes;
    struct vw_stage *stages; // from first_stage on
    size_t count, capacity, push_bytes, push_capacity, stage_count, stage_capacity;
    size_t written_count; // commands that were written last; they are still there unless `differs`
    bool differs;         // one was replaced since by another one
    uint64_t first_stage, last_stage;
    bool one_by_one; // every command has a stage of its own, so that times of passes do not overlap
};

// Empties the list; its commands run in stages from `first_stage` on.
void vw_command_list_begin(struct vw_command_list *list, uint64_t first_stage, bool one_by_one);
void vw_command_list_free(struct vw_command_list *list);

// Adds a dispatch; its push block `push` has as many bytes as the pass says. VW_ERROR_MEMORY.
enum vw_status vw_command_list_add_dispatch(struct vw_command_list *list, const struct vw_pass *pass, const void *push,
                                            struct vw_workgroups groups);
enum vw_status vw_command_list_add_copy(struct vw_command_list *list, struct vw_buffer *from, struct vw_buffer *to,
                                        VkBufferCopy region);
uint32_t vw_command_list_barriers(const struct vw_command_list *list);
// Returns whether the list has the same commands as when it was written last, apart from what is pushed.
bool vw_command_list_is_written(const struct vw_command_list *list);
// Writes all commands, stage by stage, with barriers between, and one after the last for the host. `pushes` is the set
// of their push blocks.
void vw_command_list_write(struct vw_command_list *list, VkCommandBuffer commands, VkDescriptorSet pushes,
                           struct vw_submission_timer *timer);

uint32_t vw_submission_commands(const struct vw_submission *submission);
// Returns the commands that the submission recorded, in this order.
const struct vw_command_list *vw_submission_list(const struct vw_submission *submission);
// Returns how often commands were written for the device; in between they were submitted again.
uint64_t vw_submission_recordings(const struct vw_submission *submission);

#endif
