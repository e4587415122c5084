// From image paths to pixels: --downscale, file hashes, transparency and what had to be repaired.
#include <inttypes.h>

#include "image/downscale.h"
#include "scene/draft.h"
#include "viewworth/hash.h"

struct repairs {
    uint32_t clamped_views, masked_views;
    uint64_t clamped_values, masked_pixels, value_count;
};

// The photo's edges stay where they are, so each axis is scaled by the ratio of its pixel counts.
static void downscale_camera(struct vw_camera *camera, uint32_t factor) {
    uint32_t width_px = vw_downscaled_px(camera->width_px, factor), height_px = vw_downscaled_px(camera->height_px, factor);
    double scale_x = (double)width_px / camera->width_px, scale_y = (double)height_px / camera->height_px;
    camera->focal_x_px *= scale_x;
    camera->centre_x_px *= scale_x;
    camera->focal_y_px *= scale_y;
    camera->centre_y_px *= scale_y;
    camera->width_px = width_px;
    camera->height_px = height_px;
}

static enum vw_status read_photo(const struct vw_draft *draft, uint32_t index, uint64_t full_value_count, struct repairs *repairs) {
    struct vw_view *view = &draft->scene->views[index];
    const char *path = draft->image_paths[index];
    enum vw_status status = vw_sha256_file(path, view->sha256);
    if (status || view->split == VW_SPLIT_EXCLUDED) return status;
    status = vw_image_load(path, draft->params->downscale, &view->image);
    if (status) return status;
    if (view->image.width_px != view->camera.width_px || view->image.height_px != view->camera.height_px)
        return vw_fail(VW_ERROR_IO, "%s: the image changed its size while it was read; start again", path);
    draft->scene->has_alpha |= view->image.has_alpha;
    repairs->clamped_views += view->image.clamped_count > 0;
    repairs->masked_views += view->image.masked_count > 0;
    repairs->clamped_values += view->image.clamped_count;
    repairs->masked_pixels += view->image.masked_count;
    repairs->value_count += full_value_count;
    return VW_OK;
}

static enum vw_status note_repairs(struct vw_scene *scene, const struct repairs *repairs) {
    enum vw_status status = VW_OK;
    if (repairs->clamped_views)
        status = vw_scene_note(scene, "%u photos: %.3g %% of all pixel values lie above 1 and were clamped", repairs->clamped_views,
                               100.0 * (double)repairs->clamped_values / (double)repairs->value_count);
    if (!status && repairs->masked_views)
        status = vw_scene_note(scene, "%u photos: %" PRIu64 " pixels are NaN, infinite or negative and were masked", repairs->masked_views,
                               repairs->masked_pixels);
    return status;
}

enum vw_status vw_photos_read(struct vw_draft *draft) {
    struct vw_scene *scene = draft->scene;
    struct repairs repairs = {0};
    for (uint32_t v = 0; v < scene->view_count; v++) {
        struct vw_camera *camera = &scene->views[v].camera;
        uint64_t full_value_count = (uint64_t)camera->width_px * camera->height_px * 4;
        downscale_camera(camera, draft->params->downscale);
        enum vw_status status = draft->params->headers_only ? VW_OK : read_photo(draft, v, full_value_count, &repairs);
        if (status) return status;
    }
    for (int c = 0; c < 3; c++) scene->background[c] = scene->has_alpha ? 1 : 0; // white is Blender's convention
    return note_repairs(scene, &repairs);
}
