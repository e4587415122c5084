#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/renderers/splats/splats.h"

enum { BINDINGS_MAX = VW_SLOT_COUNT };

static enum vw_status create_buffers(struct vw_splat_drawing *d) {
    const struct vw_splat_room *room = &d->room;
    const struct vw_splat_specialization *s = &d->specialization;
    uint64_t sightings = (uint64_t)room->splats * room->views, rays = (uint64_t)room->tiles * s->side * s->side;
    uint64_t blocks = (room->pairs + s->sort_lanes * s->sort_keys - 1) / (s->sort_lanes * s->sort_keys);
    const struct vw_buffer_row tiles = {&d->tiles, "tiles", sizeof(struct vw_splat_tile) * room->listed_tiles};
    const struct vw_buffer_row buffers[] = {
        {&d->map, "tile_map", 4 * (uint64_t)room->cells},
        {&d->shapes, "splat_shapes", sizeof(struct vw_splat_shape) * sightings},
        {&d->sighting_pairs, "sighting_pairs", 4 * (sightings + 2)},
        {&d->seen, "splats_seen", sizeof(struct vw_splat_seen) * sightings},
        {&d->drawn, "splats_drawn", 16 * VW_SPLAT_DRAWN4 * sightings},
        {&d->state, "splat_state", sizeof(struct vw_splat_state)},
        {&d->pair_splats, "pair_splats", 4 * (uint64_t)room->pairs},
        {&d->sorted[0], "pairs", 8 * (uint64_t)room->pairs},
        {&d->sorted[1], "more_pairs", 8 * (uint64_t)room->pairs},
        {&d->counts, "sort_counts", 4 * blocks * s->sort_digits},
        {&d->ranges, "tile_ranges", sizeof(struct vw_tile_range) * room->tiles},
        {&d->colours, "splat_colours", 16 * rays},
    };
    enum vw_status status = vw_buffers_create(&d->objects, VW_BUFFER_UPLOAD, &tiles, 1);
    return !status ? vw_buffers_create(&d->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers)) : status;
}

// Writes the bindings of a drawing, with list `from` of the two sorted ones as the one to read, then the caller's.
// Returns how many there are.
static uint32_t bind(const struct vw_splat_drawing *d, const struct vw_splat_pass_params *params, uint32_t from,
                     struct vw_binding *bindings) {
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_SPLAT_TILES, .buffer = d->tiles},
        {.slot = VW_SLOT_TILE_MAP, .buffer = d->map},
        {.slot = VW_SLOT_SPLAT_SHAPES, .buffer = d->shapes},
        {.slot = VW_SLOT_SIGHTING_PAIRS, .buffer = d->sighting_pairs},
        {.slot = VW_SLOT_SPLATS_SEEN, .buffer = d->seen},
        {.slot = VW_SLOT_SPLATS_DRAWN, .buffer = d->drawn},
        {.slot = VW_SLOT_SPLAT_STATE, .buffer = d->state},
        {.slot = VW_SLOT_PAIR_SPLATS, .buffer = d->pair_splats},
        {.slot = VW_SLOT_SORT_COUNTS, .buffer = d->counts},
        {.slot = VW_SLOT_TILE_RANGES, .buffer = d->ranges},
        {.slot = VW_SLOT_COLOURS, .buffer = d->colours},
        {.slot = VW_SLOT_SORT_FROM, .buffer = d->sorted[from]},
        {.slot = VW_SLOT_SORT_TO, .buffer = d->sorted[1 - from]},
    };
    uint32_t count = 0;
    for (; count < VW_ARRAY_COUNT(own); count++) bindings[count] = own[count];
    for (uint32_t i = 0; i < params->binding_count; i++) bindings[count++] = params->bindings[i];
    return count;
}

// Returns the params that all passes of splats share.
static struct vw_pass_params common_params(const struct vw_splat_pass_params *params, const struct vw_binding *bindings,
                                           uint32_t count) {
    return (struct vw_pass_params){.specialization = (const uint32_t *)params->specialization,
                                   .specialization_count = VW_SPLAT_SPECIALIZATION_COUNT,
                                   .bindings = bindings,
                                   .binding_count = count,
                                   .role = params->role};
}

