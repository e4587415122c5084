// Lists of buffers and passes that are created and destroyed together.
#ifndef VIEWWORTH_TRAIN_PASSES_H
#define VIEWWORTH_TRAIN_PASSES_H

#include "gpu/compute.h"
#include "interface.h"

struct vw_buffer_row {
    struct vw_buffer **buffer;
    struct vw_buffer_params params;
};

// Creates all buffers of the list, in its order, up to the first failure. Leaves out those of 0 bytes.
enum vw_status vw_buffers_create(struct vw_gpu *gpu, const struct vw_buffer_row *rows, size_t count);
void vw_buffers_destroy(struct vw_buffer **const *buffers, size_t count);

struct vw_pass_row {
    const struct vw_shader *shader;
    struct vw_pass **pass;
};

// Returns params without a shader. All three are borrowed.
struct vw_pass_params vw_pass_params_of(const struct vw_specialization *specialization,
                                        const struct vw_binding *bindings, uint32_t count, const char *role);
// Creates one pass with the params' specialization, bindings and role.
enum vw_status vw_pass_create_of(struct vw_gpu *gpu, const struct vw_pass_params *common,
                                 const struct vw_shader *shader, struct vw_pass **pass);
// Creates all passes of the list, in its order, up to the first failure. Leaves out rows without a shader.
enum vw_status vw_passes_create(struct vw_gpu *gpu, const struct vw_pass_params *common, const struct vw_pass_row *rows,
                                size_t count);
void vw_passes_destroy(struct vw_pass **const *passes, size_t count);

#endif
