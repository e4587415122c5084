#include "run/next/fisher_diagonal.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "train/effects/effects.h"
#include "train/renderers/registry.h"
#include "train/trainer.h"

static enum vw_status check(const struct vw_trainer_parts *parts) {
    const struct vw_model *model = parts->field->model;
    if (model->renderer != &renderer_volume || vw_effects_see_photos(model))
        return vw_fail(VW_ERROR_USAGE, "--method fisher: cannot go back through %s; choose another method",
                       model->renderer != &renderer_volume ? "splats" : "an effect that sees photos");
    if (!parts->validation->view_count)
        return vw_fail(VW_ERROR_USAGE, "--method fisher: needs validation photos; choose another method");
    return vw_adjoint_check(parts);
}

enum vw_status vw_fisher_create(const struct vw_known_views *known, uint32_t draws, struct vw_fisher *fisher) {
    const struct vw_trainer_parts *parts = vw_trainer_get_parts(known->trainer);
    const struct vw_adjoint_params params = {.submission_steps = 1, .psnr_alone = true};
    *fisher = (struct vw_fisher){.field = parts->field, .view = known->views[0], .draws = draws};
    enum vw_status status = check(parts);
    uint32_t val_rays = parts->validation->evaluator.ray_count;
    fisher->ray_count = val_rays < VW_FISHER_RAYS_MOST ? val_rays : VW_FISHER_RAYS_MOST;
    if (!status) status = vw_adjoint_create(parts, &params, &fisher->passes);
    if (!status) status = vw_evaluator_create(parts->field, fisher->ray_count, &fisher->evaluator);
    if (!status) status = vw_submission_create(parts->field->gpu, &fisher->submission);
    if (status) return status;
    fisher->param_count = parts->field->model->param_bytes / sizeof *fisher->gradient;
    fisher->rays = vw_allocate(fisher->ray_count, sizeof *fisher->rays);
    fisher->gradient = vw_allocate(fisher->param_count, sizeof *fisher->gradient);
    return fisher->rays && fisher->gradient ? VW_OK : VW_ERROR_MEMORY;
}

void vw_fisher_destroy(struct vw_fisher *fisher) {
    vw_submission_destroy(&fisher->submission);
    vw_evaluator_destroy(&fisher->evaluator);
    vw_adjoint_destroy(&fisher->passes);
    free(fisher->rays);
    free(fisher->gradient);
    *fisher = (struct vw_fisher){0};
}

// Makes the rays of an even grid of pixels; returns their number.
static enum vw_status make_rays(struct vw_fisher *fisher, const struct vw_view *pose, uint32_t *count) {
    struct vw_pixel pixels[VW_FISHER_RAYS_MOST];
    uint32_t most = fisher->ray_count;
    const struct vw_camera *camera = &pose->camera;
    uint32_t columns = (uint32_t)sqrt((double)most * camera->width_px / camera->height_px);
    columns = columns < 1 ? 1 : columns > most ? most : columns;
    uint32_t rows = most / columns;
    for (uint32_t i = 0; i < columns * rows; i++)
        pixels[i] = (struct vw_pixel){.x_px = (i % columns + 0.5f) * (float)camera->width_px / (float)columns,
                                      .y_px = (i / columns + 0.5f) * (float)camera->height_px / (float)rows,
                                      .view = fisher->view,
                                      .weight = 1};
    enum vw_status status = vw_field_pose(fisher->field, fisher->view, pose);
    if (!status) status = vw_evaluator_set_pixels(&fisher->evaluator, pixels, columns * rows);
    enum vw_status undone = vw_field_pose(fisher->field, fisher->view, NULL);
    if (status || undone) return status ? status : undone;
    *count = columns * rows;
    return vw_buffer_read(fisher->evaluator.rays, 0, fisher->rays, *count * sizeof *fisher->rays);
}

static void draw_signs(struct vw_fisher *fisher, uint32_t draw, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t words[4];
        vw_random_words(0, VW_RANDOM_SIGN, draw, i, 0, words);
        fisher->rays[i].target_weight =
            (vw_float4){words[0] & 1 ? 1 : -1, words[1] & 1 ? 1 : -1, words[2] & 1 ? 1 : -1, 1};
    }
}

enum vw_status vw_fisher_add(struct vw_fisher *fisher, const struct vw_view *pose, float *diagonal) {
    uint32_t count = 0;
    enum vw_status status = make_rays(fisher, pose, &count);
    for (uint32_t draw = 0; draw < fisher->draws && !status; draw++) {
        draw_signs(fisher, draw, count);
        status = vw_adjoint_pull_back(&fisher->passes, fisher->submission, fisher->rays, count, fisher->gradient);
        for (uint64_t j = 0; j < fisher->param_count && !status; j++)
            diagonal[j] += fisher->gradient[j] * fisher->gradient[j] / (float)fisher->draws;
    }
    return status;
}
