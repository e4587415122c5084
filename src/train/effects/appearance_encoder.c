// The effect `appearance_encoder` (HA-NeRF, Chen et al., CVPR 2022, section 3.1): photos that differ in exposure, white
// balance and light. A small convolutional network makes a code of 48 numbers from a photo's thumbnail
// (appearance_encoder.h); the code enters the colour network as those of appearance_code do. update_weights moves the
// network with all other weights.
//   convolve_photo, pool_photo: the photo's code and the shift of the colour network -> the field, forward and back ->
//   spread_photo, convolve_photo_back, gradient_photo: gradients of the network
// A photo that nothing was trained on has a code as well: validation and renders of a view see it by the view's own
// photo. They remain a function of the params alone: thumbnails are the scene's.

#include "train/effects/appearance_encoder.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "gpu/shaders.h"
#include "image/image.h"
#include "train/effects/effects.h"
#include "train/field.h"
#include "train/passes.h"
#include "train/photo_order.h"
#include "train/step.h"

// Its passes, forward and back.
enum { ENCODER_CONVOLVE, ENCODER_POOL, ENCODER_SPREAD, ENCODER_CONVOLVE_BACK, ENCODER_GRADIENT, ENCODER_PASSES };

// ---- Params ---------------------------------------------------------------------------------------------------------

enum { LAYER_BLOCKS = ENCODER_TAPS * ENCODER4 };
_Static_assert(THUMBNAIL_PIXELS == THUMBNAIL_SIDE * THUMBNAIL_SIDE && ENCODER_LAYERS == 3 &&
                   ENCODER_LAYER2 == 4 * LAYER_BLOCKS + ENCODER4 &&
                   ENCODER_LAYER3 == ENCODER_LAYER2 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE == ENCODER_LAYER3 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE_BIAS == ENCODER_CODE + 4 * CODE4 * ENCODER4 &&
                   ENCODER_SHIFT == ENCODER_CODE_BIAS + CODE4,
               "the network's parts do not follow one another");
_Static_assert(ENCODER_ROW_LAYER2 == ENCODER4 * THUMBNAIL_PIXELS / 4 &&
                   ENCODER_ROW_LAYER3 == ENCODER_ROW_LAYER2 + ENCODER4 * THUMBNAIL_PIXELS / 16 &&
                   ENCODER_ROW_MEAN == ENCODER_ROW_LAYER3 + ENCODER4 * THUMBNAIL_PIXELS / 64 &&
                   ENCODER_ROW_CODE == ENCODER_ROW_MEAN + ENCODER4 && ENCODER_ROWS == ENCODER_ROW_CODE + CODE4,
               "its rows do not follow one another");

// Draws weights within He's bound for what a convolution sums; biases and the matrix to the code stay 0.
static void draw_convolution(float *values, const struct vw_drawn *drawn, uint32_t inputs) {
    vw_fill_weights(values, drawn, LAYER_BLOCKS * 4 * (uint64_t)inputs, sqrtf(6.0f / (float)(ENCODER_TAPS * inputs)));
}

static void lay_out_columns(struct vw_model *model) {
    uint32_t columns = VW_ENCODER_COLUMNS(model->specialization.width4);
    model->specialization.encoder_column = vw_model_append_columns(model, columns, 4 * (uint64_t)columns);
    if (model->config->consistency_weight > 0.0) model->picture_side = (uint32_t)sqrt(model->config->rays);
}

// Makes all codes 0 at first, so that the field starts as it would without them.
static void initialise(const struct vw_model *model, const struct vw_drawn *drawn, void *params) {
    float *values = (float *)((char *)params + vw_encoder_network(model).offset_bytes);
    draw_convolution(values, drawn, 4);
    draw_convolution(values + 4 * ENCODER_LAYER2, drawn, 4 * ENCODER4);
    draw_convolution(values + 4 * ENCODER_LAYER3, drawn, 4 * ENCODER4);
    vw_fill_matrix(values + 4 * ENCODER_SHIFT, drawn, model->specialization.width4, CODE4);
}

