#include "train/passes.h"

#include <stdlib.h>

#include "base/memory.h"

enum vw_status vw_buffers_create(struct vw_gpu_objects *objects, enum vw_buffer_memory memory,
                                 const struct vw_buffer_row *rows, size_t count) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < count && !status; i++) {
        const struct vw_buffer_params params = {rows[i].name, rows[i].size_bytes, memory};
        if (!params.size_bytes) continue;
        status = vw_grow((void **)&objects->buffers, &objects->buffer_capacity, objects->buffer_count + 1,
                         sizeof *objects->buffers);
        if (!status) status = vw_buffer_create(objects->gpu, &params, rows[i].buffer);
        if (!status) objects->buffers[objects->buffer_count++] = *rows[i].buffer;
    }
    return status;
}

struct vw_pass_params vw_pass_params_of(const struct vw_specialization *specialization,
                                        const struct vw_binding *bindings, uint32_t count, const char *role) {
    return (struct vw_pass_params){.specialization = (const uint32_t *)specialization,
                                   .specialization_count = VW_SPECIALIZATION_COUNT,
                                   .bindings = bindings,
                                   .binding_count = count,
                                   .role = role};
}

enum vw_status vw_pass_create_of(struct vw_gpu_objects *objects, const struct vw_pass_params *common,
                                 const struct vw_shader *shader, struct vw_pass **pass) {
    struct vw_pass_params params = *common;
    params.shader = shader;
    enum vw_status status =
        vw_grow((void **)&objects->passes, &objects->pass_capacity, objects->pass_count + 1, sizeof *objects->passes);
    if (!status) status = vw_pass_create(objects->gpu, &params, pass);
    if (!status) objects->passes[objects->pass_count++] = *pass;
    return status;
}

enum vw_status vw_passes_create(struct vw_gpu_objects *objects, const struct vw_pass_params *common,
                                const struct vw_pass_row *rows, size_t count) {
    enum vw_status status = VW_OK;
    for (size_t i = 0; i < count && !status; i++)
        if (rows[i].shader) status = vw_pass_create_of(objects, common, rows[i].shader, rows[i].pass);
    return status;
}

void vw_gpu_objects_destroy(struct vw_gpu_objects *objects) {
    for (size_t i = 0; i < objects->pass_count; i++) vw_pass_destroy(&objects->passes[i]);
    for (size_t i = 0; i < objects->buffer_count; i++) vw_buffer_destroy(&objects->buffers[i]);
    free(objects->passes);
    free(objects->buffers);
    *objects = (struct vw_gpu_objects){0};
}
