#include "run/outputs/cover_masks.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/inside.h"
#include "base/memory.h"
#include "image/image.h"
#include "image/photo_formats.h"
#include "run/out_folder.h"
#include "run/outputs/cover_regions.h"
#include "scene/builder.h"

static const double DEPTH_SHARE = 0.5; // share of a ray that must end for its depth to be known
static const double KEPT_LEAST = 0.25; // share of a photo that a mask keeps
enum { GROW_PX = 1 };                  // pixels of a pane, around what is covered

struct covering {
    const struct vw_cover_params *params;
    const struct vw_scene *scene;
    struct vw_cover_panes panes; // by scene index
    uint32_t height_px;
};

// Returns whether a photo shows what its pose sees, or nobody knows.
static bool is_in_place(const struct vw_photo_finding *finding) {
    static const enum vw_defect_kind elsewhere[] = {VW_DEFECT_EMPTY, VW_DEFECT_ORIENTATION, VW_DEFECT_SWAPPED,
                                                    VW_DEFECT_POSE,  VW_DEFECT_ZOOM,        VW_DEFECT_MISMATCH};
    for (size_t i = 0; i < VW_ARRAY_COUNT(elsewhere); i++)
        if (finding->word == vw_defect_words[elsewhere[i]]) return false;
    return true;
}

// ---- Panes ---------------------------------------------------------------------------------------------------------

static enum vw_status make_pane(const struct covering *covering, uint32_t v, struct vw_cover_pane *pane) {
    const struct vw_view *view = &covering->scene->views[v];
    struct vw_trainer *trainer = covering->params->panes.trainer;
    struct vw_panes panes = {0};
    struct vw_view posed = *view;
    enum vw_status status = vw_scene_decode(covering->scene, &v, 1);
    if (!status) status = vw_panes_make(&covering->params->panes, v, covering->height_px, &panes);
    if (!status) {
        vw_camera_resize(panes.size_px[0], panes.size_px[1], &posed.camera);
        pane->camera = posed.camera;
        pane->view = view;
        status = vw_cover_make_errors(&panes, pane);
    }
    if (!status) status = vw_trainer_render_poses(trainer, &v, &posed, 1, DEPTH_SHARE, &pane->depths);
    vw_panes_free(&panes);
    return status;
}

// Leaves out photos that the field was not trained on: it does not show there what no photo told it.
static bool takes_part(const struct vw_scene *scene, uint32_t v) {
    return scene->views[v].split == VW_SPLIT_TRAIN && scene->views[v].image.height_px >= VW_COVER_HEIGHT_LEAST_PX;
}

static enum vw_status make_panes(struct covering *covering, const struct vw_photo_finding *findings) {
    const struct vw_scene *scene = covering->scene;
    struct vw_cover_panes *panes = &covering->panes;
    panes->list = vw_allocate(scene->view_count, sizeof *panes->list);
    panes->count = scene->view_count;
    memcpy(panes->middle_world, scene->box.centre_world, sizeof panes->middle_world);
    enum vw_status status = panes->list ? vw_view_scales_find(scene, &panes->scales) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        if (!takes_part(scene, v) || !is_in_place(&findings[v])) continue;
        status = make_pane(covering, v, &panes->list[v]);
        panes->list[v].tells = findings[v].word != vw_defect_words[VW_DEFECT_COPY];
    }
    return status ? status : vw_cover_settle(panes);
}

static void free_panes(struct vw_cover_panes *panes) {
    for (uint32_t v = 0; panes->list && v < panes->count; v++) {
        free(panes->list[v].errors);
        free(panes->list[v].depths);
    }
    free(panes->list);
}

// ---- Files ---------------------------------------------------------------------------------------------------------

// Returns whether a pixel or one near it is covered.
static bool is_covered(const struct vw_camera *camera, const bool *covered, double x_px, double y_px) {
    int64_t width_px = camera->width_px, height_px = camera->height_px;
    for (int64_t y = (int64_t)floor(y_px) - GROW_PX; y <= (int64_t)floor(y_px) + GROW_PX; y++)
        for (int64_t x = (int64_t)floor(x_px) - GROW_PX; x <= (int64_t)floor(x_px) + GROW_PX; x++)
            if (x >= 0 && y >= 0 && x < width_px && y < height_px && covered[y * width_px + x]) return true;
    return false;
}

// Returns whether the mask that the photo was trained with hides what is there; shares of its width and height.
static bool is_hidden(const struct vw_view *view, double across, double down) {
    uint32_t x = (uint32_t)(across * view->image.width_px), y = (uint32_t)(down * view->image.height_px);
    return view->mask && view->mask[(size_t)y * view->image.width_px + x] == VW_MASK_HIDE;
}

// Draws a mask of the size of the photo's file; returns the share that it keeps. `covered` of NULL: nothing is.
static double draw_mask(const struct covering *covering, uint32_t view, const bool *covered, const uint32_t size_px[2],
                        float *pixels) {
    const struct vw_camera *camera = &covering->panes.list[view].camera;
    double kept = 0;
    for (uint32_t y = 0; y < size_px[1]; y++)
        for (uint32_t x = 0; x < size_px[0]; x++) {
            double across = (x + 0.5) / size_px[0], down = (y + 0.5) / size_px[1];
            bool hides = is_hidden(&covering->scene->views[view], across, down) ||
                         (covered && is_covered(camera, covered, across * camera->width_px, down * camera->height_px));
            pixels[(size_t)y * size_px[0] + x] = !hides;
            kept += !hides;
        }
    return kept / size_px[0] / size_px[1];
}