static enum vw_status create_passes(const struct vw_splat_pass_params *params, struct vw_splat_drawing *d) {
    struct vw_binding bindings[2][BINDINGS_MAX];
    struct vw_pass_params common[2]; // by which of the two lists is sorted from
    for (uint32_t from = 0; from < 2; from++)
        common[from] = common_params(params, bindings[from], bind(d, params, from, bindings[from]));
    const struct vw_pass_row first[] = {
        {&vw_shader_mark_tiles, &d->mark},
        {&vw_shader_project_splats, &d->project},
        {&vw_shader_place_pairs, &d->place},
        {params->depth ? &vw_shader_colour_splats_depth : &vw_shader_colour_splats, &d->colour},
        {&vw_shader_place_digits, &d->place_digits},
        {&vw_shader_count_digits, &d->count_digits[0]},
        {&vw_shader_scatter_pairs, &d->scatter[0]},
    };
    const struct vw_pass_row second[] = {
        {&vw_shader_emit_pairs, &d->emit}, // to the list that is sorted first
        {&vw_shader_count_digits, &d->count_digits[1]},
        {&vw_shader_scatter_pairs, &d->scatter[1]},
    };
    const struct vw_pass_row last = {&vw_shader_blend_tiles, &d->blend};
    enum vw_status status = vw_passes_create(&d->objects, &common[0], first, VW_ARRAY_COUNT(first));
    if (!status) status = vw_passes_create(&d->objects, &common[1], second, VW_ARRAY_COUNT(second));
    return !status ? vw_passes_create(&d->objects, &common[d->digits % 2], &last, 1) : status;
}

enum vw_status vw_splat_drawing_create(const struct vw_splat_pass_params *params, struct vw_splat_drawing *drawing) {
    *drawing = (struct vw_splat_drawing){.objects = {.gpu = params->gpu},
                                         .room = params->room,
                                         .specialization = *params->specialization,
                                         .digits = vw_splat_sort_digits(&params->room, params->specialization)};
    enum vw_status status = vw_splat_check_room(&params->room, params->specialization);
    if (!status) status = create_buffers(drawing);
    if (!status) status = create_passes(params, drawing);
    if (status) vw_splat_drawing_destroy(drawing);
    return status;
}

void vw_splat_drawing_destroy(struct vw_splat_drawing *drawing) {
    vw_gpu_objects_destroy(&drawing->objects);
    *drawing = (struct vw_splat_drawing){0};
}

static void record_sort(const struct vw_splat_drawing *d, struct vw_submission *submission,
                        struct vw_push_splats *push) {
    const uint64_t groups = offsetof(struct vw_splat_state, sort_groups);
    uint32_t digit_bits = vw_splat_digit_bits(&d->specialization);
    for (uint32_t digit = 0; digit < d->digits; digit++) {
        push->shift = digit * digit_bits;
        vw_submission_dispatch_indirect(submission, d->count_digits[digit % 2], push, sizeof *push, d->state, groups);
        vw_submission_dispatch(submission, d->place_digits, NULL, 0, 1);
        vw_submission_dispatch_indirect(submission, d->scatter[digit % 2], push, sizeof *push, d->state, groups);
    }
}

void vw_splat_drawing_record(const struct vw_splat_drawing *d, struct vw_submission *submission,
                             const struct vw_push_splats *of) {
    struct vw_push_splats push = *of;
    push.pair_capacity = d->room.pairs;
    const uint64_t seen = offsetof(struct vw_splat_state, seen_groups);
    vw_submission_dispatch(submission, d->mark, &push, sizeof push, d->room.tiles);
    vw_submission_dispatch_rows(submission, d->project, &push, sizeof push, push.count, push.view_count);
    vw_submission_dispatch(submission, d->place, &push, sizeof push, 1);
    vw_submission_dispatch_indirect(submission, d->emit, &push, sizeof push, d->state, seen);
    vw_submission_dispatch_indirect(submission, d->colour, &push, sizeof push, d->state, seen);
    record_sort(d, submission, &push);
    vw_submission_dispatch_indirect(submission, d->blend, &push, sizeof push, d->state,
                                    offsetof(struct vw_splat_state, tile_groups));
}

// ---- Gradients ------------------------------------------------------------------------------------------------------

