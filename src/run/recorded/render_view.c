#include "run/recorded/render_view.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "run/out_lock.h"
#include "run/recorded/recorded_run.h"
#include "train/trainer.h"
#include "viewworth/train.h"

struct rendering {
    const struct vw_render_params *params;
    struct vw_recorded_run run;
    bool on_background; // transparent pixels show the background
    bool masked;        // mask files are obeyed
    bool fitted;        // validation fits a gain and a bias to each view; a render has none
    struct vw_trainer *trainer;
};

// ---- Opening -------------------------------------------------------------------------------------------------------

static enum vw_status check_target(const char *to) {
    const char *extension = to ? strrchr(to, '.') : NULL;
    if (!to || (extension && (strcasecmp(extension, ".png") == 0 || strcasecmp(extension, ".exr") == 0))) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--to %s: the name must end in .png or .exr", to);
}

static enum vw_status refuse_folds(const char *out) {
    if (vw_file_exists_inside(out, "ledger.db") || !vw_file_exists_inside(out, "fold-1/ledger.db")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE,
                   "%s: holds the folds of value --kfold; render from one of them, for example %s/fold-1 "
                   "(%s/fold-K/val.txt lists the photos that fold K validates)",
                   out, out, out);
}

static enum vw_status open_rendering(const struct vw_render_params *params, struct rendering *rendering) {
    *rendering = (struct rendering){.params = params};
    enum vw_status status = refuse_folds(params->out);
    if (!status) status = vw_recorded_open(params->out, &rendering->run);
    if (!status) status = vw_recorded_open_scene(&rendering->run, params->device);
    if (!status) status = vw_recorded_load_field(&rendering->run, &rendering->trainer);
    rendering->on_background = vw_effects_is_on(rendering->run.effects, rendering->run.effect_count, "background");
    rendering->masked = vw_effects_is_on(rendering->run.effects, rendering->run.effect_count, "masks");
    rendering->fitted = vw_effects_fit_views(rendering->run.effects, rendering->run.effect_count);
    return status;
}

static void close_rendering(struct rendering *rendering) {
    vw_trainer_destroy(&rendering->trainer);
    vw_recorded_close(&rendering->run);
}

// ---- Choosing the view and naming the image ------------------------------------------------------------------------

static bool find_by_name(const struct vw_scene *scene, const char *name, uint32_t *view) {
    for (*view = 0; *view < scene->view_count; ++*view)
        if (strcmp(scene->views[*view].name, name) == 0) return true;
    return false;
}

// Tells whether a view has this name without its folder, its extension or both. (An entire name is found before.)
static bool has_short_name(const char *name, const char *wanted) {
    size_t length = strlen(name), wanted_length = strlen(wanted);
    const char *slash = strrchr(name, '/'), *point = strrchr(slash ? slash : name, '.');
    size_t ends[] = {length, point ? (size_t)(point - name) : length};
    for (size_t i = 0; i < VW_ARRAY_COUNT(ends); i++) {
        if (!wanted_length || ends[i] < wanted_length) continue;
        const char *begin = name + ends[i] - wanted_length;
        if ((begin == name || begin[-1] == '/') && !strncmp(begin, wanted, wanted_length)) return true;
    }
    return false;
}

// Finds the only view with this short name. VW_ERROR_USAGE lists the first three if there are more; without one, `view`
// stays.
static enum vw_status find_by_short_name(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    uint32_t places[3] = {0}, count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (has_short_name(scene->views[v].name, wanted) && count++ < VW_ARRAY_COUNT(places)) places[count - 1] = v;
    if (count == 1) *view = places[0];
    if (count < 2) return VW_OK;
    bool third = count >= VW_ARRAY_COUNT(places);
    return vw_fail(VW_ERROR_USAGE, "--view %s: is short for %u photos: %s, %s%s%s%s; write the name out", wanted, count,
                   scene->views[places[0]].name, scene->views[places[1]].name, third ? ", " : "",
                   third ? scene->views[places[2]].name : "", count > VW_ARRAY_COUNT(places) ? ", ..." : "");
}

static bool find_by_place(const struct vw_scene *scene, unsigned long long place, uint32_t *view) {
    for (*view = 0; *view < scene->view_count; ++*view)
        if (scene->views[*view].split == VW_SPLIT_VAL && place-- == 0) return true;
    return false;
}

static enum vw_status choose_view(const struct rendering *rendering, uint32_t *view) {
    const struct vw_scene *scene = rendering->run.scene;
    const char *wanted = rendering->params->view ? rendering->params->view : "0";
    uint32_t at_place = 0;
    enum vw_status status = VW_OK;
    if (find_by_name(scene, wanted, view)) return VW_OK;
    *view = UINT32_MAX;
    char *end = NULL;
    unsigned long long place = isdigit((unsigned char)wanted[0]) ? strtoull(wanted, &end, 10) : 0;
    bool padded = wanted[0] == '0' && wanted[1]; // "0094" is a name before it is a place
    bool is_place = end && !*end && find_by_place(scene, place, &at_place);
    if (is_place && !padded) *view = at_place;
    else status = find_by_short_name(scene, wanted, view);
    if (!status && *view == UINT32_MAX && is_place) *view = at_place;
    if (status || *view != UINT32_MAX) return status;
    return vw_fail(VW_ERROR_USAGE,
                   "--view %s: no photo of this name, nor a place among the %u validation photos (from 0)", wanted,
                   scene->split_count[VW_SPLIT_VAL]);
}

