// Splats' part of an evaluator: the pixels that it looks at as tiles of several views, a few views in one drawing.
// Pixels come in any order; the host sorts them by tiles, and show_pixels puts their colours back into that order.
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/effects/effects.h"
#include "train/passes.h"
#include "train/renderers/splats/splats.h"

enum {
    TILES_MOST = 1024,        // tiles of one drawing
    SIGHTINGS_MOST = 1 << 18, // splats times views of one drawing, if it has more than one view
    CELLS_MOST = 1 << 22,     // likewise cells of its views: 16 MiB
};

// One pixel on its way to a tile.
struct sorted_pixel {
    uint32_t view, row, column, pixel, ray; // ray: of the tile, then of the drawing
};

struct vw_shown_pixel {
    uint32_t pixel, ray;
};

struct vw_drawn_part {
    struct vw_push_splats splats;
    struct vw_push_shown shown;
};

static enum vw_status create_evaluation(struct vw_evaluator *evaluator) {
    const struct vw_radiance_field *field = evaluator->field;
    const struct vw_specialization specialization = vw_effects_specialise_validation(field->model);
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_PIXELS, .buffer = evaluator->pixels},
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
    };
    uint32_t count = 2;
    vw_field_bind(field, false, bindings, &count);
    const struct vw_effect_buffers of_effects = {field->params, field->effect_buffers, NULL};
    vw_effects_bind(field->model, &of_effects, bindings, &count);
    const struct vw_pass_params common = vw_pass_params_of(&specialization, bindings, count, evaluator_role);
    struct vw_splat_evaluation *splats = evaluator->of_renderer = vw_allocate(1, sizeof *splats);
    if (!splats) return VW_ERROR_MEMORY;
    splats->objects.gpu = field->gpu;
    splats->pixels = vw_allocate(evaluator->ray_count, sizeof *splats->pixels);
    if (!splats->pixels) return VW_ERROR_MEMORY;
    return vw_pass_create_of(&evaluator->objects, &common, &vw_shader_generate_rays, &evaluator->generate);
}

static void destroy_sized(struct vw_splat_evaluation *splats) {
    struct vw_gpu *gpu = splats->objects.gpu;
    vw_gpu_objects_destroy(&splats->objects);
    vw_splat_drawing_destroy(&splats->drawing);
    splats->objects.gpu = gpu;
    splats->view_list = splats->shown = NULL;
}

static void destroy_evaluation(struct vw_evaluator *evaluator) {
    struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    destroy_sized(splats);
    free(splats->parts);
    free(splats->views);
    free(splats->tiles);
    free(splats->pixels);
}

// ---- From pixels to tiles -------------------------------------------------------------------------------------------

static int by_tile(const void *one, const void *other) {
    const struct sorted_pixel *a = one, *b = other;
    const uint32_t x[] = {a->view, a->row, a->column, a->pixel}, y[] = {b->view, b->row, b->column, b->pixel};
    for (size_t i = 0; i < VW_ARRAY_COUNT(x); i++)
        if (x[i] != y[i]) return x[i] < y[i] ? -1 : 1;
    return 0;
}

static struct sorted_pixel *sort_pixels(const struct vw_pixel *pixels, uint32_t count, uint32_t side) {
    struct sorted_pixel *sorted = vw_allocate(count, sizeof *sorted);
    if (!sorted) return NULL;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t x = (uint32_t)pixels[i].x_px, y = (uint32_t)pixels[i].y_px;
        sorted[i] = (struct sorted_pixel){pixels[i].view, y / side, x / side, i, y % side * side + x % side};
    }
    qsort(sorted, count, sizeof *sorted, by_tile);
    return sorted;
}

static enum vw_status begin_part(const struct vw_model *model, struct vw_splat_evaluation *splats) {
    enum vw_status status =
        vw_grow((void **)&splats->parts, &splats->part_capacity, splats->part_count + 1, sizeof *splats->parts);
    if (status) return status;
    struct vw_drawn_part *part = &splats->parts[splats->part_count++];
    *part = (struct vw_drawn_part){.splats = vw_splats_push(model), .shown.first = splats->pixel_count};
    part->splats.first_view = splats->view_count;
    part->splats.view_count = 0;
    part->splats.first_tile = splats->tile_count;
    return VW_OK;
}

static uint32_t cells_of_part(const struct vw_splat_evaluation *splats, const struct vw_drawn_part *part) {
    if (!part->splats.view_count) return 0;
    const struct vw_splat_view *last = &splats->views[splats->view_count - 1];
    return last->first_cell + last->columns * last->rows;
}

