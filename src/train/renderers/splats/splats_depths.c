// Places of splats where a scene has no points: on rays of train photos, as far away as other photos agree. A patch of
// the photo is compared with where it would be in them, by normalised correlation, at many depths (a plane sweep, whose
// patches turn to no side: Goesele et al., "Multi-view stereo revisited", CVPR 2006).
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "image/image.h"
#include "train/model.h"
#include "train/pixels.h"
#include "train/renderers/splats/splats.h"

enum {
    REACH = 2, // pixels of a patch on each side of its middle
    SIDE = 2 * REACH + 1,
    PATCH = SIDE * SIDE,
    OTHERS = 4,      // photos that a photo is compared with
    DEPTHS = 48,     // equal steps of inverse depth
    FINER = 4,       // steps in each of these around the best
    DRAWS = 4,       // pixels that are tried until others agree on one
    DRAWS_MOST = 64, // pixels that are tried until one may be seen at all
};
static const double NEAREST = 0.05, FARTHEST = 20.0; // from a camera: extents; box edges
static const double VARIANCE_LEAST = 1e-4;           // added to that of luminance in a patch: less is noise
static const double ALIKE = 0.7;                     // cosine of the angle between the axes of two photos
static const float SURE = 0.7f; // correlation; an unsure pixel takes the depth of the nearest sure one of its photo

// A train photo; centre and axes in box coordinates.
struct photo {
    const struct vw_view *view;
    double centre[3], axes[3][3];         // right, up, back
    uint32_t others[OTHERS], other_count; // by index in the list
};

struct photos {
    struct photo *list;
    uint32_t count;
    bool in_box;    // all that they show is in the box
    double nearest; // box edges; nothing is nearer
};

struct patch {
    double values[PATCH], variance; // luminance less its mean
};

// A pixel of a photo, and how far away it is.
struct sight {
    bool found;
    uint32_t x_px, y_px;
    float depth, agreement; // box edges along the axis; correlation
};

