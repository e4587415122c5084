#include "experiment/whole_views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/inside.h"
#include "base/memory.h"
#include "image/image.h"
#include "train/trainer.h"

enum { ID_DIGITS = 16 }; // digits of a retraining id in names: enough to tell them apart

char *vw_saved_view_path(const struct vw_saved_views *saved, const char *retraining_id, uint32_t view) {
    return vw_format_text("%s/%.*s_%u.png", saved->folder, ID_DIGITS, retraining_id, view);
}

bool vw_saved_views_exist(const struct vw_saved_views *saved, const char *retraining_id) {
    bool exist = true;
    for (uint32_t i = 0; exist && i < saved->count; i++) {
        char *path = vw_saved_view_path(saved, retraining_id, saved->views[i]);
        exist = path && vw_file_exists_inside(saved->folder, path + strlen(saved->folder) + 1);
        free(path);
    }
    return exist;
}

static float clamp_unit(float value) { return fminf(fmaxf(value, 0), 1); } // a gain and a bias may leave [0,1]

static enum vw_status save_picture(const struct vw_whole_view *whole, const char *path) {
    size_t width_px = whole->width_px, row = 3 * width_px;
    float *picture = vw_allocate(2 * width_px * whole->height_px, 3 * sizeof *picture);
    if (!picture) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < row * whole->height_px; i++) {
        float *photo = picture + i / row * 2 * row + i % row;
        photo[0] = clamp_unit(whole->photo[i]);
        photo[row] = clamp_unit(whole->rendered[i]);
    }
    enum vw_status status = vw_image_save(path, 2 * whole->width_px, whole->height_px, 3, picture);
    free(picture);
    return status;
}

static enum vw_status save(const struct vw_saved_views *saved, const char *retraining_id, uint32_t view,
                           const struct vw_whole_view *whole) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < saved->count; i++) {
        if (saved->views[i] != view) continue;
        char *path = vw_saved_view_path(saved, retraining_id, view);
        status = path ? save_picture(whole, path) : VW_ERROR_MEMORY;
        free(path);
    }
    return status;
}

enum vw_status vw_whole_views_measure(struct vw_trainer *trainer, const uint32_t *views, uint32_t view_count,
                                      const struct vw_saved_views *saved, const char *retraining_id,
                                      struct vw_view_error *errors, double *ssims) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < view_count; i++) {
        struct vw_whole_view whole;
        status = vw_trainer_measure_whole(trainer, views[i], 0, &whole);
        if (status) break;
        errors[i] = whole.error;
        status = vw_ssim(whole.rendered, whole.photo, whole.counts, whole.width_px, whole.height_px, &ssims[i]);
        if (!status) status = save(saved, retraining_id, views[i], &whole);
        vw_whole_view_free(&whole);
    }
    return status;
}

// ---- Side by side ----

struct strip {
    float *pixels; // owned; rgb
    uint32_t width_px, height_px, column_px;
};

static void copy_column(const struct vw_image *picture, uint32_t from_px, uint32_t column, struct strip *strip) {
    for (uint32_t y = 0; y < strip->height_px; y++)
        for (uint32_t x = 0; x < strip->column_px; x++) {
            float rgba[4];
            vw_image_pixel(picture, from_px + x, y, rgba);
            memcpy(strip->pixels + 3 * ((size_t)y * strip->width_px + (size_t)column * strip->column_px + x), rgba,
                   3 * sizeof *rgba);
        }
}

// Begins the strip; the first picture sets the size of all.
static enum vw_status begin(const struct vw_image *picture, uint32_t columns, struct strip *strip) {
    strip->column_px = picture->width_px / 2;
    strip->width_px = columns * strip->column_px;
    strip->height_px = picture->height_px;
    strip->pixels = vw_allocate((size_t)strip->width_px * strip->height_px, 3 * sizeof *strip->pixels);
    if (!strip->pixels) return VW_ERROR_MEMORY;
    copy_column(picture, 0, 0, strip);
    return VW_OK;
}

static enum vw_status add(const char *path, uint32_t place, uint32_t count, struct strip *strip) {
    struct vw_image picture = {0};
    enum vw_status status = vw_image_load(path, 1, &picture);
    if (!status && !place) status = begin(&picture, 1 + count, strip);
    if (!status && (picture.width_px != 2 * strip->column_px || picture.height_px != strip->height_px))
        status = vw_fail(VW_ERROR_INPUT,
                         "%s: has another size than the other lists' pictures; delete it, and it is made again", path);
    if (!status) copy_column(&picture, strip->column_px, 1 + place, strip);
    vw_image_clear(&picture);
    return status;
}

enum vw_status vw_side_by_side_write(const char *to, char *const *pictures, uint32_t count) {
    struct strip strip = {0};
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < count; i++) status = add(pictures[i], i, count, &strip);
    if (!status) status = vw_image_save(to, strip.width_px, strip.height_px, 3, strip.pixels);
    free(strip.pixels);
    return status;
}