// Returns whether the last part has no room for a view of so many cells.
static bool is_full_for(const struct vw_splat_evaluation *splats, uint32_t cells) {
    const struct vw_drawn_part *last = splats->part_count ? &splats->parts[splats->part_count - 1] : NULL;
    if (!last || last->splats.tile_count == TILES_MOST) return true;
    uint64_t sightings = (uint64_t)last->splats.count * (last->splats.view_count + 1);
    return last->splats.view_count > 0 &&
           (sightings > SIGHTINGS_MOST || cells_of_part(splats, last) + cells > CELLS_MOST);
}

// Appends a view to the last part, or to another one if that is full.
static enum vw_status begin_view(const struct vw_radiance_field *field, uint32_t view, uint32_t side,
                                 struct vw_splat_evaluation *splats) {
    bool lens = field->model->specialization.effect_distortion != DISTORTION_NONE;
    struct vw_splat_view own = vw_splat_view_of(view, 0, &vw_field_view(field, view)->camera, lens, side);
    enum vw_status status = is_full_for(splats, own.columns * own.rows) ? begin_part(field->model, splats) : VW_OK;
    if (!status)
        status =
            vw_grow((void **)&splats->views, &splats->view_capacity, splats->view_count + 1, sizeof *splats->views);
    if (status) return status;
    struct vw_drawn_part *part = &splats->parts[splats->part_count - 1];
    own.first_cell = cells_of_part(splats, part);
    splats->views[splats->view_count++] = own;
    part->splats.view_count++;
    return VW_OK;
}

static enum vw_status begin_tile(const struct sorted_pixel *pixel, struct vw_splat_evaluation *splats) {
    enum vw_status status =
        vw_grow((void **)&splats->tiles, &splats->tile_capacity, splats->tile_count + 1, sizeof *splats->tiles);
    if (status) return status;
    uint32_t view = splats->view_count - 1;
    splats->tiles[splats->tile_count++] = vw_splat_tile_at(&splats->views[view], view, pixel->column, pixel->row);
    splats->parts[splats->part_count - 1].splats.tile_count++;
    return VW_OK;
}

static bool is_full(const struct vw_splat_evaluation *splats) {
    return splats->parts[splats->part_count - 1].splats.tile_count == TILES_MOST;
}

// Notes which tiles of its drawing are a view's, where they are few.
static void end_view(struct vw_splat_evaluation *splats) {
    const struct vw_drawn_part *part = &splats->parts[splats->part_count - 1];
    struct vw_splat_view *view = &splats->views[splats->view_count - 1];
    uint32_t end = splats->tile_count, first = end;
    while (first > part->splats.first_tile && splats->tiles[first - 1].view == splats->view_count - 1) first--;
    if (end - first > VW_SPLAT_WALKED_TILES_MAX) return;
    view->first_tile = first - part->splats.first_tile;
    view->tiles = end - first;
}

// Lists parts, views, tiles and pixels.
static enum vw_status list_parts(const struct vw_radiance_field *field, const struct sorted_pixel *sorted,
                                 uint32_t count, uint32_t side, struct vw_splat_evaluation *splats) {
    enum vw_status status = VW_OK;
    splats->part_count = splats->view_count = splats->tile_count = splats->pixel_count = 0;
    for (uint32_t i = 0; i < count && !status; i++) {
        const struct sorted_pixel *own = &sorted[i], *before = i ? &sorted[i - 1] : NULL;
        bool other_view = !before || own->view != before->view;
        bool other_tile = other_view || own->row != before->row || own->column != before->column;
        bool new_view = other_view || (other_tile && is_full(splats));
        if (new_view && before) end_view(splats);
        if (new_view) status = begin_view(field, own->view, side, splats);
        if (!status && other_tile) status = begin_tile(own, splats);
        if (status) return status;
        struct vw_drawn_part *part = &splats->parts[splats->part_count - 1];
        uint32_t ray = (part->splats.tile_count - 1) * side * side + own->ray;
        splats->pixels[splats->pixel_count++] = (struct vw_shown_pixel){own->pixel, ray};
        part->shown.count++;
        struct vw_splat_room *needed = &splats->needed;
        uint32_t cells = cells_of_part(splats, part);
        if (needed->views < part->splats.view_count) needed->views = part->splats.view_count;
        if (needed->tiles < part->splats.tile_count) needed->tiles = part->splats.tile_count;
        if (needed->cells < cells) needed->cells = cells;
    }
    if (count && !status) end_view(splats);
    return status;
}

// ---- On the device --------------------------------------------------------------------------------------------------

static uint32_t power_of_two_from(uint32_t value) {
    uint32_t power = 1;
    while (power < value) power *= 2;
    return power;
}

