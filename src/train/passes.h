// Buffers and passes that are created from lists and destroyed together.
#ifndef VIEWWORTH_TRAIN_PASSES_H
#define VIEWWORTH_TRAIN_PASSES_H

#include "gpu/compute.h"
#include "interface.h"

// Buffers and passes that are destroyed together: those of a field, a step, an evaluator. Whoever uses one keeps a
// pointer to it, which is NULL where it was left out.
struct vw_gpu_objects {
    struct vw_gpu *gpu;         // borrowed
    struct vw_buffer **buffers; // owned, and so are the passes
    struct vw_pass **passes;
    size_t buffer_count, buffer_capacity, pass_count, pass_capacity;
};
void vw_gpu_objects_destroy(struct vw_gpu_objects *objects);

struct vw_buffer_row {
    struct vw_buffer **buffer;
    const char *name;
    uint64_t size_bytes;
};
// Creates all buffers of the list, in its order, up to the first failure. Leaves out those of 0 bytes.
enum vw_status vw_buffers_create(struct vw_gpu_objects *objects, enum vw_buffer_memory memory,
                                 const struct vw_buffer_row *rows, size_t count);

struct vw_pass_row {
    const struct vw_shader *shader;
    struct vw_pass **pass;
};
// Returns params without a shader. All three are borrowed.
struct vw_pass_params vw_pass_params_of(const struct vw_specialization *specialization,
                                        const struct vw_binding *bindings, uint32_t count, const char *role);
// Creates one pass with the params' specialization, bindings and role.
enum vw_status vw_pass_create_of(struct vw_gpu_objects *objects, const struct vw_pass_params *common,
                                 const struct vw_shader *shader, struct vw_pass **pass);
// Creates all passes of the list, in its order, up to the first failure. Leaves out rows without a shader.
enum vw_status vw_passes_create(struct vw_gpu_objects *objects, const struct vw_pass_params *common,
                                const struct vw_pass_row *rows, size_t count);

#endif