// ---- Cameras -------------------------------------------------------------------------------------------------------

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static double distance2(const double a[3], const double b[3]) {
    double apart[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return dot(apart, apart);
}

static struct photo photo_of(const struct vw_view *view, const struct vw_box *box) {
    struct vw_gpu_camera camera = vw_pixels_camera(view, box);
    const vw_float4 columns[3] = {camera.right, camera.up, camera.back}, *from = &camera.reference;
    struct photo photo = {.view = view};
    for (int i = 0; i < 3; i++)
        memcpy(photo.axes[i], (double[3]){columns[i].x, columns[i].y, columns[i].z}, sizeof photo.axes[i]);
    const double reference[3] = {from->x, from->y, from->z};
    for (int i = 0; i < 3; i++) photo.centre[i] = reference[i] + from->w * photo.axes[2][i];
    return photo;
}

// Computes the place at a depth of an image position; returns whether the lens model has an inverse there.
static bool unproject(const struct photo *photo, double x_px, double y_px, double depth, double place[3]) {
    double direction[3];
    if (!vw_camera_unproject(&photo->view->camera, x_px, y_px, direction)) return false;
    for (int i = 0; i < 3; i++) {
        place[i] = photo->centre[i];
        for (int axis = 0; axis < 3; axis++) place[i] += depth * direction[axis] * photo->axes[axis][i];
    }
    return true;
}

static bool project(const struct photo *photo, const double place[3], double at_px[2]) {
    double from[3] = {place[0] - photo->centre[0], place[1] - photo->centre[1], place[2] - photo->centre[2]};
    double direction[3] = {dot(photo->axes[0], from), dot(photo->axes[1], from), dot(photo->axes[2], from)};
    return vw_camera_project(&photo->view->camera, direction, &at_px[0], &at_px[1]);
}

// ---- Agreement -----------------------------------------------------------------------------------------------------

// Reads a pixel; returns whether it is in the photo, may be trained on and is opaque.
static bool read_pixel(const struct photo *photo, double x_px, double y_px, float rgba[4]) {
    const struct vw_camera *camera = &photo->view->camera;
    if (!(x_px >= 0.0 && y_px >= 0.0 && x_px < camera->width_px && y_px < camera->height_px)) return false;
    if (!vw_view_keeps(photo->view, (uint32_t)x_px, (uint32_t)y_px)) return false;
    vw_image_pixel(&photo->view->image, (uint32_t)x_px, (uint32_t)y_px, rgba);
    return rgba[3] > 0.5f;
}

// Reads a patch, whose next column and row are so many pixels away; returns false where a pixel of it cannot be read.
static bool read_patch(const struct photo *photo, const double at_px[2], const double steps_px[2][2],
                       struct patch *patch) {
    double mean = 0.0;
    for (int i = 0; i < PATCH; i++) {
        float rgba[4];
        int u = i % SIDE - REACH, v = i / SIDE - REACH;
        if (!read_pixel(photo, at_px[0] + u * steps_px[0][0] + v * steps_px[1][0],
                        at_px[1] + u * steps_px[0][1] + v * steps_px[1][1], rgba))
            return false;
        patch->values[i] = vw_luminance_of(rgba);
        mean += patch->values[i] / PATCH;
    }
    patch->variance = VARIANCE_LEAST;
    for (int i = 0; i < PATCH; i++) {
        patch->values[i] -= mean;
        patch->variance += patch->values[i] * patch->values[i] / PATCH;
    }
    return true;
}

// Returns the correlation of a patch with how another photo shows the places of its middle and of the pixels right of
// and below it; -1 if it does not show them.
static float compare(const struct photo *other, const double places[3][3], const struct patch *patch) {
    double at_px[3][2], steps_px[2][2], product = 0.0;
    struct patch there;
    for (int i = 0; i < 3; i++)
        if (!project(other, places[i], at_px[i])) return -1.0f;
    for (int i = 0; i < 4; i++) steps_px[i / 2][i % 2] = at_px[1 + i / 2][i % 2] - at_px[0][i % 2];
    if (!read_patch(other, at_px[0], steps_px, &there)) return -1.0f;
    for (int i = 0; i < PATCH; i++) product += patch->values[i] * there.values[i] / PATCH;
    return (float)(product / sqrt(patch->variance * there.variance));
}

// Returns the mean correlation with the two photos that agree best: in others, something may be in front.
static float agree_at(const struct photos *photos, const struct photo *photo, const double at_px[2], double depth,
                      const struct patch *patch) {
    double places[3][3];
    float best = -1.0f, second = -1.0f;
    for (int i = 0; i < 3; i++)
        if (!unproject(photo, at_px[0] + (i == 1), at_px[1] + (i == 2), depth, places[i])) return -1.0f;
    for (uint32_t i = 0; i < photo->other_count; i++) {
        float correlation = compare(&photos->list[photo->others[i]], (const double(*)[3])places, patch);
        second = fmaxf(second, fminf(best, correlation));
        best = fmaxf(best, correlation);
    }
    return (best + second) / 2.0f;
}

// ---- Sights --------------------------------------------------------------------------------------------------------

// Keeps the depth that others agree on best, of `steps` whose inverses are evenly spaced.
static void sweep(const struct photos *photos, const struct photo *photo, const struct patch *patch, double inverse,
                  double spacing, uint32_t steps, struct sight *best) {
    double at_px[2] = {best->x_px + 0.5, best->y_px + 0.5};
    for (uint32_t i = 0; i < steps; i++, inverse += spacing) {
        float agreement = agree_at(photos, photo, at_px, 1.0 / inverse, patch);
        if (agreement <= best->agreement) continue;
        best->depth = (float)(1.0 / inverse);
        best->agreement = agreement;
    }
}

// Finds the depth of a pixel: coarsely, from a drawn `offset` of a step, and then between the steps beside the best.
static struct sight look(const struct photos *photos, const struct photo *photo, uint32_t x_px, uint32_t y_px,
                         double offset) {
    static const double middle[3] = {0.5, 0.5, 0.5}, next_px[2][2] = {{1.0, 0.0}, {0.0, 1.0}};
    double away = sqrt(distance2(photo->centre, middle)), radius = sqrt(0.75), at_px[2] = {x_px + 0.5, y_px + 0.5};
    double nearest = fmax(photos->nearest, away - radius),
           farthest = photos->in_box ? away + radius : nearest + FARTHEST,
           spacing = (1.0 / nearest - 1.0 / farthest) / DEPTHS;
    struct sight best = {true, x_px, y_px, (float)(2.0 / (1.0 / nearest + 1.0 / farthest)), -1.0f};
    struct patch patch;
    if (!read_patch(photo, at_px, next_px, &patch)) return best;
    sweep(photos, photo, &patch, 1.0 / farthest + offset * spacing, spacing, DEPTHS, &best);
    double finer = spacing / FINER, first = fmax(1.0 / best.depth - spacing, 1.0 / farthest) + finer;
    if (best.agreement > -1.0f) sweep(photos, photo, &patch, first, finer, 2 * FINER - 1, &best);
    return best;
}

// Draws pixels of a photo until others agree on the depth of one, and returns the best of them.
static struct sight draw_sight(const struct photos *photos, const struct photo *photo, uint64_t seed, uint32_t splat) {
    struct sight best = {.agreement = -2.0f};
    for (uint32_t draw = 0; draw < (best.found ? DRAWS : DRAWS_MOST) && best.agreement < SURE; draw++) {
        uint32_t words[4];
        float rgba[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, splat, 1 + draw, words);
        uint32_t x_px = vw_random_below(words[0], photo->view->camera.width_px),
                 y_px = vw_random_below(words[1], photo->view->camera.height_px);
        if (!read_pixel(photo, x_px, y_px, rgba)) continue;
        struct sight sight = look(photos, photo, x_px, y_px, vw_random_unit(words[2]));
        if (sight.agreement > best.agreement) best = sight;
    }
    return best;
}

// Gives each unsure sight of a photo the depth of the sure one that is nearest in the photo.
static void borrow_depths(struct sight *sights, uint32_t first, uint32_t stride, uint32_t count) {
    for (uint32_t i = first; i < count; i += stride) {
        double nearest2 = INFINITY;
        for (uint32_t k = first; k < count && sights[i].agreement < SURE; k += stride) {
            double x_px = (double)sights[k].x_px - sights[i].x_px, y_px = (double)sights[k].y_px - sights[i].y_px;
            if (sights[k].agreement < SURE || x_px * x_px + y_px * y_px >= nearest2) continue;
            nearest2 = x_px * x_px + y_px * y_px;
            sights[i].depth = sights[k].depth;
        }
    }
}

// ---- Photos --------------------------------------------------------------------------------------------------------

// Chooses others of a photo by rank, the nearest first, of those that look the same way: near ones look alike, and
// those farther apart tell depths.
static void choose_others(struct photos *photos, struct photo *photo) {
    static const uint32_t ranks[OTHERS] = {0, 1, 3, 6};
    enum { NEAR = 7 };
    uint32_t near[NEAR + 1], count = 0;
    for (uint32_t i = 0; i < photos->count; i++) {
        const struct photo *other = &photos->list[i];
        double away2 = distance2(photo->centre, other->centre);
        if (away2 == 0.0 || dot(photo->axes[2], other->axes[2]) < ALIKE) continue;
        uint32_t at = count < NEAR ? count++ : NEAR;
        for (; at > 0 && distance2(photo->centre, photos->list[near[at - 1]].centre) > away2; at--)
            near[at] = near[at - 1];
        near[at] = i;
    }
    for (uint32_t i = 0; i < OTHERS && i < count; i++)
        photo->others[photo->other_count++] = near[ranks[i] < count ? ranks[i] : i];
}

static enum vw_status list_photos(const struct vw_model *model, const struct vw_scene *scene, struct photos *photos) {
    uint32_t *views = vw_allocate(scene->view_count, sizeof *views);
    photos->list = vw_allocate(scene->view_count, sizeof *photos->list);
    enum vw_status status = views && photos->list ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count && !status; v++) {
        if (!vw_model_trains_on(model, scene, v)) continue;
        photos->list[photos->count] = photo_of(&scene->views[v], &model->box);
        views[photos->count++] = v;
    }
    if (!status) status = vw_scene_decode(scene, views, photos->count);
    for (uint32_t i = 0; i < photos->count && !status; i++) choose_others(photos, &photos->list[i]);
    free(views);
    return status;
}

