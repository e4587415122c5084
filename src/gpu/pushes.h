// The push blocks of a submission: the values that PUSH of shaders/common.glsl declares, one block for each dispatch.
// They are in a buffer that the submission owns and its commands bind, so that other values need no other commands.
#ifndef VIEWWORTH_GPU_PUSHES_H
#define VIEWWORTH_GPU_PUSHES_H

#include "gpu/state.h"

struct vw_pushes {
    struct vw_buffer *buffer; // owned; NULL: nothing was pushed yet
    VkDescriptorPool pool;
    VkDescriptorSet set;
};

// Creates and destroys what the submissions of a device share: gpu->push_layout.
enum vw_status vw_pushes_open(struct vw_gpu *gpu);
void vw_pushes_close(struct vw_gpu *gpu);

enum vw_status vw_pushes_create(struct vw_gpu *gpu, struct vw_pushes *pushes);
void vw_pushes_destroy(struct vw_gpu *gpu, struct vw_pushes *pushes);
// Copies the blocks to where the device reads them, which no submission in flight may do. When they need another
// buffer, the one before is destroyed, so that gpu->destroyed says that commands which bind it are void.
enum vw_status vw_pushes_write(struct vw_gpu *gpu, struct vw_pushes *pushes, const void *blocks, size_t size_bytes);

#endif
