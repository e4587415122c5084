#include "run/outputs/residuals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "run/out_folder.h"

enum { WIDEST = 4, PANES = 3 };
#define FULL_ERROR 0.4f // white

// ---- Panes ---------------------------------------------------------------------------------------------------------

// Chooses a size of at most `height_px`, and at most four times as wide as high.
static void choose_size(const struct vw_image *image, uint32_t height_px, uint32_t size_px[2]) {
    size_px[1] = image->height_px < height_px ? image->height_px : height_px;
    uint64_t width_px = (uint64_t)image->width_px * size_px[1] / image->height_px;
    size_px[0] = width_px < 1 ? 1 : width_px > WIDEST * size_px[1] ? WIDEST * size_px[1] : (uint32_t)width_px;
}

static void read_photo(const struct vw_panes_params *params, uint32_t view, struct vw_panes *panes) {
    const struct vw_view *of_view = &params->scene->views[view];
    const struct vw_image *image = &of_view->image;
    for (uint32_t y = 0, pixel = 0; y < panes->size_px[1]; y++)
        for (uint32_t x = 0; x < panes->size_px[0]; x++, pixel++) {
            uint32_t column = (uint32_t)((2 * (uint64_t)x + 1) * image->width_px / (2 * (uint64_t)panes->size_px[0])),
                     row = (uint32_t)((2 * (uint64_t)y + 1) * image->height_px / (2 * (uint64_t)panes->size_px[1]));
            float rgba[4];
            vw_image_pixel(image, column, row, rgba);
            float alpha = params->on_background ? rgba[3] : 1;
            for (int c = 0; c < 3; c++)
                panes->photo[3 * pixel + c] = alpha * rgba[c] + (1 - alpha) * params->scene->background[c];
            panes->counts[pixel] = vw_view_keeps(of_view, column, row);
        }
}

void vw_panes_fit(const struct vw_panes *panes, uint32_t channel, const float *errors, double most, double *gain,
                  double *bias) {
    double n = 0, sum_r = 0, sum_p = 0, sum_rr = 0, sum_rp = 0;
    for (uint32_t i = 0; i < panes->size_px[0] * panes->size_px[1]; i++) {
        double r = panes->render[3 * i + channel], p = panes->photo[3 * i + channel];
        if (!panes->counts[i] || (errors && !(errors[i] <= most))) continue;
        n++, sum_r += r, sum_p += p, sum_rr += r * r, sum_rp += r * p;
    }
    double variance = n * sum_rr - sum_r * sum_r;
    *gain = variance > 0 ? (n * sum_rp - sum_r * sum_p) / variance : 1;
    *bias = n > 0 ? (sum_p - *gain * sum_r) / n : 0;
}

static void apply_fit(struct vw_panes *panes, uint32_t channel) {
    double gain, bias;
    vw_panes_fit(panes, channel, NULL, 0, &gain, &bias);
    for (uint32_t i = 0; i < panes->size_px[0] * panes->size_px[1]; i++)
        panes->render[3 * i + channel] = (float)(gain * panes->render[3 * i + channel] + bias);
}

enum vw_status vw_panes_make(const struct vw_panes_params *params, uint32_t view, uint32_t height_px,
                             struct vw_panes *panes) {
    choose_size(&params->scene->views[view].image, height_px, panes->size_px);
    size_t pixels = (size_t)panes->size_px[0] * panes->size_px[1];
    panes->photo = vw_allocate(pixels, 3 * sizeof *panes->photo);
    panes->counts = vw_allocate(pixels, 1);
    enum vw_status status = panes->photo && panes->counts
                                ? vw_trainer_render_small(params->trainer, view, panes->size_px, &panes->render)
                                : VW_ERROR_MEMORY;
    if (!status) read_photo(params, view, panes);
    for (uint32_t c = 0; c < 3 && !status && params->fitted; c++) apply_fit(panes, c);
    return status;
}

void vw_panes_free(struct vw_panes *panes) {
    free(panes->photo);
    free(panes->render);
    free(panes->counts);
    *panes = (struct vw_panes){0};
}

// ---- Which photos --------------------------------------------------------------------------------------------------

struct candidate {
    uint32_t view;
    double quality; // -1: validation photo; 2: unknown
    double psnr_db; // once it has a picture; infinite: unknown
    size_t place;   // its picture among the photos
};

