#include "experiment/measured_views.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/inside.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "train/trainer.h"

enum { ID_DIGITS = 16, PIXELS_OF_VIEW_MIN = 1 << 10 }; // digits of a retraining id that names have

// ---- Pictures ----

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

// ---- Measuring ----

static enum vw_status measure_whole(struct vw_trainer *trainer, const struct vw_saved_views *saved,
                                    const char *retraining_id, struct vw_measured_views *measured) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; !status && i < measured->count; i++) {
        struct vw_whole_view whole;
        status = vw_trainer_measure_whole(trainer, NULL, measured->views[i], &whole);
        if (status) break;
        measured->errors[i] = whole.error;
        status =
            vw_ssim(whole.rendered, whole.photo, whole.counts, whole.width_px, whole.height_px, &measured->ssims[i]);
        if (!status) status = save(saved, retraining_id, measured->views[i], &whole);
        vw_whole_view_free(&whole);
    }
    return status;
}

// Lists the validation and test photos, then the photos that the retraining asks for.
static enum vw_status list_views(const struct vw_scene *scene, const struct vw_retrain_params *retraining,
                                 struct vw_measured_views *measured) {
    uint32_t photo_count = retraining->photos_of == VW_RETRAIN_PHOTOS_GAINS ? 0 : retraining->photo_count,
             most = scene->view_count + photo_count;
    *measured = (struct vw_measured_views){.views = vw_allocate(most, sizeof *measured->views),
                                           .errors = vw_allocate(most, sizeof *measured->errors),
                                           .ssims = vw_allocate(most, sizeof *measured->ssims)};
    if (!measured->views || !measured->errors || !measured->ssims) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == VW_SPLIT_VAL || scene->views[v].split == VW_SPLIT_TEST)
            measured->views[measured->count++] = v;
    for (uint32_t i = 0; i < photo_count; i++) measured->views[measured->count++] = retraining->photos[i].image_id;
    for (uint32_t i = 0; i < measured->count; i++) measured->ssims[i] = NAN;
    return VW_OK;
}

// Averages over the measured views of a split, by their weights.
static void average_split(const struct vw_scene *scene, enum vw_split split, const struct vw_measured_views *measured,
                          double *psnr_db, double *ssim, double *l1) {
    double of_split = 0, ssim_sum = 0, with_ssim = 0;
    for (uint32_t v = 0; v < scene->view_count; v++)
        if (scene->views[v].split == split) of_split += scene->views[v].weight;
    *psnr_db = *l1 = of_split > 0 ? 0 : NAN;
    for (uint32_t i = 0; i < measured->count; i++) {
        const struct vw_view *view = &scene->views[measured->views[i]];
        if (view->split != split) continue;
        *psnr_db += view->weight * vw_psnr_db(measured->errors[i].mse) / of_split;
        *l1 += view->weight * measured->errors[i].l1 / of_split;
        if (isnan(measured->ssims[i])) continue;
        ssim_sum += view->weight * measured->ssims[i];
        with_ssim += view->weight;
    }
    *ssim = with_ssim > 0 ? ssim_sum / with_ssim : NAN;
}

static enum vw_status measure_shares(struct vw_trainer *trainer, const struct vw_scene *scene,
                                     struct vw_measured_views *measured) {
    uint32_t larger = scene->split_count[VW_SPLIT_VAL];
    if (larger < scene->split_count[VW_SPLIT_TEST]) larger = scene->split_count[VW_SPLIT_TEST];
    uint32_t pixels = VW_PIXELS_OF_SPLIT / (larger ? larger : 1);
    if (pixels < PIXELS_OF_VIEW_MIN) pixels = PIXELS_OF_VIEW_MIN;
    return vw_trainer_measure_views(trainer, measured->views, measured->count, pixels, measured->errors);
}

void vw_measured_views_free(struct vw_measured_views *measured) {
    free(measured->views);
    free(measured->errors);
    free(measured->ssims);
}

// Measures both splits at once, since setting up costs most when few pixels are measured.
enum vw_status vw_measured_views_make(struct vw_trainer *trainer, const struct vw_scene *scene,
                                      const struct vw_retrain_params *retraining, const struct vw_saved_views *saved,
                                      const char *retraining_id, struct vw_measured_views *measured,
                                      struct vw_retrain_result *result) {
    enum vw_status status = list_views(scene, retraining, measured);
    if (!status)
        status =
            saved ? measure_whole(trainer, saved, retraining_id, measured) : measure_shares(trainer, scene, measured);
    if (status) return status;
    average_split(scene, VW_SPLIT_VAL, measured, &result->val_psnr, &result->val_ssim, &result->val_l1);
    average_split(scene, VW_SPLIT_TEST, measured, &result->test_psnr, &result->test_ssim, &result->test_l1);
    return VW_OK;
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
