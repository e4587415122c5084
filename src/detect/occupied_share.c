// The field's own passes, on rays of ours: each runs along x through the middles of a row of cells, and samples fall on
// them.
#include "detect/occupied_share.h"

#include <stdlib.h>

#include "base/memory.h"
#include "gpu/compute.h"
#include "train/evaluator.h"

static const double OPACITY_MIN = 0.01; // opacity of a stratum; density * length, as 1 - exp(-x) is x here

static void fill_rays(uint32_t cells, uint32_t first, uint32_t count, struct vw_ray *rays) {
    for (uint32_t i = 0; i < count; i++) {
        float y = (float)((first + i) % cells), z = (float)((first + i) / cells % cells), edge = 1.0f / (float)cells;
        rays[i] = (struct vw_ray){.origin_near = {0.0f, (y + 0.5f) * edge, (z + 0.5f) * edge, 0.0f},
                                  .direction_stride = {1.0f, 0.0f, 0.0f, edge}};
    }
}

static enum vw_status count_part(struct vw_evaluator *evaluator, uint32_t cells, uint32_t rays, uint32_t *occupied) {
    vw_float4 *samples = vw_allocate((size_t)rays * cells, sizeof *samples);
    if (!samples) return VW_ERROR_MEMORY;
    enum vw_status status = vw_evaluator_run(evaluator);
    if (!status) status = vw_buffer_read(evaluator->samples, 0, samples, (uint64_t)rays * cells * sizeof *samples);
    for (uint32_t i = 0; !status && i < rays * cells; i++) *occupied += samples[i].w >= OPACITY_MIN * cells;
    free(samples);
    return status;
}

enum vw_status vw_occupied_share(struct vw_radiance_field *field, uint32_t samples, double *share) {
    uint32_t cells = samples, occupied = 0;
    struct vw_evaluator evaluator = {0};
    struct vw_ray *rays = NULL;
    enum vw_status status = vw_evaluator_create(field, cells, &evaluator); // a layer of cells at a time
    if (!status) rays = vw_allocate(evaluator.ray_count, sizeof *rays);
    if (!status && !rays) status = VW_ERROR_MEMORY;
    for (uint32_t layer = 0; layer < cells && !status; layer++) {
        fill_rays(cells, layer * cells, evaluator.ray_count, rays);
        status = vw_buffer_write(evaluator.rays, 0, rays, evaluator.ray_count * sizeof *rays);
        if (!status) status = count_part(&evaluator, cells, cells, &occupied);
    }
    if (!status) *share = (double)occupied / ((double)cells * cells * cells);
    vw_evaluator_destroy(&evaluator);
    free(rays);
    return status;
}