static int compare_candidates(const void *left, const void *right) {
    const struct candidate *a = left, *b = right;
    if (a->quality != b->quality) return a->quality < b->quality ? -1 : 1;
    return a->view < b->view ? -1 : a->view > b->view;
}

static int compare_psnr(const void *left, const void *right) {
    const struct candidate *a = left, *b = right;
    if (a->psnr_db != b->psnr_db) return a->psnr_db < b->psnr_db ? -1 : 1;
    return a->view < b->view ? -1 : a->view > b->view;
}

double vw_residuals_quality(const struct vw_scoring *scoring, uint32_t view) {
    for (uint32_t i = 0; i < scoring->score_count; i++) {
        const struct vw_ledger_score *score = &scoring->scores[i];
        if (score->image_id == view && score->visits && strcmp(score->method, "quality") == 0) return score->value;
    }
    return 2;
}

static enum vw_status list_candidates(const struct vw_residuals_params *params, struct candidate **candidates,
                                      uint32_t *count) {
    const struct vw_scene *scene = params->panes.scene;
    *candidates = vw_allocate(scene->view_count, sizeof **candidates);
    if (!*candidates) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++) {
        enum vw_split split = scene->views[v].split;
        if (!scene->views[v].image.width_px || (split != VW_SPLIT_VAL && split != VW_SPLIT_TRAIN)) continue;
        double quality = split == VW_SPLIT_VAL ? -1 : vw_residuals_quality(params->scoring, v);
        (*candidates)[(*count)++] = (struct candidate){.view = v, .quality = quality};
    }
    qsort(*candidates, *count, sizeof **candidates, compare_candidates);
    return VW_OK;
}

double vw_residuals_rays(const struct vw_scoring *scoring, const struct vw_config *config) {
    double rays = (double)scoring->input.record_count * (3.0 * config->rays + config->val_rays);
    return fmax(VW_RESIDUALS_SHARE * rays, VW_RESIDUALS_RAYS_MIN);
}

// ---- One picture ---------------------------------------------------------------------------------------------------

// Puts the panes side by side, and takes the PSNR over the pixels that count.
static double join(const struct vw_panes *panes, float *rgb) {
    double squared_error = 0;
    uint64_t count = 0;
    uint32_t width = panes->size_px[0];
    for (uint32_t i = 0; i < width * panes->size_px[1]; i++) {
        float *target = rgb + 3 * ((size_t)(i / width) * PANES * width + i % width), error = 0;
        for (int c = 0; c < 3; c++) {
            float difference = panes->render[3 * i + c] - panes->photo[3 * i + c];
            target[c] = panes->photo[3 * i + c];
            target[3 * width + c] = fminf(fmaxf(panes->render[3 * i + c], 0), 1);
            error += fabsf(difference) / 3;
            if (panes->counts[i]) squared_error += (double)difference * difference, count++;
        }
        for (int c = 0; c < 3; c++) target[6 * width + c] = panes->counts[i] ? fminf(error / FULL_ERROR, 1) : 0;
    }
    return vw_psnr_db(squared_error / (double)count); // NaN when no pixel counts
}

static enum vw_status encode(const struct vw_panes *panes, double *psnr_db, void **data, size_t *size_bytes) {
    float *rgb = vw_allocate((size_t)panes->size_px[0] * panes->size_px[1], PANES * 3 * sizeof *rgb);
    if (!rgb) return VW_ERROR_MEMORY;
    *psnr_db = join(panes, rgb);
    enum vw_status status =
        vw_image_encode_webp(PANES * panes->size_px[0], panes->size_px[1], "webp:80", rgb, data, size_bytes);
    free(rgb);
    return status;
}

