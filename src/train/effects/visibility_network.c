#include "train/effects/visibility_network.h"

#include <stdlib.h>

#include "base/memory.h"

_Static_assert(VISIBILITY_INPUT4 == VISIBILITY_PLACE4 + VISIBILITY_CODE4 &&
                   VISIBILITY_PLACE4 == 1 + VISIBILITY_FREQUENCIES &&
                   VISIBILITY_LAYER2 == 4 * VISIBILITY4 * VISIBILITY_INPUT4 &&
                   VISIBILITY_BIAS2 == VISIBILITY_LAYER2 + 4 * VISIBILITY4 * VISIBILITY4 &&
                   VISIBILITY_LOGIT == VISIBILITY_BIAS2 + VISIBILITY4 &&
                   VISIBILITY_COLUMNS == VISIBILITY_LOGIT + VISIBILITY4 + 1,
               "the network's parts do not follow one another");

void vw_visibility_initialise(float *values, const struct vw_drawn *drawn) {
    vw_fill_matrix(values, drawn, VISIBILITY4, VISIBILITY_INPUT4);
    vw_fill_matrix(values + 4 * VISIBILITY_LAYER2, drawn, VISIBILITY4, VISIBILITY4);
    vw_fill_weights(values + 4 * VISIBILITY_LOGIT, drawn, 4 * VISIBILITY4, 0.5f / VISIBILITY4);
}

enum vw_status vw_visibility_create_scales(struct vw_gpu *gpu, const struct vw_scene *scene,
                                           struct vw_buffer **scales) {
    struct vw_buffer_params params = {.name = "photo_scales", .size_bytes = 2 * sizeof(float) * scene->view_count};
    float *values = vw_allocate(scene->view_count, 2 * sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        values[2 * i] = 2.0f / (float)scene->views[i].image.width_px;
        values[2 * i + 1] = 2.0f / (float)scene->views[i].image.height_px;
    }
    enum vw_status status = vw_buffer_create(gpu, &params, scales);
    if (!status) status = vw_buffer_write(*scales, 0, values, params.size_bytes);
    free(values);
    return status;
}
