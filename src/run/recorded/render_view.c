#include "run/recorded/render_view.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "run/out_lock.h"
#include "train/trainer.h"

struct comparing {
    const struct vw_scene *scene;
    bool on_background; // transparent pixels show the background
    bool masked;        // mask files are obeyed
};

// Returns --to, or OUT/render_<view>.png without the view's folder and extension, unless another view has that name
// too: then with '_' for its slashes. Owned by the caller.
static char *name_target(const struct vw_render_params *params, const struct vw_scene *scene, uint32_t view) {
    if (params->to) return vw_copy_text(params->to);
    const char *whole = scene->views[view].name, *slash = strrchr(whole, '/');
    char *bare = vw_copy_text(slash ? slash + 1 : whole), *point = bare ? strrchr(bare, '.') : NULL;
    if (point && point != bare) *point = 0;
    bool taken = false;
    for (uint32_t v = 0; bare && v < scene->view_count; v++)
        taken |= v != view && (!strcmp(scene->views[v].name, bare) || vw_view_has_short_name(&scene->views[v], bare));
    char *name = bare ? vw_format_text("render_%s.png", taken ? whole : bare) : NULL;
    free(bare);
    for (char *next = name; next && *next; next++)
        if (*next == '/') *next = '_';
    char *path = name ? vw_path_join(params->out, name) : NULL;
    free(name);
    return path;
}

// ---- Photo and render side by side ----

// Computes the photo's colour as training sees it.
static void photo_colour(const struct comparing *comparing, const struct vw_image *photo, uint32_t x_px, uint32_t y_px,
                         float rgb[3]) {
    float rgba[4];
    vw_image_pixel(photo, x_px, y_px, rgba);
    float alpha = comparing->on_background ? rgba[3] : 1.0f;
    for (int c = 0; c < 3; c++) rgb[c] = alpha * rgba[c] + (1.0f - alpha) * comparing->scene->background[c];
}

// Fills `pair`, twice as wide as the view, if there is one, and takes the PSNR over the whole view.
static double compare(const struct comparing *comparing, const struct vw_view *view, const float *render, float *pair) {
    const struct vw_image *photo = &view->image;
    double squared_error = 0;
    uint64_t value_count = 0;
    for (uint32_t y = 0; y < photo->height_px; y++)
        for (uint32_t x = 0; x < photo->width_px; x++) {
            const float *rendered = render + 3 * ((size_t)y * photo->width_px + x);
            float colour[3];
            bool counts = comparing->masked ? vw_view_keeps(view, x, y) : vw_view_can_use(view, x, y);
            photo_colour(comparing, photo, x, y, colour);
            for (int c = 0; c < 3 && counts; c++) squared_error += pow((double)rendered[c] - colour[c], 2);
            if (counts) value_count += 3;
            if (!pair) continue;
            float *left = pair + 3 * ((size_t)y * 2 * photo->width_px + x);
            memcpy(left, colour, sizeof colour);
            memcpy(left + 3 * (size_t)photo->width_px, rendered, sizeof colour);
        }
    double mse = squared_error / (double)value_count;
    return vw_psnr_db(mse); // NaN when no pixel counts
}

static enum vw_status render_beside(const struct vw_rendering *rendering, bool only_render, const char *target,
                                    double *psnr_db) {
    const struct vw_view *view = &rendering->run.scene->views[rendering->view];
    const struct vw_recorded_run *run = &rendering->run;
    const struct comparing comparing = {run->scene, vw_effects_is_on(run->effects, run->effect_count, "background"),
                                        vw_effects_is_on(run->effects, run->effect_count, "masks")};
    uint32_t width_px = view->image.width_px, height_px = view->image.height_px;
    float *render = NULL;
    float *pair = only_render ? NULL : vw_allocate(2 * (size_t)width_px * height_px, 3 * sizeof *pair);
    if (!pair && !only_render) return VW_ERROR_MEMORY;
    enum vw_status status = vw_trainer_render(rendering->trainer, rendering->view, &render);
    if (!status) *psnr_db = compare(&comparing, view, render, pair);
    if (!status) status = vw_image_save(target, pair ? 2 * width_px : width_px, height_px, 3, pair ? pair : render);
    free(render);
    free(pair);
    return status;
}

static enum vw_status fill_result(const struct vw_render_params *params, const struct vw_rendering *rendering,
                                  struct vw_rendered_view *rendered) {
    const struct vw_view *view = &rendering->run.scene->views[rendering->view];
    rendered->view = vw_copy_text(view->name);
    rendered->image_path = name_target(params, rendering->run.scene, rendering->view);
    rendered->split = view->split;
    rendered->fitted = vw_effects_fit_views(rendering->run.effects, rendering->run.effect_count);
    return rendered->view && rendered->image_path ? VW_OK : VW_ERROR_MEMORY;
}

enum vw_status vw_render_view(const struct vw_render_params *params, struct vw_rendered_view *rendered) {
    struct vw_rendering rendering = {0};
    struct vw_out_lock *lock = NULL;
    enum vw_status status = vw_render_check_image(params->to);
    if (!status) status = vw_rendering_lock(params->out, params->to, &lock);
    if (!status) status = vw_rendering_open(params, &rendering);
    if (!status) status = fill_result(params, &rendering, rendered);
    if (!status) status = render_beside(&rendering, params->only_render, rendered->image_path, &rendered->psnr_db);
    if (!status && params->depth)
        status =
            vw_rendering_write_depth(&rendering, &rendering.run.scene->views[rendering.view], rendered->image_path);
    vw_rendering_close(&rendering);
    vw_out_lock_release(&lock);
    return status;
}

void vw_rendered_view_free(struct vw_rendered_view *rendered) {
    free(rendered->view);
    free(rendered->image_path);
    *rendered = (struct vw_rendered_view){0};
}
