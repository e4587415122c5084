#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "check/patch.h"
#include "check/photos.h"
#include "scene/view_distance.h"

enum {
    CELLS_MOST = 12,      // along a side; a corner of each is tried
    CORNERS_MOST = 20000, // all photos, for the time that it takes
    DEPTHS_MOST = 200,    // tried of a corner
    FINER = 2,            // on each side of the best, between it and the next
    COMPARED = 4          // photos that it is compared with, before the best depth is known
};
static const float SURE = 0.75F;                  // correlation
static const float CORNER_LEAST = 1e-3F;          // smaller eigenvalue of the gradients around it
static const double STEP_PX = 2;                  // that a step of depth moves it in another photo
static const double NEAREST = 0.1, FARTHEST = 20; // half extents of the box

struct corner {
    const struct vw_check_photos *photos;
    const struct vw_check_photo *photo;
    double at_px[2];
    struct vw_patch_rays rays;
    struct vw_patch patch;
    float correlations[VW_CHECK_OTHERS]; // at the depth that was tried last
};

// Computes the smaller eigenvalue of the gradients' products around a pixel (Shi and Tomasi, "Good features to track",
// CVPR 1994).
static float corner_strength(const struct vw_plane *plane, uint32_t x_px, uint32_t y_px) {
    enum { REACH = 2 };
    float xx = 0, xy = 0, yy = 0;
    for (uint32_t y = y_px - REACH; y <= y_px + REACH; y++)
        for (uint32_t x = x_px - REACH; x <= x_px + REACH; x++) {
            const float *at = plane->values + (size_t)y * plane->width_px + x;
            float across = at[1] - at[-1], down = at[plane->width_px] - at[-(ptrdiff_t)plane->width_px];
            xx += across * across, xy += across * down, yy += down * down;
        }
    return (xx + yy) / 2 - sqrtf((xx - yy) * (xx - yy) / 4 + xy * xy);
}

static bool find_corner(struct corner *corner, uint32_t cells, uint32_t column, uint32_t row) {
    static const double beside[2][2] = {{1, 0}, {0, 1}};
    const struct vw_plane *plane = &corner->photo->small;
    float most = CORNER_LEAST;
    bool found = false;
    for (uint32_t y = row * plane->height_px / cells; y < (row + 1) * plane->height_px / cells; y++)
        for (uint32_t x = column * plane->width_px / cells; x < (column + 1) * plane->width_px / cells; x++) {
            if (x <= VW_PATCH_REACH_PX || y <= VW_PATCH_REACH_PX || x + VW_PATCH_REACH_PX + 1 >= plane->width_px ||
                y + VW_PATCH_REACH_PX + 1 >= plane->height_px)
                continue;
            float strength = corner_strength(plane, x, y);
            if (!(strength > most)) continue;
            most = strength, found = true;
            corner->at_px[0] = x + 0.5, corner->at_px[1] = y + 0.5;
        }
    return found && vw_patch_read(plane, corner->at_px, beside, &corner->patch) &&
           vw_patch_rays_of(corner->photo, corner->at_px, &corner->rays);
}

// Returns the mean correlation with the two photos, of the first `count`, that agree best about a depth.
static float agree_at(struct corner *corner, double depth, uint32_t count) {
    float best = -1, second = -1;
    for (uint32_t o = 0; o < corner->photo->other_count && o < count; o++) {
        double there_px[2], there_depth;
        struct vw_patch seen;
        bool shown = vw_patch_warp(&corner->rays, depth, &corner->photos->list[corner->photo->others[o]], there_px,
                                   &there_depth, &seen);
        float correlation = shown ? vw_patch_correlate(&corner->patch, &seen) : -1;
        corner->correlations[o] = correlation;
        second = fmaxf(second, fminf(best, correlation));
        best = fmaxf(best, correlation);
    }
    return (best + second) / 2;
}

// Returns the step of inverse depth that moves a place by STEP_PX in the photos that are compared.
static double inverse_step(const struct corner *corner) {
    double between = 0;
    for (uint32_t o = 0; o < corner->photo->other_count && o < COMPARED; o++)
        between = fmax(between,
                       vw_view_between_world(corner->photo->view, corner->photos->list[corner->photo->others[o]].view));
    return STEP_PX / (vw_check_focal_px(corner->photo) * between);
}

static bool find_depth(struct corner *corner, double *depth) {
    double extent = corner->photos->scene->box.half_extent_world, first = 1 / (FARTHEST * extent),
           last = 1 / (NEAREST * extent), step = fmax(inverse_step(corner), (last - first) / DEPTHS_MOST), best = 0;
    float agreed = -1;
    for (double inverse = first; inverse <= last; inverse += step) {
        float agreement = agree_at(corner, 1 / inverse, COMPARED);
        if (agreement > agreed) agreed = agreement, best = inverse;
    }
    double middle = best;
    for (int i = -FINER; i <= FINER && agreed > 0; i++) {
        double inverse = middle + step * i / (FINER + 1);
        float agreement = inverse > 0 ? agree_at(corner, 1 / inverse, COMPARED) : -1;
        if (agreement > agreed) agreed = agreement, best = inverse;
    }
    *depth = 1 / best;
    return agreed > 0 && agree_at(corner, *depth, VW_CHECK_OTHERS) >= SURE;
}

static bool make_point(struct corner *corner, uint32_t view, struct vw_made_point *made) {
    double depth;
    if (!find_depth(corner, &depth)) return false;
    *made = (struct vw_made_point){.views = {view}, .view_count = 1};
    for (uint32_t o = 0; o < corner->photo->other_count; o++)
        if (corner->correlations[o] >= SURE) made->views[made->view_count++] = corner->photo->others[o];
    return made->view_count >= 3 && vw_check_unproject(corner->photo, corner->at_px, depth, made->position_world);
}

struct making {
    const struct vw_check_photos *photos;
    struct vw_made_point *made; // by photo and cell
    uint32_t cells;
};

static enum vw_status make_of_photo(void *context, uint32_t view) {
    const struct making *making = context;
    uint32_t cells = making->cells;
    struct vw_made_point *made = making->made + (size_t)view * cells * cells;
    for (uint32_t cell = 0; making->photos->list[view].view && cell < cells * cells; cell++) {
        struct corner corner = {.photos = making->photos, .photo = &making->photos->list[view]};
        if (find_corner(&corner, cells, cell % cells, cell / cells) && make_point(&corner, view, made)) made++;
        else made->view_count = 0;
    }
    return VW_OK;
}

enum vw_status vw_check_make_points(const struct vw_check_photos *photos, struct vw_made_point **made,
                                    uint32_t *count) {
    struct making making = {photos, NULL, CELLS_MOST};
    while (making.cells > 1 && (uint64_t)making.cells * making.cells * photos->count > CORNERS_MOST) making.cells--;
    uint32_t of_photo = making.cells * making.cells;
    *count = 0;
    *made = making.made = vw_allocate((size_t)of_photo * photos->count, sizeof **made);
    if (!*made) return VW_ERROR_MEMORY;
    enum vw_status status = vw_parallel_for(photos->count, make_of_photo, &making);
    for (uint32_t i = 0; i < of_photo * photos->count; i++)
        if ((*made)[i].view_count) (*made)[(*count)++] = (*made)[i];
    return status;
}