// Returns --to, or OUT/render_<view>.png without the view's folder and extension, unless another view has that name
// too: then with '_' for its slashes. Owned by the caller.
static char *name_target(const struct rendering *rendering, uint32_t view) {
    if (rendering->params->to) return vw_copy_text(rendering->params->to);
    const struct vw_scene *scene = rendering->run.scene;
    const char *whole = scene->views[view].name, *slash = strrchr(whole, '/');
    char *bare = vw_copy_text(slash ? slash + 1 : whole), *point = bare ? strrchr(bare, '.') : NULL;
    if (point && point != bare) *point = 0;
    bool taken = false;
    for (uint32_t v = 0; bare && v < scene->view_count; v++)
        taken |= v != view && (!strcmp(scene->views[v].name, bare) || has_short_name(scene->views[v].name, bare));
    char *name = bare ? vw_format_text("render_%s.png", taken ? whole : bare) : NULL;
    free(bare);
    for (char *next = name; next && *next; next++)
        if (*next == '/') *next = '_';
    char *path = name ? vw_path_join(rendering->params->out, name) : NULL;
    free(name);
    return path;
}

// ---- Photo and render side by side ---------------------------------------------------------------------------------

// Computes the photo's colour as training sees it.
static void photo_colour(const struct rendering *rendering, const struct vw_image *photo, uint32_t x_px, uint32_t y_px,
                         float rgb[3]) {
    float rgba[4];
    vw_image_pixel(photo, x_px, y_px, rgba);
    float alpha = rendering->on_background ? rgba[3] : 1.0f;
    for (int c = 0; c < 3; c++) rgb[c] = alpha * rgba[c] + (1.0f - alpha) * rendering->run.scene->background[c];
}

// Fills `pair`, twice as wide as the view, and takes the PSNR over the whole view.
static double compare(const struct rendering *rendering, const struct vw_view *view, const float *render, float *pair) {
    const struct vw_image *photo = &view->image;
    double squared_error = 0;
    uint64_t value_count = 0;
    for (uint32_t y = 0; y < photo->height_px; y++)
        for (uint32_t x = 0; x < photo->width_px; x++) {
            const float *rendered = render + 3 * ((size_t)y * photo->width_px + x);
            float *left = pair + 3 * ((size_t)y * 2 * photo->width_px + x), *right = left + 3 * (size_t)photo->width_px;
            bool counts = rendering->masked ? vw_view_keeps(view, x, y) : vw_view_can_use(view, x, y);
            photo_colour(rendering, photo, x, y, left);
            for (int c = 0; c < 3; c++) {
                right[c] = rendered[c];
                double error = (double)rendered[c] - left[c];
                if (counts) squared_error += error * error;
            }
            if (counts) value_count += 3;
        }
    double mse = squared_error / (double)value_count;
    return vw_psnr_db(mse); // NaN when no pixel counts
}

static enum vw_status vw_trainer_render_view(const struct rendering *rendering, uint32_t view, const char *target,
                                             double *psnr_db) {
    const struct vw_image *photo = &rendering->run.scene->views[view].image;
    float *render = NULL;
    float *pair = vw_allocate(2 * (size_t)photo->width_px * photo->height_px, 3 * sizeof *pair);
    if (!pair) return VW_ERROR_MEMORY;
    enum vw_status status = vw_trainer_render(rendering->trainer, view, &render);
    if (!status) *psnr_db = compare(rendering, &rendering->run.scene->views[view], render, pair);
    if (!status) status = vw_image_save(target, 2 * photo->width_px, photo->height_px, 3, pair);
    free(render);
    free(pair);
    return status;
}

static enum vw_status fill_result(const struct rendering *rendering, uint32_t view, struct vw_rendered_view *rendered) {
    const struct vw_view *of_view = &rendering->run.scene->views[view];
    rendered->view = vw_copy_text(of_view->name);
    rendered->split = of_view->split;
    rendered->fitted = rendering->fitted;
    return rendered->view ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status lock_target(const struct vw_render_params *params, struct vw_out_lock **lock) {
    if (params->to) return vw_out_lock_take_for(params->to, &params->out, 1, lock);
    return vw_folder_exists(params->out) ? vw_out_lock_take(params->out, lock) : VW_OK; // opening says what is missing
}

enum vw_status vw_render_view(const struct vw_render_params *params, struct vw_rendered_view *rendered) {
    struct rendering rendering = {0};
    struct vw_out_lock *lock = NULL;
    uint32_t view = 0;
    enum vw_status status = check_target(params->to);
    if (!status) status = lock_target(params, &lock);
    if (!status) status = open_rendering(params, &rendering);
    if (!status) status = choose_view(&rendering, &view);
    if (!status) status = fill_result(&rendering, view, rendered);
    if (!status) {
        rendered->image_path = name_target(&rendering, view);
        status = rendered->image_path
                     ? vw_trainer_render_view(&rendering, view, rendered->image_path, &rendered->psnr_db)
                     : VW_ERROR_MEMORY;
    }
    close_rendering(&rendering);
    vw_out_lock_release(&lock);
    return status;
}

void vw_rendered_view_free(struct vw_rendered_view *rendered) {
    free(rendered->view);
    free(rendered->image_path);
    *rendered = (struct vw_rendered_view){0};
}
