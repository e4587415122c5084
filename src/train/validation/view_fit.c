#include "train/validation/view_fit.h"

#include "base/memory.h"
#include "gpu/shaders.h"

struct vw_pixel_columns vw_view_fit_left_half(const struct vw_scene *scene, uint32_t view) {
    return (struct vw_pixel_columns){0, scene->views[view].image.width_px / 2};
}

struct vw_pixel_columns vw_view_fit_right_half(const struct vw_scene *scene, uint32_t view) {
    uint32_t width = scene->views[view].image.width_px;
    return (struct vw_pixel_columns){width - width / 2, width};
}

void vw_view_fit_choose_pixels(const struct vw_scene *scene, const uint32_t *views, uint32_t count, uint64_t seed,
                               bool masks, uint32_t side, const struct vw_ray_range *scored, struct vw_pixel *pixels,
                               uint32_t *written, struct vw_ray_range *ranges) {
    for (uint32_t i = 0; i < count; i++) {
        struct vw_pixel_columns columns = vw_view_fit_left_half(scene, views[i]);
        uint32_t wanted = scored[i].count < VIEW_FIT_RAYS_MAX ? scored[i].count : VIEW_FIT_RAYS_MAX;
        uint32_t taken =
            vw_pixels_stratify_squares(scene, views[i], columns, seed, masks, side, wanted, pixels + *written);
        ranges[i] = (struct vw_ray_range){.first = *written, .count = taken};
        *written += taken;
    }
}

enum vw_status vw_view_fit_create(const struct vw_evaluator *evaluator, struct vw_gpu_objects *objects,
                                  const struct vw_ray_range *ranges, uint32_t count, struct vw_view_fit *fit) {
    const struct vw_buffer_row buffers[] = {{&fit->ranges, "fit_ranges", sizeof *ranges * count},
                                            {&fit->fits, "fits", sizeof(struct vw_appearance) * count}};
    enum vw_status status = vw_buffers_create(objects, VW_BUFFER_DEVICE, buffers, VW_ARRAY_COUNT(buffers));
    if (!status) status = vw_buffer_write(fit->ranges, 0, ranges, sizeof *ranges * count);
    const struct vw_binding bindings[] = {
        {.slot = VW_SLOT_RAYS, .buffer = evaluator->rays},
        {.slot = VW_SLOT_COLOURS, .buffer = evaluator->colours},
        {.slot = VW_SLOT_VAL_VIEWS, .buffer = fit->ranges},
        {.slot = VW_SLOT_FITS, .buffer = fit->fits},
    };
    const struct vw_pass_params params = {.bindings = bindings, .binding_count = VW_ARRAY_COUNT(bindings)};
    return !status ? vw_pass_create_of(objects, &params, &vw_shader_fit_views, &fit->pass) : status;
}

void vw_view_fit_record(const struct vw_view_fit *fit, struct vw_submission *submission, uint32_t view_count) {
    struct vw_push_reduce push = {.count = view_count};
    if (fit->pass) vw_submission_dispatch(submission, fit->pass, &push, sizeof push, 64ull * view_count);
}
