#include "train/passes.h"

enum vw_status vw_buffers_create(struct vw_gpu *gpu, const struct vw_buffer_row *rows, size_t count) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < count && !status; i++)
        if (rows[i].params.size_bytes) status = vw_buffer_create(gpu, &rows[i].params, rows[i].buffer);
    return status;
}

void vw_buffers_destroy(struct vw_buffer **const *buffers, size_t count) {
    for (size_t i = 0; i < count; i++) vw_buffer_destroy(buffers[i]);
}

struct vw_pass_params vw_pass_params_of(const struct vw_specialization *specialization,
                                        const struct vw_binding *bindings, uint32_t count, const char *role) {
    return (struct vw_pass_params){.specialization = (const uint32_t *)specialization,
                                   .specialization_count = VW_SPECIALIZATION_COUNT,
                                   .bindings = bindings,
                                   .binding_count = count,
                                   .role = role};
}

enum vw_status vw_pass_create_of(struct vw_gpu *gpu, const struct vw_pass_params *common,
                                 const struct vw_shader *shader, struct vw_pass **pass) {
    struct vw_pass_params params = *common;
    params.shader = shader;
    return vw_pass_create(gpu, &params, pass);
}

enum vw_status vw_passes_create(struct vw_gpu *gpu, const struct vw_pass_params *common, const struct vw_pass_row *rows,
                                size_t count) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < count && !status; i++)
        if (rows[i].shader) status = vw_pass_create_of(gpu, common, rows[i].shader, rows[i].pass);
    return status;
}

void vw_passes_destroy(struct vw_pass **const *passes, size_t count) {
    for (size_t i = 0; i < count; i++) vw_pass_destroy(passes[i]);
}