// ---- Buffers --------------------------------------------------------------------------------------------------------

static uint32_t list_buffers(const struct vw_model *model, uint32_t padded_rays, struct vw_effect_buffer *buffers) {
    (void)padded_rays;
    uint64_t photos = model->view_count, width4 = model->specialization.width4;
    const struct vw_effect_buffer listed[] = {
        {VW_SLOT_THUMBNAILS, "thumbnails", sizeof(vw_float4) * THUMBNAIL_PIXELS * photos, VW_EFFECT_OF_FIELD},
        {VW_SLOT_ENCODER_ROWS, "encoder_rows", sizeof(vw_float4) * ENCODER_ROWS, VW_EFFECT_OF_FIELD},
        {VW_SLOT_CODE_SHIFT, "code_shift", sizeof(vw_float4) * width4, VW_EFFECT_OF_FIELD},
        {VW_SLOT_D_ENCODER_ROWS, "d_encoder_rows", sizeof(vw_float4) * ENCODER_ROW_MEAN, VW_EFFECT_OF_STEP},
    };
    memcpy(buffers, listed, sizeof listed);
    return VW_ARRAY_COUNT(listed);
}

// Makes the thumbnails of all photos. VW_ERROR_USAGE where they are too many for the device.
static enum vw_status fill(const struct vw_model *model, struct vw_gpu *gpu, const struct vw_scene *scene,
                           struct vw_buffer *const *buffers) {
    uint64_t size_bytes = (uint64_t)scene->view_count * THUMBNAIL_PIXELS * sizeof(vw_float4);
    if (size_bytes > vw_gpu_get_limits(gpu)->storage_binding_bytes)
        return vw_fail(VW_ERROR_USAGE,
                       "--effects: appearance_encoder: the thumbnails of %u photos exceed this device's binding range; "
                       "leave it out, or exclude photos",
                       scene->view_count);
    enum vw_status status = vw_scene_decode_all(scene);
    if (status) return status;
    vw_float4 *thumbnails = vw_allocate(size_bytes, 1); // 0 for excluded photos, which have no pixels
    if (!thumbnails) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        const struct vw_thumbnail_choice whole = {vw_pixels_all_columns(scene, i), model->obeys_masks};
        if (scene->views[i].image.pixels)
            vw_thumbnail_make(&scene->views[i], &whole, thumbnails + (size_t)THUMBNAIL_PIXELS * i);
    }
    status = vw_buffer_write(buffers[VW_SLOT_THUMBNAILS], 0, thumbnails, size_bytes);
    free(thumbnails);
    return status;
}

// ---- The encoder ----------------------------------------------------------------------------------------------------

struct vw_param_range vw_encoder_network(const struct vw_model *model) {
    const struct vw_specialization *s = &model->specialization;
    if (!s->effect_appearance_encoder) return (struct vw_param_range){0};
    return vw_model_columns(model, s->encoder_column, VW_ENCODER_COLUMNS(s->width4));
}

enum vw_status vw_encoder_set_thumbnail(const struct vw_radiance_field *field, const struct vw_scene *scene,
                                        uint32_t view, const struct vw_thumbnail_choice *choice) {
    vw_float4 thumbnail[THUMBNAIL_PIXELS];
    if (!field->model->specialization.effect_appearance_encoder) return VW_OK;
    vw_thumbnail_make(&scene->views[view], choice, thumbnail);
    return vw_buffer_write(field->effect_buffers[VW_SLOT_THUMBNAILS], (uint64_t)view * sizeof thumbnail, thumbnail,
                           sizeof thumbnail);
}

