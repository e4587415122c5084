#include "check/photos.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "image/image.h"
#include "scene/view_distance.h"

// ---- Small photos --------------------------------------------------------------------------------------------------

// Averages the pixels of a block; NaN if less than half of them count.
static float mean_of_block(const struct vw_view *view, const float background[3], uint32_t left, uint32_t top,
                           uint32_t side) {
    double sum = 0;
    uint32_t kept = 0;
    for (uint32_t y = top; y < top + side; y++)
        for (uint32_t x = left; x < left + side; x++) {
            if (!vw_view_keeps(view, x, y)) continue;
            sum += vw_image_luminance(&view->image, x, y, background);
            kept++;
        }
    return 2 * kept >= side * side ? (float)(sum / kept) : NAN;
}

static enum vw_status make_small(void *context, uint32_t index) {
    struct vw_check_photos *photos = context;
    struct vw_check_photo *photo = &photos->list[index];
    if (!photo->view) return VW_OK;
    uint32_t width_px = photo->view->image.width_px, height_px = photo->view->image.height_px;
    uint32_t longer_px = width_px > height_px ? width_px : height_px;
    uint32_t factor = (longer_px + VW_CHECK_SIDE_PX - 1) / VW_CHECK_SIDE_PX;
    if (width_px < factor) factor = width_px; // a strip stays longer
    if (height_px < factor) factor = height_px;
    struct vw_plane *small = &photo->small;
    *small = (struct vw_plane){.width_px = width_px / factor, .height_px = height_px / factor};
    small->values = vw_allocate((size_t)small->width_px * small->height_px, sizeof *small->values);
    if (!small->values) return VW_ERROR_MEMORY;
    photo->small_per_px = 1.0 / factor;
    for (uint32_t y = 0; y < small->height_px; y++)
        for (uint32_t x = 0; x < small->width_px; x++)
            small->values[(size_t)y * small->width_px + x] =
                mean_of_block(photo->view, photos->scene->background, x * factor, y * factor, factor);
    return VW_OK;
}

// ---- Cameras -------------------------------------------------------------------------------------------------------

double vw_check_focal_px(const struct vw_check_photo *photo) {
    return photo->view->camera.focal_x_px * photo->small_per_px;
}

bool vw_check_project(const struct vw_check_photo *photo, const double place_world[3], double at_px[2], double *depth) {
    double direction[3] = {0};
    const double(*pose)[4] = photo->view->camera_to_world;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 3; i++) direction[axis] += pose[i][axis] * (place_world[i] - pose[i][VW_POSE_POSITION]);
    *depth = -direction[VW_POSE_BACK];
    if (!vw_camera_project(&photo->view->camera, direction, &at_px[0], &at_px[1])) return false;
    for (int i = 0; i < 2; i++) at_px[i] *= photo->small_per_px;
    return isfinite(at_px[0]) && isfinite(at_px[1]);
}

bool vw_check_unproject(const struct vw_check_photo *photo, const double at_px[2], double depth,
                        double place_world[3]) {
    double direction[3];
    const double(*pose)[4] = photo->view->camera_to_world;
    if (!vw_camera_unproject(&photo->view->camera, at_px[0] / photo->small_per_px, at_px[1] / photo->small_per_px,
                             direction))
        return false;
    for (int i = 0; i < 3; i++) {
        place_world[i] = pose[i][VW_POSE_POSITION];
        for (int axis = 0; axis < 3; axis++) place_world[i] += depth * direction[axis] * pose[i][axis];
    }
    return true;
}

static void choose_others(struct vw_check_photos *photos, const struct vw_view_scales *scales, uint32_t view) {
    struct vw_check_photo *photo = &photos->list[view];
    double aparts[VW_CHECK_OTHERS];
    for (uint32_t i = 0; i < photos->count; i++) {
        if (i == view || !photos->list[i].view) continue;
        double apart = vw_view_apart(scales, photo->view, photos->list[i].view);
        uint32_t at = photo->other_count;
        if (at < VW_CHECK_OTHERS) photo->other_count++;
        else if (apart >= aparts[--at]) continue;
        for (; at > 0 && aparts[at - 1] > apart; at--)
            photo->others[at] = photo->others[at - 1], aparts[at] = aparts[at - 1];
        photo->others[at] = i, aparts[at] = apart;
    }
}

// ---- Points --------------------------------------------------------------------------------------------------------

enum vw_status vw_check_take_points(struct vw_check_photos *photos, const struct vw_made_point *made, uint32_t count) {
    const struct vw_scene *scene = photos->scene;
    uint64_t track_count = scene->track_count, point_count = (uint64_t)scene->point_count + count;
    for (uint32_t i = 0; i < count; i++) track_count += made[i].view_count;
    if (track_count > UINT32_MAX || point_count > UINT32_MAX)
        return vw_fail(VW_ERROR_INPUT, "%s: its points are seen more than 2^32 times; leave some out", scene->path);
    photos->points = vw_allocate(point_count, sizeof *photos->points);
    photos->tracked = vw_allocate(track_count, sizeof *photos->tracked);
    uint32_t *ends = vw_allocate((size_t)photos->count + 1, sizeof *ends); // by photo, shifted by one while counting
    if (!photos->points || !photos->tracked || !ends) {
        free(ends);
        return VW_ERROR_MEMORY;
    }
    photos->point_count = (uint32_t)point_count;
    for (uint32_t t = 0; t < scene->track_count; t++) ends[scene->tracks[t].view + 1]++;
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t k = 0; k < made[i].view_count; k++) ends[made[i].views[k] + 1]++;
    for (uint32_t v = 0; v < photos->count; v++) {
        photos->list[v].points = photos->tracked + ends[v];
        photos->list[v].point_count = ends[v + 1];
        ends[v + 1] += ends[v];
    }
    for (uint32_t p = 0; p < point_count; p++) {
        bool own = p < scene->point_count;
        const struct vw_point *point = own ? &scene->points[p] : NULL;
        const struct vw_made_point *other = own ? NULL : &made[p - scene->point_count];
        memcpy(photos->points[p], own ? point->position_world : other->position_world, sizeof photos->points[p]);
        for (uint32_t t = 0; t < (own ? point->track_count : other->view_count); t++)
            photos->tracked[ends[own ? scene->tracks[point->first_track + t].view : other->views[t]]++] = p;
    }
    free(ends);
    return VW_OK;
}

enum vw_status vw_check_photos_open(const struct vw_scene *scene, struct vw_check_photos *photos) {
    struct vw_view_scales scales;
    *photos = (struct vw_check_photos){.scene = scene, .count = scene->view_count};
    photos->list = vw_allocate(scene->view_count, sizeof *photos->list);
    enum vw_status status = photos->list ? vw_scene_decode_all(scene) : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && !status; v++)
        if (scene->views[v].split != VW_SPLIT_EXCLUDED) photos->list[v].view = &scene->views[v];
    if (!status) status = vw_parallel_for(scene->view_count, make_small, photos);
    bool compared = scene->split_count[VW_SPLIT_TRAIN] >= 2;
    if (!status && compared) status = vw_view_scales_find(scene, &scales);
    for (uint32_t v = 0; v < scene->view_count && !status && compared; v++)
        if (photos->list[v].view) choose_others(photos, &scales, v);
    return status;
}

void vw_check_photos_close(struct vw_check_photos *photos) {
    for (uint32_t v = 0; photos->list && v < photos->count; v++) free(photos->list[v].small.values);
    free(photos->list);
    free(photos->points);
    free(photos->tracked);
    *photos = (struct vw_check_photos){0};
}
