// Splats' part of a step: squares of the photo, drawn as tiles, back to the splats that they show, which then move.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/device_photos.h"
#include "train/passes.h"
#include "train/photo_order.h"
#include "train/pixels.h"
#include "train/renderers/splats/splats.h"

// Rates of Kerbl et al. for each kind of number. Positions move in box edges, or in shares of them where cameras stand
// close together: how far these spread, as they have it, is ten times as much where they are far away.
static const double MEAN_RATE = 1.7e-4, SCALE_RATE = 5e-3, TURN_RATE = 1e-3, OPACITY_RATE = 2.5e-2,
                    COLOUR_RATE = 2.5e-3, HARMONICS_RATE = 1.25e-4;

struct vw_drawn_photo { // the view of a step, and how many tiles and squares of it were drawn
    uint32_t view, tiles, squares;
};

static uint32_t tile_pixels(const struct vw_splat_step *splats) {
    return splats->drawing.specialization.side * splats->drawing.specialization.side;
}

// Records the drawing of the pixels of the tiles that were listed.
static void record_draw(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                        const struct vw_pixel_draw *draw, uint32_t first_pixel) {
    const struct vw_splat_step *splats = vw_splat_step_of(step);
    struct vw_push_draw push = vw_device_photos_push(step->photos, view, draw, first_pixel, step->rays);
    push.side = splats->drawing.specialization.side;
    push.first_tile = first_pixel / tile_pixels(splats);
    push.listed = splats->photos[first_pixel / step->rays].tiles * tile_pixels(splats);
    vw_submission_dispatch(submission, step->draw_pixels, &push, sizeof push, step->rays);
}

static uint32_t draw_pixels(const struct vw_step_passes *step, struct vw_submission *submission, uint32_t view,
                            const struct vw_pixel_draw *draw, uint32_t first_pixel) {
    const struct vw_splat_step *splats = vw_splat_step_of(step);
    const struct vw_scene *scene = step->field->scene;
    uint32_t side = splats->drawing.specialization.side, each = tile_pixels(splats);
    struct vw_splat_tile *tiles = (struct vw_splat_tile *)vw_buffer_map(splats->drawing.tiles) + first_pixel / each;
    struct vw_drawn_photo *photo = &splats->photos[first_pixel / step->rays];
    *photo = (struct vw_drawn_photo){.view = view};
    photo->tiles = vw_pixels_draw_squares(scene, view, draw, VW_SPLAT_SQUARE, side, step->rays, splats->drawn);
    for (uint32_t i = 0; i < photo->tiles; i++) {
        struct vw_photo_tile drawn = splats->drawn[i];
        tiles[i] = vw_splat_tile_at(&splats->listed[view], view, drawn.left_px / side, drawn.top_px / side);
        photo->squares += drawn.left_px % VW_SPLAT_SQUARE == 0 && drawn.top_px % VW_SPLAT_SQUARE == 0;
        if (!step->photos) vw_pixels_take_tile(scene, view, draw->masks, drawn, side, step->drawn + i * each);
    }
    for (uint32_t i = photo->tiles * each; !step->photos && i < step->rays; i++)
        step->drawn[i] = (struct vw_pixel){.view = view};
    if (step->photos) record_draw(step, submission, view, draw, first_pixel);
    return step->rays; // its tiles say which of them
}

static enum vw_status list_views(struct vw_step_passes *step, uint32_t side) {
    struct vw_splat_step *splats = vw_splat_step_of(step);
    const struct vw_scene *scene = step->field->scene;
    struct vw_splat_view *views = vw_allocate(scene->view_count, sizeof *views);
    splats->listed = views;
    if (!views) return VW_ERROR_MEMORY;
    bool lens = step->field->model->specialization.effect_distortion != DISTORTION_NONE;
    for (uint32_t i = 0; i < scene->view_count; i++) {
        views[i] = vw_splat_view_of(i, 0, &scene->views[i].camera, lens, side);
        uint32_t cells = views[i].columns * views[i].rows;
        if (vw_model_trains_on(step->field->model, scene, i) && cells > splats->cells) splats->cells = cells;
    }
    uint64_t bytes = sizeof *views * scene->view_count;
    const struct vw_buffer_row row = {&splats->views, "splat_views", bytes};
    enum vw_status status = vw_buffers_create(&step->objects, VW_BUFFER_DEVICE, &row, 1);
    if (!status) status = vw_buffer_write(splats->views, 0, views, bytes);
    return status;
}

static enum vw_status create_step_buffers(struct vw_step_passes *step) {
    struct vw_splat_specialization s;
    vw_splats_pass_params(step->field, &step->field->model->specialization, &s);
    struct vw_splat_step *splats = step->of_renderer = vw_allocate(1, sizeof *splats);
    if (!splats) return VW_ERROR_MEMORY;
    uint64_t pixels = vw_buffer_size_bytes(step->pixels) / sizeof(struct vw_pixel);
    splats->photos = vw_allocate(pixels / step->rays, sizeof *splats->photos);
    splats->drawn = vw_allocate(step->rays / (s.side * s.side), sizeof *splats->drawn);
    return splats->photos && splats->drawn ? list_views(step, s.side) : VW_ERROR_MEMORY;
}

