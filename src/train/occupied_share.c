// How much of a field is occupied, whether or not its training skips the rest.
#include <stdlib.h>

#include "gpu/shaders.h"
#include "trainer.h"
#include "viewworth/memory.h"

enum { ASKED_POINTS = 8 }; // per cell

struct question {
    struct vw_buffer *densities; // of each cell the largest so far
    struct vw_pass *refresh;
    struct vw_batch *batch;
};

static enum vw_status open_question(const struct field *field, struct question *question) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0;
    enum vw_status status = vw_buffer_create(
        field->gpu, &(struct vw_buffer_params){.name = "asked_densities", .size_bytes = 4 * VW_OCCUPANCY_CELLS}, &question->densities);
    field_bind(field, bindings, &count);
    bindings[count++] = (struct vw_binding){.slot = VW_SLOT_OCCUPANCY, .buffer = question->densities};
    struct vw_pass_params params = {.shader = &vw_shader_refresh_occupancy,
                                    .specialization = (const uint32_t *)&field->model->specialization,
                                    .specialization_count = VW_SPECIALIZATION_COUNT,
                                    .bindings = bindings,
                                    .binding_count = count};
    if (status == VW_OK) status = vw_pass_create(field->gpu, &params, &question->refresh);
    if (status == VW_OK) status = vw_batch_create(field->gpu, &question->batch);
    return status;
}

static void close_question(struct question *question) {
    vw_batch_destroy(&question->batch);
    vw_pass_destroy(&question->refresh);
    vw_buffer_destroy(&question->densities);
}

static enum vw_status ask(const struct question *question, float *densities) {
    vw_batch_begin(question->batch);
    for (uint32_t point = 0; point < ASKED_POINTS; point++) {
        struct vw_push_refresh push = {.step_low = point, .remains = 1.0f};
        vw_batch_dispatch(question->batch, question->refresh, &push, sizeof push, VW_OCCUPANCY_CELLS);
    }
    enum vw_status status = vw_batch_submit(question->batch);
    if (status == VW_OK) status = vw_batch_wait(question->batch);
    return status == VW_OK ? vw_buffer_read(question->densities, 0, densities, 4 * VW_OCCUPANCY_CELLS) : status;
}

enum vw_status vw_trainer_occupied_share(struct vw_trainer *trainer, double *share) {
    struct question question = {0};
    float *densities = vw_allocate(VW_OCCUPANCY_CELLS, sizeof *densities);
    enum vw_status status = densities ? open_question(&trainer->field, &question) : VW_ERROR_MEMORY;
    if (status == VW_OK) status = ask(&question, densities);
    if (status == VW_OK) {
        uint32_t occupied = 0;
        float empty = VW_EMPTY_DENSITY((float)trainer->config.samples);
        for (uint32_t i = 0; i < VW_OCCUPANCY_CELLS; i++) occupied += !(densities[i] <= empty);
        *share = (double)occupied / VW_OCCUPANCY_CELLS;
    }
    close_question(&question);
    free(densities);
    return status;
}