// Creates a set of passes of its own, with vw_shader_spread_photo_codes in place of vw_shader_spread_photo; without
// `back` only the first two.
static enum vw_status create_encoder_passes(struct vw_gpu_objects *objects, const struct vw_pass_params *common,
                                            bool back, struct vw_effect_passes *set) {
    const struct vw_pass_row rows[ENCODER_PASSES] = {
        {&vw_shader_convolve_photo, &set->passes[ENCODER_CONVOLVE]},
        {&vw_shader_pool_photo, &set->passes[ENCODER_POOL]},
        {&vw_shader_spread_photo_codes, &set->passes[ENCODER_SPREAD]},
        {&vw_shader_convolve_photo_back, &set->passes[ENCODER_CONVOLVE_BACK]},
        {&vw_shader_gradient_photo, &set->passes[ENCODER_GRADIENT]},
    };
    return vw_passes_create(objects, common, rows, back ? ENCODER_PASSES : ENCODER_SPREAD);
}

// Records the code of a photo. In a step the photo is the step's; record it after generate_rays.
static void record_encoder_forward(struct vw_pass *const *passes, struct vw_submission *submission, uint32_t view) {
    struct vw_push_photo push = {.view = view};
    for (; push.layer < ENCODER_LAYERS; push.layer++)
        vw_submission_dispatch(submission, passes[ENCODER_CONVOLVE], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * (push.layer + 1));
    vw_submission_dispatch(submission, passes[ENCODER_POOL], NULL, 0, 1);
}

// Records its gradient, after the field's backward pass. `codes`: what spread_photo_codes takes, NULL without it.
static void record_encoder_back(struct vw_pass *const *passes, const struct vw_push_codes *codes,
                                struct vw_submission *submission) {
    struct vw_push_photo push = {.layer = ENCODER_LAYERS - 1};
    vw_submission_dispatch(submission, passes[ENCODER_SPREAD], codes, codes ? sizeof *codes : 0, 1);
    for (; push.layer > 0; push.layer--)
        vw_submission_dispatch(submission, passes[ENCODER_CONVOLVE_BACK], &push, sizeof push,
                               (uint64_t)ENCODER4 * THUMBNAIL_PIXELS >> 2 * push.layer);
    vw_submission_dispatch(submission, passes[ENCODER_GRADIENT], NULL, 0, ENCODER_CODE);
}

// ---- Thumbnails -----------------------------------------------------------------------------------------------------

struct part { // a part of a side, in pixels
    double begin, end;
};

static struct part part_of(uint32_t index, double side_px) {
    return (struct part){index * side_px / THUMBNAIL_SIDE, (index + 1) * side_px / THUMBNAIL_SIDE};
}

// Returns how much of a pixel lies in a part.
static double overlap(const struct part *part, uint32_t at_px) {
    return fmin(part->end, at_px + 1.0) - fmax(part->begin, at_px);
}

// Adds one pixel times its area to the sum, where the pixel counts.
static void add_pixel(const struct vw_view *view, bool masks, uint32_t x_px, uint32_t y_px, double area,
                      double sum[4]) {
    float rgba[4];
    if (!(masks ? vw_view_keeps(view, x_px, y_px) : vw_view_can_use(view, x_px, y_px))) return;
    vw_image_pixel(&view->image, x_px, y_px, rgba);
    for (int c = 0; c < 3; c++) sum[c] += area * rgba[3] * (2.0 * rgba[c] - 1.0);
    sum[3] += area * rgba[3];
}

static vw_float4 mean_of(const struct vw_view *view, const struct vw_thumbnail_choice *choice,
                         const struct part *columns, const struct part *rows) {
    double sum[4] = {0}, area = (columns->end - columns->begin) * (rows->end - rows->begin);
    for (uint32_t y = (uint32_t)rows->begin; y < rows->end && y < view->image.height_px; y++)
        for (uint32_t x = (uint32_t)columns->begin; x < columns->end && x < choice->columns.end; x++)
            add_pixel(view, choice->masks, x, y, overlap(columns, x) * overlap(rows, y), sum);
    return (vw_float4){(float)(sum[0] / area), (float)(sum[1] / area), (float)(sum[2] / area), (float)(sum[3] / area)};
}