static enum vw_status create_show(const struct vw_evaluator *evaluator, const struct vw_specialization *run) {
    struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    const struct vw_radiance_field *field = evaluator->field;
    struct vw_binding bindings[VW_SLOT_COUNT] = {
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
        {.slot = VW_SLOT_BLENDED, .buffer = splats->drawing.colours},
        {.slot = VW_SLOT_SHOWN, .buffer = splats->shown},
        {.slot = VW_SLOT_SPLAT_STATE, .buffer = splats->drawing.state},
        {.slot = VW_SLOT_COLOURS, .buffer = evaluator->colours},
    };
    uint32_t count = 5;
    const struct vw_effect_buffers of_effects = {field->params, field->effect_buffers, NULL};
    vw_effects_bind(field->model, &of_effects, bindings, &count);
    const struct vw_pass_params common = vw_pass_params_of(run, bindings, count, evaluator_role);
    return vw_pass_create_of(&splats->objects, &common,
                             evaluator->depth ? &vw_shader_show_pixels_depth : &vw_shader_show_pixels, &splats->show);
}

static enum vw_status create_sized(const struct vw_evaluator *evaluator, const struct vw_splat_pass_params *sized) {
    struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    const struct vw_buffer_row lists[] = {
        {&splats->view_list, "splat_views", sizeof *splats->views * power_of_two_from(splats->view_count)},
        {&splats->shown, "shown_pixels", sizeof *splats->pixels * evaluator->ray_count},
    };
    enum vw_status status = vw_buffers_create(&splats->objects, VW_BUFFER_UPLOAD, lists, VW_ARRAY_COUNT(lists));
    const struct vw_binding bindings[] = {
        vw_splats_binding(evaluator->field),
        {.slot = VW_SLOT_CAMERAS, .buffer = evaluator->field->cameras},
        {.slot = VW_SLOT_SPLAT_VIEWS, .buffer = splats->view_list},
    };
    struct vw_splat_pass_params params = *sized;
    params.role = evaluator_role;
    params.depth = evaluator->depth;
    params.bindings = bindings;
    params.binding_count = VW_ARRAY_COUNT(bindings);
    if (!status) status = vw_splat_drawing_create(&params, &splats->drawing);
    if (!status) status = create_show(evaluator, &params.specialization->run);
    if (status) destroy_sized(splats); // so that has_room() finds none
    return status;
}

static bool has_room(const struct vw_splat_evaluation *splats) {
    const struct vw_splat_room *room = &splats->drawing.room, *needed = &splats->needed;
    return splats->view_list && room->views >= needed->views && room->tiles >= needed->tiles &&
           room->cells >= needed->cells && room->listed_tiles >= splats->tile_count &&
           vw_buffer_size_bytes(splats->view_list) >= sizeof *splats->views * splats->view_count;
}

static enum vw_status make_room(const struct vw_evaluator *evaluator, struct vw_splat_pass_params *params) {
    struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    if (has_room(splats)) return VW_OK;
    destroy_sized(splats);
    params->room.views = splats->needed.views;
    params->room.cells = splats->needed.cells;
    params->room.tiles = power_of_two_from(splats->needed.tiles);
    params->room.listed_tiles = power_of_two_from(splats->tile_count);
    params->room.pairs = vw_splats_pair_room(evaluator->field, &params->room);
    return create_sized(evaluator, params);
}

static enum vw_status take_pixels(struct vw_evaluator *evaluator, const struct vw_pixel *pixels, uint32_t count) {
    struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    const struct vw_specialization run = vw_effects_specialise_validation(evaluator->field->model);
    struct vw_splat_specialization s;
    struct vw_splat_pass_params params = vw_splats_pass_params(evaluator->field, &run, &s);
    struct sorted_pixel *sorted = sort_pixels(pixels, count, s.side);
    if (!sorted) return VW_ERROR_MEMORY;
    enum vw_status status = list_parts(evaluator->field, sorted, count, s.side, splats);
    free(sorted);
    if (!status) status = make_room(evaluator, &params);
    if (status || !count) return status;
    memcpy(vw_buffer_map(splats->drawing.tiles), splats->tiles, splats->tile_count * sizeof *splats->tiles);
    memcpy(vw_buffer_map(splats->view_list), splats->views, splats->view_count * sizeof *splats->views);
    memcpy(vw_buffer_map(splats->shown), splats->pixels, splats->pixel_count * sizeof *splats->pixels);
    return VW_OK;
}

static void record_evaluation(const struct vw_evaluator *evaluator, struct vw_submission *submission) {
    const struct vw_splat_evaluation *splats = vw_splat_evaluation_of(evaluator);
    for (uint32_t i = 0; i < splats->part_count; i++) {
        const struct vw_push_shown *shown = &splats->parts[i].shown;
        vw_splat_drawing_record(&splats->drawing, submission, &splats->parts[i].splats);
        vw_submission_dispatch(submission, splats->show, shown, sizeof *shown, shown->count);
    }
}

const struct vw_renderer_evaluation vw_splats_renderer_evaluation = {
    .create = create_evaluation,
    .destroy = destroy_evaluation,
    .take_pixels = take_pixels,
    .record = record_evaluation,
};
