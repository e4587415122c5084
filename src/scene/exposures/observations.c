#include "scene/exposures/observations.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "image/image.h"

static const double DARKEST = 0.01, BRIGHTEST = 0.99; // beyond, a channel may be clipped

// Reads a photo between pixel centres, bilinearly; NaN where one of the four pixels does not count or may be clipped.
static void read_pixel(const struct vw_view *view, const struct vw_track *track, double value[EXPOSURE_CHANNELS]) {
    const struct vw_image *image = &view->image;
    double x = track->x_px - 0.5, y = track->y_px - 0.5, left = floor(x), top = floor(y);
    bool inside = left >= 0 && top >= 0 && left + 1 < image->width_px && top + 1 < image->height_px;
    for (int channel = 0; channel < EXPOSURE_CHANNELS; channel++) value[channel] = inside ? 0.0 : NAN;
    for (uint32_t corner = 0; inside && corner < 4; corner++) {
        uint32_t right = corner & 1, below = corner >> 1, x_px = (uint32_t)left + right, y_px = (uint32_t)top + below;
        double weight = (right ? x - left : 1 - x + left) * (below ? y - top : 1 - y + top);
        float rgba[4];
        vw_image_pixel(image, x_px, y_px, rgba);
        bool counts = rgba[3] == 1.0f && vw_view_keeps(view, x_px, y_px);
        for (int channel = 0; channel < EXPOSURE_CHANNELS; channel++) {
            bool usable = counts && rgba[channel] >= DARKEST && rgba[channel] <= BRIGHTEST;
            value[channel] += usable ? weight * rgba[channel] : NAN;
        }
    }
}

// Makes a channel unusable in which a point has a single value: that would only say of its photo what the fit says.
static void drop_single(struct observation *observations, uint32_t count) {
    for (int channel = 0; channel < EXPOSURE_CHANNELS; channel++) {
        uint32_t usable = 0;
        for (uint32_t i = 0; i < count; i++) usable += !isnan(observations[i].value[channel]);
        for (uint32_t i = 0; i < count && usable == 1; i++) observations[i].value[channel] = NAN;
    }
}

enum vw_status vw_observations_list(const struct vw_scene *scene, struct observations *observations) {
    *observations = (struct observations){.list = vw_allocate(scene->track_count, sizeof *observations->list),
                                          .ends = vw_allocate(scene->point_count, sizeof *observations->ends),
                                          .point_count = scene->point_count,
                                          .view_count = scene->view_count};
    uint32_t *latest = vw_allocate(scene->view_count, sizeof *latest), count = 0; // by view: 1 + its latest point
    if (!observations->list || !observations->ends || !latest) {
        free(latest);
        return VW_ERROR_MEMORY;
    }
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        uint32_t begin = count;
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &scene->tracks[point->first_track + t];
            const struct vw_view *view = &scene->views[track->view];
            if (view->split != VW_SPLIT_TRAIN || latest[track->view] == p + 1) continue;
            latest[track->view] = p + 1;
            observations->list[count].view = track->view;
            read_pixel(view, track, observations->list[count++].value);
        }
        drop_single(observations->list + begin, count - begin);
        observations->ends[p] = count;
    }
    observations->count = count;
    free(latest);
    return VW_OK;
}

void vw_observations_release(const struct observations *observations) {
    free(observations->list);
    free(observations->ends);
}