void vw_thumbnail_make(const struct vw_view *view, const struct vw_thumbnail_choice *choice, vw_float4 *thumbnail) {
    uint32_t first = choice->columns.begin;
    for (uint32_t i = 0; i < THUMBNAIL_PIXELS; i++) {
        struct part columns = part_of(i % THUMBNAIL_SIDE, choice->columns.end - first),
                    rows = part_of(i / THUMBNAIL_SIDE, view->image.height_px);
        columns.begin += first;
        columns.end += first;
        thumbnail[i] = mean_of(view, choice, &columns, &rows);
    }
}

// ---- The consistency loss ------------------------------------------------------------------------------------------

static enum vw_status create_picture_buffers(const struct vw_step_passes *step, struct vw_consistency_effect *it) {
    uint64_t rays = it->padded_rays, columns = step->field->model->moved_columns;
    const struct vw_buffer_row buffers[] = {
        {&it->rays, "picture_rays", sizeof(struct vw_ray) * rays},
        {&it->ray_loss, "picture_ray_loss", sizeof(float) * rays}, // unread
        {&it->colours, "picture_colours", sizeof(vw_float4) * rays},
        {&it->d_sky, "picture_d_sky", step->effect_buffers[VW_SLOT_D_SKY] ? sizeof(vw_float4) * rays : 0},
        // 0 where this loss has no gradient
        {&it->d_weights, "picture_d_weights", sizeof(vw_float4) * columns},
        {&it->thumbnail, "picture_thumbnail", sizeof(vw_float4) * THUMBNAIL_PIXELS},
        {&it->encoder_rows, "picture_encoder_rows", sizeof(vw_float4) * ENCODER_ROWS},
        {&it->d_encoder_rows, "picture_d_encoder_rows", sizeof(vw_float4) * ENCODER_ROW_MEAN},
        {&it->code_shift, // unread
         "picture_code_shift", vw_buffer_size_bytes(step->field->effect_buffers[VW_SLOT_CODE_SHIFT])},
    };
    return vw_buffers_create(&it->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

// Returns the step's passes with the picture's buffers in place of its own.
static struct vw_step_passes step_of_picture(const struct vw_step_passes *step,
                                             const struct vw_consistency_effect *it) {
    struct vw_step_passes own = *step;
    own.ray_buffer = it->rays;
    own.ray_loss = it->ray_loss;
    own.effect_buffers[VW_SLOT_D_SKY] = it->d_sky;
    own.d_weights = it->d_weights;
    return own;
}

// Bindings that are not the step's.
static uint32_t bind_own(const struct vw_step_passes *step, const struct vw_consistency_effect *it,
                         struct vw_binding *bindings) {
    bindings[0] =
        (struct vw_binding){.slot = VW_SLOT_GIVEN_ROWS, .buffer = step->field->effect_buffers[VW_SLOT_ENCODER_ROWS]};
    bindings[1] = (struct vw_binding){.slot = VW_SLOT_OWN_D_WEIGHTS, .buffer = it->d_weights};
    bindings[2] = (struct vw_binding){.slot = VW_SLOT_SEEN_AHEAD, .buffer = it->colours};
    bindings[3] = (struct vw_binding){.slot = VW_SLOT_ADJOINT_STATE, .unused = true};
    return 4;
}

// Creates the passes over the buffers of the step. Outside of training the push block names a photo.
static enum vw_status create_on_step(const struct vw_step_passes *step, const struct vw_specialization *rendering,
                                     struct vw_consistency_effect *it) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = bind_own(step, it, bindings);
    vw_step_bind(step, bindings, &count);
    const struct vw_pass_params params = vw_pass_params_of(rendering, bindings, count, NULL);
    enum vw_status status = create_encoder_passes(&it->objects, &params, false, &it->give);
    return !status ? vw_pass_create_of(&it->objects, &params, &vw_shader_add_gradients, &it->add) : status;
}

static enum vw_status create_on_picture(const struct vw_step_passes *step, const struct vw_specialization *rendering,
                                        struct vw_consistency_effect *it) {
    const struct vw_specialization *given = &it->gradient.specialization;
    const struct vw_shader *composite = vw_model_has_ray_effects(step->field->model, given)
                                            ? &vw_shader_difference_rays_effects
                                            : &vw_shader_difference_rays;
    struct vw_step_passes own = step_of_picture(step, it);
    struct vw_radiance_field field = *step->field;
    field.effect_buffers[VW_SLOT_THUMBNAILS] = it->thumbnail;
    field.effect_buffers[VW_SLOT_ENCODER_ROWS] = it->encoder_rows;
    field.effect_buffers[VW_SLOT_CODE_SHIFT] = it->code_shift;
    own.effect_buffers[VW_SLOT_D_ENCODER_ROWS] = it->d_encoder_rows;
    own.field = &field;
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = bind_own(step, it, bindings);
    vw_step_bind(&own, bindings, &count);
    const struct vw_pass_params renders = vw_pass_params_of(rendering, bindings, count, NULL),
                                composites = vw_pass_params_of(given, bindings, count, NULL);
    const struct vw_pass_row rows[] = {{&vw_shader_shrink_colours, &it->shrink},
                                       {&vw_shader_spread_colours, &it->spread_colours}};
    enum vw_status status = create_encoder_passes(&it->objects, &renders, true, &it->see);
    if (!status) status = vw_passes_create(&it->objects, &renders, rows, VW_ARRAY_COUNT(rows));
    return !status ? vw_pass_create_of(&it->objects, &composites, composite, &it->composite) : status;
}

static enum vw_status create_passes(const struct vw_step_passes *step, struct vw_consistency_effect *it) {
    struct vw_specialization given = step->field->model->specialization, rendering = given;
    const struct vw_step_passes own = step_of_picture(step, it);
    given.loss = LOSS_GIVEN;
    rendering.training = 0;
    enum vw_status status = vw_gradient_create(&own, &it->objects, &given, &it->gradient);
    if (!status) status = create_on_step(step, &rendering, it);
    return !status ? create_on_picture(step, &rendering, it) : status;
}

static void destroy(struct vw_step_passes *step) {
    if (step->consistency) vw_gpu_objects_destroy(&step->consistency->objects);
    free(step->consistency);
    step->consistency = NULL;
}

// Creates the loss for a step that is otherwise complete, where it is on.
static enum vw_status create(struct vw_step_passes *step) {
    const struct vw_model *model = step->field->model;
    if (model->config->consistency_weight == 0.0) return VW_OK;
    struct vw_consistency_effect *it = step->consistency = vw_allocate(1, sizeof *it);
    if (!it) return VW_ERROR_MEMORY;
    it->objects.gpu = step->field->gpu;
    it->side = model->picture_side;
    it->ray_count = it->side * it->side;
    it->padded_rays = vw_model_pad_rays(model, it->ray_count);
    it->codes.slope = (float)(model->config->consistency_weight * step->rays / (4 * CODE4));
    enum vw_status status = create_picture_buffers(step, it);
    if (!status) status = create_passes(step, it);
    if (status) destroy(step);
    return status;
}

// ---- Its recording -------------------------------------------------------------------------------------------------

// Records the rays of the picture, after the step's own and before anything may mark the step.
static void record_rays(const struct vw_step_passes *step, struct vw_pass *const *passes,
                        struct vw_submission *submission, const struct vw_push_rays *rays) {
    (void)passes;
    const struct vw_consistency_effect *it = step->consistency;
    if (!it) return;
    struct vw_push_rays own = *rays;
    own.ray_count = it->ray_count;
    vw_submission_dispatch(submission, it->gradient.of_rays.generate, &own, sizeof own, it->padded_rays);
}

uint32_t vw_consistency_given_view(const struct vw_step_passes *step, uint64_t number) {
    uint32_t words[4];
    vw_random_words(step->field->model->seed, VW_RANDOM_GIVEN_PHOTO, number, 0, 0, words);
    uint64_t drawn = (uint64_t)words[0] << 32 | words[1];
    return vw_photo_order_view_of_step(step->photo_order, 1 + drawn % number);
}

static void record_forward(const struct vw_step_passes *step, struct vw_submission *submission,
                           const struct vw_push_samples *chunk) {
    const struct vw_gradient_passes *gradient = &step->consistency->gradient;
    vw_importance_record(step->field->model, &gradient->importance, submission, chunk);
    vw_volume_of(step->field->model)->kind->record_forward(step->field->model, &gradient->field, submission, chunk);
}

static void record_picture(const struct vw_step_passes *step, struct vw_submission *submission, vw_uint4 key) {
    const struct vw_consistency_effect *it = step->consistency;
    const struct vw_push_picture picture = {.side = it->side};
    for (uint32_t first = 0; first < it->padded_rays; first += vw_volume_step_of(step)->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, it->padded_rays, first, key);
        const struct vw_push_difference composite = {
            .first_ray = chunk.first_ray, .ray_count = chunk.ray_count, .key = key, .ahead = 1};
        record_forward(step, submission, &chunk);
        vw_submission_dispatch(submission, it->composite, &composite, sizeof composite, chunk.ray_count);
    }
    vw_submission_dispatch(submission, it->shrink, &picture, sizeof picture, THUMBNAIL_PIXELS);
    record_encoder_forward(it->see.passes, submission, 0);
    record_encoder_back(it->see.passes, &it->codes, submission);
    vw_submission_dispatch(submission, it->spread_colours, &picture, sizeof picture, it->padded_rays);
}

