#include "run/recorded/rendering.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/memory.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "train/trainer.h"

enum vw_status vw_render_check_image(const char *to) {
    if (!to || vw_path_ends_with(to, ".png") || vw_path_ends_with(to, ".exr")) return VW_OK;
    return vw_fail(VW_ERROR_USAGE, "--to %s: the name must end in .png or .exr", to);
}

// ---- Choosing the view ---------------------------------------------------------------------------------------------

static bool find_by_name(const struct vw_scene *scene, const char *name, uint32_t *view) {
    for (*view = 0; *view < scene->view_count; ++*view)
        if (strcmp(scene->views[*view].name, name) == 0) return true;
    return false;
}

bool vw_view_has_short_name(const struct vw_view *view, const char *wanted) {
    const char *name = view->name;
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
        if (vw_view_has_short_name(&scene->views[v], wanted) && count++ < VW_ARRAY_COUNT(places)) places[count - 1] = v;
    if (count == 1) *view = places[0];
    if (count < 2) return VW_OK;
    bool third = count >= VW_ARRAY_COUNT(places);
    return vw_fail(VW_ERROR_USAGE, "--view %s: is short for %u photos: %s, %s%s%s%s; write the name out", wanted, count,
                   scene->views[places[0]].name, scene->views[places[1]].name, third ? ", " : "",
                   third ? scene->views[places[2]].name : "", count > VW_ARRAY_COUNT(places) ? ", ..." : "");
}

static bool find_by_place(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    char *end;
    unsigned long long place = strtoull(wanted, &end, 10);
    if (!isdigit((unsigned char)wanted[0]) || *end) return false;
    for (*view = 0; *view < scene->view_count; ++*view)
        if (scene->views[*view].split == VW_SPLIT_VAL && place-- == 0) return true;
    return false;
}

static enum vw_status choose_view(const struct vw_scene *scene, const char *wanted, uint32_t *view) {
    uint32_t named = UINT32_MAX, placed = 0;
    if (find_by_name(scene, wanted, view)) return VW_OK;
    bool is_place = find_by_place(scene, wanted, &placed);
    bool padded = wanted[0] == '0' && wanted[1]; // "0094" is a name before it is a place
    enum vw_status status = is_place && !padded ? VW_OK : find_by_short_name(scene, wanted, &named);
    if (!status && !is_place && named == UINT32_MAX)
        status = vw_fail(VW_ERROR_USAGE,
                         "--view %s: no photo of this name, nor a place among the %u validation photos (from 0)",
                         wanted, scene->split_count[VW_SPLIT_VAL]);
    *view = named == UINT32_MAX ? placed : named;
    return status;
}

// ---- Opening -------------------------------------------------------------------------------------------------------

enum vw_status vw_rendering_lock(const char *out, const char *to, struct vw_out_lock **lock) {
    if (to) return vw_out_lock_take_for(to, &out, 1, lock);
    return vw_folder_exists(out) ? vw_out_lock_take(out, lock) : VW_OK; // opening says what is missing
}

enum vw_status vw_rendering_open(const struct vw_render_params *params, struct vw_rendering *rendering) {
    *rendering = (struct vw_rendering){0};
    enum vw_status status = vw_recorded_open(params->out, &rendering->run);
    if (!status) status = vw_recorded_open_scene(&rendering->run, params->device);
    if (!status) status = choose_view(rendering->run.scene, params->view ? params->view : "0", &rendering->view);
    return status ? status : vw_recorded_load_field(&rendering->run, &rendering->trainer);
}

void vw_rendering_close(struct vw_rendering *rendering) {
    vw_trainer_destroy(&rendering->trainer);
    vw_recorded_close(&rendering->run);
}

// ---- Depths --------------------------------------------------------------------------------------------------------

char *vw_render_name_depth(const char *image) {
    const char *point = strrchr(image, '.');
    return vw_format_text("%.*s_depth.exr", (int)(point - image), image);
}

enum vw_status vw_rendering_write_depth(const struct vw_rendering *rendering, const struct vw_view *posed,
                                        const char *image) {
    struct vw_image_encoding encoding = {
        .width_px = posed->camera.width_px, .height_px = posed->camera.height_px, .channels = 1};
    float *depth = NULL;
    void *file = NULL;
    size_t file_bytes = 0;
    char *name = vw_render_name_depth(image);
    enum vw_status status = name ? VW_OK : VW_ERROR_MEMORY;
    if (!status && !vw_photo_format_of_name(name, &encoding.format))
        status = vw_fail(VW_ERROR_IO, "EXR is not a format that is written");
    if (!status) status = vw_trainer_render_posed(rendering->trainer, rendering->view, posed, true, &depth);
    if (!status) status = vw_image_encode(&encoding, depth, &file, &file_bytes);
    if (!status) status = vw_file_write(name, file, file_bytes);
    free(depth);
    free(file);
    free(name);
    return status;
}