static enum vw_status create_gradient_buffers(struct vw_splat_gradient *g) {
    const struct vw_splat_drawing *d = g->drawing;
    uint64_t rays = (uint64_t)d->room.tiles * d->specialization.side * d->specialization.side;
    uint64_t columns = vw_splat_param_bytes(&d->room);
    const struct vw_buffer_row buffers[] = {
        {&g->d_windows, "d_windows", d->specialization.ssim_weight > 0.0f ? 16 * rays : 0},
        {&g->d_colours, "d_colours", 16 * rays},
        {&g->d_pairs, "d_pairs", 16 * VW_SPLAT_PAIR4 * (uint64_t)d->room.pairs},
        {&g->d_splats, "d_splats", columns},
        {&g->moment1, "splat_moment1", d->specialization.run.momentum ? columns : 0},
        {&g->moment2, "splat_moment2", columns},
    };
    return vw_buffers_create(&g->objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
}

static enum vw_status create_gradient_passes(const struct vw_splat_pass_params *params, struct vw_splat_gradient *g) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = bind(g->drawing, params, g->drawing->digits % 2, bindings);
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_D_WINDOWS, .buffer = g->d_windows, .unused = !g->d_windows},
        {.slot = VW_SLOT_D_COLOURS, .buffer = g->d_colours},
        {.slot = VW_SLOT_D_PAIRS, .buffer = g->d_pairs},
        {.slot = VW_SLOT_D_SPLATS, .buffer = g->d_splats},
        {.slot = VW_SLOT_SPLAT_MOMENT1, .buffer = g->moment1, .unused = !g->moment1},
        {.slot = VW_SLOT_SPLAT_MOMENT2, .buffer = g->moment2},
    };
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(own); i++) bindings[count++] = own[i];
    const struct vw_pass_params common = common_params(params, bindings, count);
    const struct vw_pass_row passes[] = {
        {params->ray_effects ? &vw_shader_slope_pixels_effects : &vw_shader_slope_pixels, &g->slopes},
        {&vw_shader_blend_tiles_back, &g->blend_back},
        {&vw_shader_backward_splats, &g->backward},
        {&vw_shader_update_splats, &g->update},
    };
    const struct vw_pass_row windows = {
        params->ray_effects ? &vw_shader_compare_windows_effects : &vw_shader_compare_windows, &g->windows};
    enum vw_status status = g->d_windows ? vw_passes_create(&g->objects, &common, &windows, 1) : VW_OK;
    return !status ? vw_passes_create(&g->objects, &common, passes, VW_ARRAY_COUNT(passes)) : status;
}

enum vw_status vw_splat_gradient_create(const struct vw_splat_pass_params *params,
                                        const struct vw_splat_drawing *drawing, struct vw_splat_gradient *gradient) {
    *gradient = (struct vw_splat_gradient){.objects = {.gpu = params->gpu}, .drawing = drawing};
    enum vw_status status = create_gradient_buffers(gradient);
    if (!status) status = create_gradient_passes(params, gradient);
    if (status) vw_splat_gradient_destroy(gradient);
    return status;
}

void vw_splat_gradient_destroy(struct vw_splat_gradient *gradient) {
    vw_gpu_objects_destroy(&gradient->objects);
    *gradient = (struct vw_splat_gradient){0};
}

void vw_splat_gradient_record(const struct vw_splat_gradient *g, struct vw_submission *submission,
                              const struct vw_push_splats *push) {
    const struct vw_splat_drawing *d = g->drawing;
    uint64_t pixels = (uint64_t)d->specialization.side * d->specialization.side;
    if (g->windows)
        vw_submission_dispatch_indirect(submission, g->windows, push, sizeof *push, d->state,
                                        offsetof(struct vw_splat_state, square_groups));
    // Also rays that no tile of this photo has, whose loss of an earlier step would count.
    vw_submission_dispatch(submission, g->slopes, push, sizeof *push, d->room.tiles * pixels);
    vw_submission_dispatch_indirect(submission, g->blend_back, push, sizeof *push, d->state,
                                    offsetof(struct vw_splat_state, tile_groups));
    vw_submission_dispatch_indirect(submission, g->backward, push, sizeof *push, d->state,
                                    offsetof(struct vw_splat_state, seen_groups));
}

void vw_splat_update_record(const struct vw_splat_gradient *g, struct vw_submission *submission,
                            const struct vw_push_splat_update *push) {
    vw_submission_dispatch_indirect(submission, g->update, push, sizeof *push, g->drawing->state,
                                    offsetof(struct vw_splat_state, seen_groups));
}