// Records the backward pass. The next chunk overwrites the last chunk's activations: with more than one chunk they are
// recomputed.
static void record_back(const struct vw_step_passes *step, struct vw_submission *submission, vw_uint4 key) {
    const struct vw_consistency_effect *it = step->consistency;
    for (uint32_t first = 0; first < it->padded_rays; first += vw_volume_step_of(step)->chunk_rays) {
        const struct vw_push_samples chunk = vw_gradient_chunk(step, it->padded_rays, first, key);
        if (it->padded_rays > vw_volume_step_of(step)->chunk_rays) record_forward(step, submission, &chunk);
        vw_gradient_record_back(step, &it->gradient, submission, &chunk);
    }
    vw_ray_passes_record_end(&it->gradient.of_rays, submission, it->padded_rays);
    vw_submission_dispatch(submission, it->add, NULL, 0, step->field->model->moved_columns);
}

// Records everything that remains, after the last of the step's own gradients.
static void record_consistency(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number) {
    if (!step->consistency) return;
    const vw_uint4 key = vw_model_key_of_step(step->field->model, number);
    record_encoder_forward(step->consistency->give.passes, submission, vw_consistency_given_view(step, number));
    record_picture(step, submission, key);
    record_back(step, submission, key);
}

// ---- Passes ---------------------------------------------------------------------------------------------------------