static enum vw_status create_step_passes(struct vw_step_passes *step) {
    struct vw_splat_step *splats = vw_splat_step_of(step);
    const struct vw_model *model = step->field->model;
    struct vw_splat_specialization s;
    struct vw_splat_pass_params params = vw_splats_pass_params(step->field, &model->specialization, &s);
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = 0, each = s.side * s.side;
    vw_step_bind(step, bindings, &count); // its first binding is the one of flags
    const struct vw_pass_params common = vw_pass_params_of(&model->specialization, bindings, count, NULL);
    enum vw_status status =
        vw_ray_passes_create(model, &step->objects, &common, &model->specialization, &splats->of_rays);
    bindings[0] = vw_step_overflow_binding(step, VW_OVERFLOW_RENDERER);
    bindings[count++] = vw_splats_binding(step->field);
    bindings[count++] = (struct vw_binding){.slot = VW_SLOT_SPLAT_VIEWS, .buffer = splats->views};
    params.room.views = 1;
    params.room.tiles = step->rays / each;
    params.room.listed_tiles = (uint32_t)(vw_buffer_size_bytes(step->pixels) / sizeof(struct vw_pixel) / each);
    params.room.cells = splats->cells;
    params.room.pairs = vw_splats_pair_room(step->field, &params.room);
    params.bindings = bindings;
    params.binding_count = count;
    params.ray_effects = vw_model_has_ray_effects(model, &model->specialization);
    if (!status) status = vw_splat_drawing_create(&params, &splats->drawing);
    if (!status) status = vw_step_create_draw(step, &vw_shader_draw_pixels_tiles, splats->drawing.tiles);
    return !status ? vw_splat_gradient_create(&params, &splats->drawing, &splats->gradient) : status;
}

static void destroy_step(struct vw_step_passes *step) {
    struct vw_splat_step *splats = vw_splat_step_of(step);
    vw_splat_gradient_destroy(&splats->gradient);
    vw_splat_drawing_destroy(&splats->drawing);
    free(splats->listed);
    free(splats->photos);
    free(splats->drawn);
}

static void training_state(const struct vw_step_passes *step, struct vw_buffer **buffers, uint32_t *count) {
    const struct vw_splat_gradient *gradient = &vw_splat_step_of(step)->gradient;
    if (gradient->moment1) buffers[(*count)++] = gradient->moment1;
    buffers[(*count)++] = gradient->moment2;
}

// Returns the degree of the harmonics in use: one more in every epoch, but all at once of a file's splats.
static uint32_t degree_at(const struct vw_step_passes *step, uint64_t number) {
    const struct vw_splat_model *splats = vw_splat_model_of(step->field->model);
    uint32_t epoch = vw_photo_order_epoch_of_step(step->photo_order, number);
    return step->field->model->config->initial[0] || epoch > splats->degree ? splats->degree : epoch;
}

static void record_gradients(const struct vw_step_passes *step, struct vw_submission *submission, uint64_t number,
                             const struct vw_push_rays *rays) {
    const struct vw_model *model = step->field->model;
    const struct vw_splat_step *splats = vw_splat_step_of(step);
    struct vw_push_splats push = vw_splats_push(model);
    push.degree = degree_at(step, number);
    struct vw_drawn_photo photo = splats->photos[rays->first_pixel / step->rays];
    push.first_view = photo.view;
    push.tile_count = photo.tiles;
    push.squares = photo.squares;
    push.first_tile = rays->first_pixel / tile_pixels(splats);
    push.walked_tiles = push.tile_count <= VW_SPLAT_WALKED_TILES_MAX ? push.tile_count : 0;
    push.key = rays->key;
    vw_submission_dispatch(submission, splats->of_rays.generate, rays, sizeof *rays, step->padded_rays);
    vw_effects_record_rays(model, &step->effects, step, submission, rays);
    vw_splat_drawing_record(&splats->drawing, submission, &push);
    vw_splat_gradient_record(&splats->gradient, submission, &push);
    vw_ray_passes_record_end(&splats->of_rays, submission, step->padded_rays);
    vw_effects_record_gradient(model, &step->effects, step, submission, rays, number);
}

static void record_update(const struct vw_step_passes *step, struct vw_submission *submission,
                          struct vw_push_update update) {
    const struct vw_splat_model *splats = vw_splat_model_of(step->field->model);
    const struct vw_push_splat_update push = {.stride = splats->count,
                                              .columns = VW_SPLAT_COLUMNS(degree_at(step, update.step_low)),
                                              .mean = (float)(splats->extent * MEAN_RATE / VW_SPLAT_RATE_UNIT),
                                              .scale = (float)(SCALE_RATE / VW_SPLAT_RATE_UNIT),
                                              .turn = (float)(TURN_RATE / VW_SPLAT_RATE_UNIT),
                                              .opacity = (float)(OPACITY_RATE / VW_SPLAT_RATE_UNIT),
                                              .colour = (float)(COLOUR_RATE / VW_SPLAT_RATE_UNIT),
                                              .harmonics = (float)(HARMONICS_RATE / VW_SPLAT_RATE_UNIT),
                                              .extra = update.extra,
                                              .adam = update.adam};
    vw_splat_update_record(&vw_splat_step_of(step)->gradient, submission, &push);
}

const struct vw_renderer_step vw_splats_renderer_step = {
    .draw_pixels = draw_pixels,
    .create_buffers = create_step_buffers,
    .create_passes = create_step_passes,
    .destroy = destroy_step,
    .training_state = training_state,
    .record_gradients = record_gradients,
    .record_update = record_update,
};
