#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/renderers/splats/splats_private.h"

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

uint32_t vw_splat_drawing_bind(const struct vw_splat_drawing *d, const struct vw_splat_pass_params *params,
                               uint32_t from, struct vw_binding *bindings) {
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

struct vw_pass_params vw_splat_common(const struct vw_splat_pass_params *params, const struct vw_binding *bindings,
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
        common[from] = vw_splat_common(params, bindings[from], vw_splat_drawing_bind(d, params, from, bindings[from]));
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