static void record_photo(const struct vw_model *model, struct vw_pass *const *passes, struct vw_submission *submission,
                         uint32_t view) {
    (void)model;
    record_encoder_forward(passes, submission, view);
}

static void record_gradient(const struct vw_step_passes *step, struct vw_pass *const *passes,
                            struct vw_submission *submission, const struct vw_push_rays *rays, uint64_t number) {
    (void)rays;
    record_encoder_back(passes, NULL, submission);
    record_consistency(step, submission, number);
}

const struct vw_effect_kind vw_effect_appearance_encoder = {
    .name = "appearance_encoder",
    .constant = VW_EFFECT_CONSTANT(appearance_encoder),
    .adjoint = VW_ADJOINT_REFUSES,
    .shaders = {[ENCODER_CONVOLVE] = &vw_shader_convolve_photo,
                [ENCODER_POOL] = &vw_shader_pool_photo,
                [ENCODER_SPREAD] = &vw_shader_spread_photo,
                [ENCODER_CONVOLVE_BACK] = &vw_shader_convolve_photo_back,
                [ENCODER_GRADIENT] = &vw_shader_gradient_photo},
    .photo_pass_count = ENCODER_SPREAD,
    .lay_out_columns = lay_out_columns,
    .initialise = initialise,
    .list_buffers = list_buffers,
    .fill = fill,
    .create = create,
    .destroy = destroy,
    .record_rays = record_rays,
    .record_photo = record_photo,
    .record_gradient = record_gradient,
};