// Makes the file of a mask; `*data` stays NULL if it would keep too little to train on.
static enum vw_status encode(const struct covering *covering, uint32_t view, const bool *covered, void **data,
                             size_t *size_bytes) {
    struct vw_image_encoding encoding = {.channels = 1, .eight_bit = true};
    uint32_t size_px[2];
    vw_view_file_size(covering->scene, view, size_px);
    encoding.width_px = size_px[0], encoding.height_px = size_px[1];
    float *pixels = vw_allocate(size_px[0], size_px[1] * sizeof *pixels);
    if (!pixels) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    if (!vw_photo_format_of_name("mask.png", &encoding.format))
        status = vw_fail(VW_ERROR_IO, "PNG is not a format that is written");
    else if (draw_mask(covering, view, covered, size_px, pixels) >= KEPT_LEAST)
        status = vw_image_encode(&encoding, pixels, data, size_bytes);
    free(pixels);
    return status;
}

// Writes a mask, or nothing for `needed` of false, instead of that of an earlier end of the run.
static enum vw_status write_mask(const struct covering *covering, uint32_t view, const bool *covered, bool needed,
                                 bool *written) {
    char *folder = vw_path_join(covering->params->out, VW_OUT_MASKS),
         *name = vw_mask_name(covering->scene->views[view].name),
         *file = folder && name ? vw_path_join(folder, name) : NULL, *place = file ? vw_path_folder(file) : NULL;
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = place ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for a mask");
    if (!status && !vw_path_leaves_folder(name)) { // else it has no place
        if (needed) status = encode(covering, view, covered, &data, &size_bytes);
        if (!status && data) status = vw_folder_create(place);
        if (!status && data) status = vw_file_write(file, data, size_bytes);
        if (!status && !data && vw_file_exists(file)) status = vw_file_remove(folder, name);
    }
    *written = !status && data;
    free(data);
    free(place);
    free(file);
    free(name);
    free(folder);
    return status;
}

// ---- All of it -----------------------------------------------------------------------------------------------------

static void tell(double share, struct vw_photo_finding *finding) {
    finding->covered = share;
    if (finding->word || share < VW_COVER_SHARE_LEAST) return;
    finding->word = vw_defect_words[VW_DEFECT_OCCLUDER];
    snprintf(finding->description, sizeof finding->description,
             "%.0f %% of it show something that the reconstruction does not", 100 * share);
}

// Finds what covers a photo, and writes its mask; those that the scene was opened with come along.
static enum vw_status mask_view(const struct covering *covering, uint32_t view, struct vw_photo_finding *finding,
                                uint32_t *mask_count) {
    const struct vw_cover_pane *pane = &covering->panes.list[view];
    bool *covered = NULL, written = false, takes_part = pane->view != NULL;
    enum vw_status status = VW_OK;
    double share = 0;
    if (takes_part) {
        covered = vw_allocate((size_t)pane->camera.width_px * pane->camera.height_px, sizeof *covered);
        status = covered ? vw_cover_find(&covering->panes, view, covered, &share) : VW_ERROR_MEMORY;
    }
    bool covers = share >= VW_COVER_SHARE_LEAST;
    if (!status && covering->scene->source)
        status = write_mask(covering, view, covers ? covered : NULL,
                            covers || covering->scene->views[view].mask_is_given, &written);
    if (!status && takes_part) tell(share, finding);
    *mask_count += covers && written;
    free(covered);
    return status;
}

// Chooses the height of panes by what may be rendered: colours and depths of all photos.
static uint32_t choose_height(const struct vw_cover_params *params, const struct vw_scene *scene) {
    double squares = 0; // pixels of all photos at a height of 1
    uint32_t tallest_px = 0;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        const struct vw_image *image = &scene->views[v].image;
        if (!takes_part(scene, v)) continue;
        squares += (double)image->width_px / image->height_px;
        if (image->height_px > tallest_px) tallest_px = image->height_px;
    }
    double rays = fmax(params->rays_most, VW_COVER_RAYS_LEAST), height_px = squares ? sqrt(rays / (2 * squares)) : 0;
    return height_px < VW_COVER_HEIGHT_LEAST_PX ? 0 : (uint32_t)fmin(fmin(VW_COVER_HEIGHT_PX, tallest_px), height_px);
}

enum vw_status vw_cover_masks_make(const struct vw_cover_params *params, struct vw_photo_finding *findings,
                                   uint32_t *mask_count) {
    const struct vw_scene *scene = params->panes.scene;
    struct covering covering = {.params = params, .scene = scene, .height_px = choose_height(params, scene)};
    if (!covering.height_px || scene->split_count[VW_SPLIT_TRAIN] < 2) return VW_OK;
    enum vw_status status = make_panes(&covering, findings);
    for (uint32_t v = 0; v < scene->view_count && !status; v++)
        if (scene->views[v].split != VW_SPLIT_EXCLUDED) status = mask_view(&covering, v, &findings[v], mask_count);
    free_panes(&covering.panes);
    return status;
}
