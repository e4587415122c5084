#include "train/evaluator.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/effects/effects.h"
#include "train/passes.h"
#include "train/renderers/registry.h"

const char evaluator_role[] = "validation";

static enum vw_status create_buffers(uint32_t rays, struct vw_evaluator *evaluator) {
    const struct vw_buffer_row pixels = {&evaluator->pixels, "evaluated_pixels", sizeof(struct vw_pixel) * rays};
    const struct vw_buffer_row buffers[] = {
        {&evaluator->rays, "evaluated_rays", sizeof(struct vw_ray) * evaluator->ray_count},
        {&evaluator->colours, "colours", 16 * (uint64_t)evaluator->ray_count},
    };
    enum vw_status status = vw_buffers_create(&evaluator->objects, VW_BUFFER_UPLOAD, &pixels, 1);
    return !status ? vw_buffers_create(&evaluator->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers))
                   : status;
}

bool vw_evaluator_sees_photos(const struct vw_evaluator *evaluator) {
    return vw_effects_see_photos(evaluator->field->model);
}

// Makes room for one more group: the last view's rays may begin within a group.
static enum vw_status make_room_for_views(uint32_t rays, struct vw_evaluator *evaluator) {
    if (!vw_evaluator_sees_photos(evaluator)) return VW_OK;
    evaluator->views = vw_allocate(rays, sizeof *evaluator->views);
    if (!evaluator->views) return VW_ERROR_MEMORY;
    evaluator->views[0] = (struct vw_view_rays){.count = evaluator->ray_count};
    evaluator->view_count = 1;
    evaluator->ray_count += evaluator->field->model->ray_group;
    return VW_OK;
}

static enum vw_status create(struct vw_radiance_field *field, uint32_t rays, bool depth,
                             struct vw_evaluator *evaluator) {
    const struct vw_model *model = field->model;
    *evaluator = (struct vw_evaluator){
        .field = field, .objects = {.gpu = field->gpu}, .ray_count = vw_model_pad_rays(model, rays), .depth = depth};
    enum vw_status status = make_room_for_views(rays, evaluator);
    if (!status) status = create_buffers(rays, evaluator);
    if (!status) status = model->renderer->create_evaluation(evaluator);
    if (!status) status = vw_submission_create(field->gpu, &evaluator->submission);
    if (status) vw_evaluator_destroy(evaluator);
    return status;
}

enum vw_status vw_evaluator_create(struct vw_radiance_field *field, uint32_t rays, struct vw_evaluator *evaluator) {
    return create(field, rays, false, evaluator);
}

enum vw_status vw_evaluator_create_of_depth(struct vw_radiance_field *field, uint32_t rays,
                                            struct vw_evaluator *evaluator) {
    return create(field, rays, true, evaluator);
}

void vw_evaluator_destroy(struct vw_evaluator *evaluator) {
    vw_submission_destroy(&evaluator->submission);
    const struct vw_renderer_kind *renderer = evaluator->field ? evaluator->field->model->renderer : NULL;
    if (renderer && renderer->destroy_evaluation) renderer->destroy_evaluation(evaluator);
    vw_gpu_objects_destroy(&evaluator->objects);
    free(evaluator->views);
    evaluator->views = NULL;
}

static void list_views(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    evaluator->view_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i == 0 || pixels[i].view != pixels[i - 1].view)
            evaluator->views[evaluator->view_count++] = (struct vw_view_rays){.view = pixels[i].view, .first = i};
        evaluator->views[evaluator->view_count - 1].count++;
    }
}

enum vw_status vw_evaluator_set_pixels(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    memcpy(vw_buffer_map(evaluator->pixels), pixels, count * sizeof *pixels);
    if (vw_evaluator_sees_photos(evaluator)) list_views(evaluator, pixels, count);
    const struct vw_renderer_kind *renderer = evaluator->field->model->renderer;
    enum vw_status status = renderer->take_pixels ? renderer->take_pixels(evaluator, pixels, count) : VW_OK;
    if (status) return status;
    struct vw_push_rays push = {.first_pixel = 0, .ray_count = count};
    vw_submission_begin(evaluator->submission);
    vw_submission_dispatch(evaluator->submission, evaluator->generate, &push, sizeof push, evaluator->ray_count);
    status = vw_submission_submit(evaluator->submission);
    return !status ? vw_submission_wait(evaluator->submission) : status;
}

void vw_evaluator_record(const struct vw_evaluator *evaluator, struct vw_submission *submission) {
    evaluator->field->model->renderer->record_evaluation(evaluator, submission);
}

enum vw_status vw_evaluator_run(struct vw_evaluator *evaluator) {
    vw_submission_begin(evaluator->submission);
    vw_evaluator_record(evaluator, evaluator->submission);
    enum vw_status status = vw_submission_submit(evaluator->submission);
    return !status ? vw_submission_wait(evaluator->submission) : status;
}

enum vw_status vw_evaluator_render(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count,
                                   vw_float4 *colours) {
    enum vw_status status = vw_evaluator_set_pixels(evaluator, pixels, count);
    if (!status) status = vw_evaluator_run(evaluator);
    return !status ? vw_buffer_read(evaluator->colours, 0, colours, count * sizeof *colours) : status;
}
