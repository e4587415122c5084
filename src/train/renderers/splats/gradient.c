#include "base/memory.h"
#include "gpu/shaders.h"
#include "train/renderers/splats/splats_private.h"

static enum vw_status create_buffers(struct vw_splat_gradient *g) {
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

static enum vw_status create_passes(const struct vw_splat_pass_params *params, struct vw_splat_gradient *g) {
    struct vw_binding bindings[VW_SLOT_COUNT];
    uint32_t count = vw_splat_drawing_bind(g->drawing, params, g->drawing->digits % 2, bindings);
    const struct vw_binding own[] = {
        {.slot = VW_SLOT_D_WINDOWS, .buffer = g->d_windows, .unused = !g->d_windows},
        {.slot = VW_SLOT_D_COLOURS, .buffer = g->d_colours},
        {.slot = VW_SLOT_D_PAIRS, .buffer = g->d_pairs},
        {.slot = VW_SLOT_D_SPLATS, .buffer = g->d_splats},
        {.slot = VW_SLOT_SPLAT_MOMENT1, .buffer = g->moment1, .unused = !g->moment1},
        {.slot = VW_SLOT_SPLAT_MOMENT2, .buffer = g->moment2},
    };
    for (uint32_t i = 0; i < VW_ARRAY_COUNT(own); i++) bindings[count++] = own[i];
    const struct vw_pass_params common = vw_splat_common(params, bindings, count);
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
    enum vw_status status = create_buffers(gradient);
    if (!status) status = create_passes(params, gradient);
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
