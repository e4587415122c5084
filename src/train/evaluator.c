#include "train/evaluator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
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

enum vw_status vw_evaluator_create(struct vw_radiance_field *field, uint32_t rays, bool depth,
                                   struct vw_evaluator *evaluator) {
    const struct vw_model *model = field->model;
    *evaluator = (struct vw_evaluator){
        .field = field, .objects = {.gpu = field->gpu}, .ray_count = vw_model_pad_rays(model, rays), .depth = depth};
    enum vw_status status = make_room_for_views(rays, evaluator);
    if (!status) status = create_buffers(rays, evaluator);
    if (!status) status = model->renderer->evaluation->create(evaluator);
    if (!status) status = vw_submission_create(field->gpu, &evaluator->submission);
    if (status) vw_evaluator_destroy(evaluator);
    return status;
}

void vw_evaluator_destroy(struct vw_evaluator *evaluator) {
    vw_submission_destroy(&evaluator->submission);
    if (evaluator->of_renderer && evaluator->field->model->renderer->evaluation->destroy)
        evaluator->field->model->renderer->evaluation->destroy(evaluator);
    vw_gpu_objects_destroy(&evaluator->objects);
    free(evaluator->of_renderer);
    free(evaluator->views);
    evaluator->of_renderer = NULL;
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
    enum vw_status status =
        renderer->evaluation->take_pixels ? renderer->evaluation->take_pixels(evaluator, pixels, count) : VW_OK;
    if (status) return status;
    struct vw_push_rays push = {.first_pixel = 0, .ray_count = count};
    vw_submission_begin(evaluator->submission);
    vw_submission_dispatch(evaluator->submission, evaluator->generate, &push, sizeof push, evaluator->ray_count);
    status = vw_submission_submit(evaluator->submission);
    return !status ? vw_submission_wait(evaluator->submission) : status;
}

void vw_evaluator_record(const struct vw_evaluator *evaluator, struct vw_submission *submission) {
    evaluator->field->model->renderer->evaluation->record(evaluator, submission);
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

// ---- Renders --------------------------------------------------------------------------------------------------------

enum { RENDERED_RAYS = 8192 };

// Returns the photo's pixel in the middle of the `place`-th of `count` parts of a side.
static uint32_t middle_of(uint32_t side_px, uint64_t place, uint32_t count) {
    return (uint32_t)((2 * place + 1) * side_px / (2 * (uint64_t)count));
}

// Returns the depth along the camera's axis, in world units; 0 where the ray sees no more than `least` of anything.
static float depth_of(const struct vw_radiance_field *field, const struct vw_view *view, const struct vw_pixel *pixel,
                      vw_float4 seen, double least) {
    const struct vw_box *box = &field->model->box;
    double share = 1 - (double)seen.w, direction[3];
    if (!vw_camera_unproject(&view->camera, pixel->x_px, pixel->y_px, direction) || !(share > least)) return 0;
    double segment = sqrt(vw_dot(direction, direction, 3)), depth = seen.x / share;
    if (!field->model->renderer->depth_along_axis) {
        bool from_camera = field->model->specialization.effect_unbounded;
        depth = depth / segment + (from_camera ? 0 : vw_field_camera(field->model, view, box).reference.w);
    }
    return (float)(depth * 2 * box->half_extent_world);
}

static enum vw_status render_tiles(struct vw_evaluator *evaluator, const struct vw_picture *picture,
                                   struct vw_pixel *pixels, vw_float4 *colours, float *values) {
    const struct vw_view *view = vw_field_view(evaluator->field, picture->view);
    const uint32_t *size_px = picture->size_px;
    uint64_t total = (uint64_t)size_px[0] * size_px[1];
    for (uint64_t first = 0; first < total; first += RENDERED_RAYS) {
        uint32_t count = total - first < RENDERED_RAYS ? (uint32_t)(total - first) : RENDERED_RAYS;
        for (uint32_t i = 0; i < count; i++) // without a target: the field does not see it
            pixels[i] = (struct vw_pixel){
                .x_px = 0.5f + (float)middle_of(view->camera.width_px, (first + i) % size_px[0], size_px[0]),
                .y_px = 0.5f + (float)middle_of(view->camera.height_px, (first + i) / size_px[0], size_px[1]),
                .view = picture->view};
        enum vw_status status = vw_evaluator_render(evaluator, pixels, count, colours);
        if (status) return status;
        for (uint32_t i = 0; i < count && !(picture->depth_share > 0); i++)
            memcpy(values + 3 * (first + i), &colours[i], 3 * sizeof *values);
        for (uint32_t i = 0; i < count && picture->depth_share > 0; i++)
            values[first + i] = depth_of(evaluator->field, view, &pixels[i], colours[i], picture->depth_share);
    }
    return VW_OK;
}

static enum vw_status render_picture(struct vw_evaluator *evaluator, const struct vw_picture *picture,
                                     struct vw_pixel *pixels, vw_float4 *colours, float *values) {
    if (!picture->posed) return render_tiles(evaluator, picture, pixels, colours, values);
    enum vw_status status = vw_field_pose(evaluator->field, picture->view, picture->posed);
    if (!status) status = render_tiles(evaluator, picture, pixels, colours, values);
    enum vw_status undone = vw_field_pose(evaluator->field, picture->view, NULL);
    return status ? status : undone;
}

enum vw_status vw_field_render(struct vw_radiance_field *field, const struct vw_picture *pictures, uint32_t count,
                               float **values) {
    struct vw_evaluator evaluator = {0};
    size_t pixel_count = (size_t)pictures->size_px[0] * pictures->size_px[1],
           value_count = pixel_count * (pictures->depth_share > 0 ? 1 : 3);
    uint32_t rays = pixel_count < RENDERED_RAYS ? (uint32_t)pixel_count : RENDERED_RAYS;
    struct vw_pixel *pixels = vw_allocate(rays, sizeof *pixels);
    vw_float4 *colours = vw_allocate(rays, sizeof *colours);
    float *rendered = vw_allocate(value_count * count, sizeof *rendered);
    enum vw_status status = pixels && colours && rendered ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_evaluator_create(field, rays, pictures->depth_share > 0, &evaluator);
    for (uint32_t i = 0; i < count && !status; i++)
        status = render_picture(&evaluator, &pictures[i], pixels, colours, rendered + i * value_count);
    vw_evaluator_destroy(&evaluator);
    free(pixels);
    free(colours);
    if (!status) *values = rendered;
    else free(rendered);
    return status;
}