// Places a splat at a sight, in its colour; leaves it where it is if its photo shows nothing.
static void place(const struct photo *photo, const struct sight *sight, float mean[3], float colour[3]) {
    double at[3];
    float rgba[4];
    if (!sight->found || !unproject(photo, sight->x_px + 0.5, sight->y_px + 0.5, sight->depth, at)) return;
    vw_image_pixel(&photo->view->image, sight->x_px, sight->y_px, rgba);
    for (int i = 0; i < 3; i++) {
        mean[i] = (float)at[i];
        colour[i] = rgba[i];
    }
}

enum vw_status vw_splats_place_by_photos(const struct vw_model *model, const struct vw_scene *scene, uint64_t seed,
                                         uint32_t count, float (*means)[3], float (*colours)[3]) {
    struct photos photos = {.in_box = scene->has_alpha, .nearest = NEAREST * vw_splat_model_of(model)->extent};
    struct sight *sights = vw_allocate(count, sizeof *sights);
    enum vw_status status = sights ? list_photos(model, scene, &photos) : VW_ERROR_MEMORY;
    uint32_t stride = photos.count;
    for (uint32_t i = 0; i < count && stride && !status; i++)
        sights[i] = draw_sight(&photos, &photos.list[i % stride], seed, i);
    for (uint32_t i = 0; i < stride && !status; i++) borrow_depths(sights, i, stride, count);
    for (uint32_t i = 0; i < count && stride && !status; i++)
        place(&photos.list[i % stride], &sights[i], means[i], colours[i]);
    free(photos.list);
    free(sights);
    return status;
}