// Makes a picture as base64, owned by the caller.
static enum vw_status make_text(const struct vw_residuals_params *params, uint32_t view, uint32_t height_px,
                                double *psnr_db, char **text) {
    struct vw_panes panes = {0};
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = vw_panes_make(&params->panes, view, height_px, &panes);
    if (!status) status = encode(&panes, psnr_db, &data, &size_bytes);
    vw_panes_free(&panes);
    if (status) return status;
    *text = vw_webp_to_text(data, size_bytes);
    free(data);
    return *text ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status add_photo(const struct vw_residuals_params *params, struct candidate *candidate,
                                json_t **photos) {
    char *text = NULL;
    double psnr_db = NAN;
    enum vw_status status = make_text(params, candidate->view, VW_RESIDUALS_HEIGHT_PX, &psnr_db, &text);
    if (status) return status;
    candidate->psnr_db = isfinite(psnr_db) ? psnr_db : INFINITY;
    candidate->place = json_array_size(*photos);
    json_t *photo = json_object();
    vw_json_set(&photo, "image", json_integer(candidate->view));
    vw_json_set(&photo, "psnr", vw_json_rounded(psnr_db, VW_RESIDUALS_DIGITS));
    vw_json_set(&photo, "picture", vw_json_string(text));
    vw_json_append(photos, photo);
    free(text);
    return *photos ? VW_OK : vw_fail(VW_ERROR_MEMORY, "out of memory for " VW_RESIDUALS_FILE);
}

// Replaces the picture in the middle by a larger one, if enough rays are left. `candidates` are the validation photos,
// which it sorts.
static enum vw_status enlarge_middle(const struct vw_residuals_params *params, struct candidate *candidates,
                                     uint32_t count, double *left, json_t *photos) {
    uint32_t known = 0, size_px[2], height_px = VW_RESIDUALS_LARGE_PX;
    qsort(candidates, count, sizeof *candidates, compare_psnr);
    while (known < count && isfinite(candidates[known].psnr_db)) known++;
    if (!known) return VW_OK;
    const struct candidate *middle = &candidates[known / 2];
    choose_size(&params->panes.scene->views[middle->view].image, height_px, size_px);
    double rays = (double)size_px[0] * size_px[1];
    if (rays > *left) height_px = (uint32_t)(size_px[1] * sqrt(fmax(*left, 0) / rays));
    if (height_px <= VW_RESIDUALS_HEIGHT_PX) return VW_OK;
    *left -= fmin(rays, *left);
    char *text = NULL;
    double psnr_db;
    enum vw_status status = make_text(params, middle->view, height_px, &psnr_db, &text);
    bool fits = !status && strlen(text) <= VW_WEBP_TEXT_LIMIT_BYTES; // else the small one stays
    if (fits && json_object_set_new(json_array_get(photos, middle->place), "picture", vw_json_string(text)))
        status = vw_fail(VW_ERROR_MEMORY, "out of memory for " VW_RESIDUALS_FILE);
    free(text);
    return status;
}

// Adds as many as the rays that are left allow.
static enum vw_status add_some(const struct vw_residuals_params *params, struct candidate *candidates, uint32_t count,
                               double *left, json_t **photos) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && json_array_size(*photos) < VW_RESIDUALS_MAX && !status; i++) {
        uint32_t size_px[2];
        choose_size(&params->panes.scene->views[candidates[i].view].image, VW_RESIDUALS_HEIGHT_PX, size_px);
        *left -= (double)size_px[0] * size_px[1];
        if (*left < 0) break;
        status = add_photo(params, &candidates[i], photos);
    }
    return status;
}

static enum vw_status add_photos(const struct vw_residuals_params *params, json_t **photos) {
    struct candidate *candidates = NULL;
    uint32_t count = 0, validation = 0;
    double left = vw_residuals_rays(params->scoring, params->config);
    enum vw_status status = list_candidates(params, &candidates, &count);
    while (validation < count && candidates[validation].quality < 0) validation++;
    if (!status) status = add_some(params, candidates, validation, &left, photos);
    if (!status) status = enlarge_middle(params, candidates, (uint32_t)json_array_size(*photos), &left, *photos);
    if (!status) status = add_some(params, candidates + validation, count - validation, &left, photos);
    free(candidates);
    return status;
}

json_t *vw_scene_hash_to_json(const struct vw_scene *scene) {
    char hash[VW_HASH_HEX_BYTES];
    vw_hash_to_hex(scene->hash, hash);
    return json_string(hash);
}

enum vw_status vw_residuals_make(const struct vw_residuals_params *params, json_t **residuals) {
    json_t *made = json_object(), *photos = json_array();
    enum vw_status status = add_photos(params, &photos);
    vw_json_set(&made, "scene_hash", vw_scene_hash_to_json(params->panes.scene));
    vw_json_set(&made, "photos", photos);
    *residuals = made;
    return status;
}
