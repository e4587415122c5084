// The filter of splats: what train photos cannot tell at a splat (Yu et al., "Mip-Splatting", 2024). Without it, splats
// become as thin as the photos' pixels hide, and a camera that comes nearer sees through the gaps between them.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "train/model.h"
#include "train/pixels.h"
#include "train/renderers/splats/splats.h"

static const float FILTER_PX2 = 0.2f; // variance, in pixels of the nearest train photo that shows the splat
static const float OWN_SHARE = 0.01f; // least variance that a file's splat keeps beside the filter, in filters

struct witness {
    struct vw_gpu_camera camera;
    struct vw_splat_view view;
};

static uint32_t list_witnesses(const struct vw_model *model, const struct vw_scene *scene, struct witness *list) {
    bool lens = model->specialization.effect_distortion != DISTORTION_NONE;
    uint32_t count = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (vw_model_trains_on(model, scene, v))
            list[count++] = (struct witness){vw_pixels_camera(&scene->views[v], &model->box),
                                             vw_splat_view_of(v, 0, &scene->views[v].camera, lens, 1)};
    return count;
}

static float along(vw_float4 axis, const float *mean, vw_float4 from) {
    return axis.x * (mean[0] - from.x) + axis.y * (mean[1] - from.y) + axis.z * (mean[2] - from.z);
}

// Returns the squared width of a photo's pixel at a place, in box edges; infinite where the photo does not show it.
static float pixel2_at(const struct witness *witness, const float *mean) {
    const struct vw_gpu_camera *camera = &witness->camera;
    vw_float4 from = camera->reference, slopes = witness->view.slopes;
    float depth = from.w - along(camera->back, mean, from), focal = fmaxf(camera->right.w, camera->up.w);
    float x = along(camera->right, mean, from) / depth, y = -along(camera->up, mean, from) / depth;
    bool seen = depth > 0.0f && x > slopes.x && y > slopes.y && x < slopes.z && y < slopes.w;
    return seen ? depth * depth / (focal * focal) : INFINITY;
}

// Writes the filters; that of splats that no photo shows is the widest of all others.
static void write_filters(const struct witness *list, uint32_t count, uint32_t splats, float *params) {
    float *scales = params + 4 * SPLAT_SCALE * (size_t)splats, widest = 0.0f;
    for (size_t i = 0; i < splats; i++) {
        float pixel2 = INFINITY;
        for (uint32_t v = 0; v < count; v++) pixel2 = fminf(pixel2, pixel2_at(&list[v], params + 4 * i));
        scales[4 * i + 3] = FILTER_PX2 * pixel2;
        if (isfinite(pixel2)) widest = fmaxf(widest, FILTER_PX2 * pixel2);
    }
    for (size_t i = 0; i < splats; i++) scales[4 * i + 3] = fminf(scales[4 * i + 3], widest);
}

// Takes the filter out of scales that hold it; splats that are thinner than it become as wide.
static void take_out(uint32_t splats, float *scales) {
    for (size_t i = 0; i < splats; i++)
        for (size_t axis = 4 * i; axis < 4 * i + 3; axis++) {
            double filter = scales[4 * i + 3], variance = exp(2.0 * scales[axis]);
            if (filter > 0.0) scales[axis] = (float)(0.5 * log(fmax(variance - filter, OWN_SHARE * filter)));
        }
}

enum vw_status vw_splats_filter(const struct vw_model *model, const struct vw_scene *scene, bool held, float *params) {
    uint32_t splats = vw_splat_model_of(model)->count;
    struct witness *list = vw_allocate(scene->view_count, sizeof *list);
    if (!list) return VW_ERROR_MEMORY;
    write_filters(list, list_witnesses(model, scene, list), splats, params);
    if (held) take_out(splats, params + 4 * SPLAT_SCALE * (size_t)splats);
    free(list);
    return VW_OK;
}
