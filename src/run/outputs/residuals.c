#include "run/outputs/residuals.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/json.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"

enum { PANES = 3 };
#define FULL_ERROR 0.4f // white

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

static enum vw_status make_picture(const struct vw_residuals_params *params, uint32_t view, uint32_t height_px,
                                   double *psnr_db, void **data, size_t *size_bytes) {
    struct vw_panes panes = {0};
    enum vw_status status = vw_panes_make(&params->panes, view, height_px, &panes);
    if (!status) status = encode(&panes, psnr_db, data, size_bytes);
    vw_panes_free(&panes);
    return status;
}

// ---- Writing -------------------------------------------------------------------------------------------------------

// Makes a picture as base64, owned by the caller.
static enum vw_status make_text(const struct vw_residuals_params *params, uint32_t view, uint32_t height_px,
                                double *psnr_db, char **text) {
    void *data = NULL;
    size_t size_bytes = 0;
    enum vw_status status = make_picture(params, view, height_px, psnr_db, &data, &size_bytes);
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
    vw_json_set(&photo, "psnr", vw_json_real(psnr_db));
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
    vw_panes_choose_size(&params->panes.scene->views[middle->view].image, height_px, size_px);
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
        vw_panes_choose_size(&params->panes.scene->views[candidates[i].view].image, VW_RESIDUALS_HEIGHT_PX, size_px);
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

enum vw_status vw_residuals_write(const struct vw_residuals_params *params, struct vw_checksums *made) {
    char hash[VW_HASH_HEX_BYTES], *text = NULL;
    json_t *residuals = json_object(), *photos = json_array();
    enum vw_status status = add_photos(params, &photos);
    vw_hash_to_hex(params->panes.scene->hash, hash);
    vw_json_set(&residuals, "scene_hash", vw_json_string(hash));
    vw_json_set(&residuals, "photos", photos);
    if (!status) text = vw_json_to_text(residuals, JSON_COMPACT | JSON_REAL_PRECISION(6));
    if (!status)
        status = text ? vw_result_write(params->out, VW_RESIDUALS_FILE, text, strlen(text), made)
                      : vw_fail(VW_ERROR_MEMORY, "%s: out of memory for " VW_RESIDUALS_FILE, params->out);
    json_decref(residuals);
    free(text);
    return status;
}

// ---- Reading -------------------------------------------------------------------------------------------------------

static const char *find_broken(const json_t *photos, uint32_t image_count) {
    if (!json_is_array(photos) || json_array_size(photos) > VW_RESIDUALS_MAX) return "photos";
    for (size_t i = 0; i < json_array_size(photos); i++) {
        const json_t *photo = json_array_get(photos, i), *image = json_object_get(photo, "image"),
                     *psnr = json_object_get(photo, "psnr");
        if (!json_is_integer(image) || json_integer_value(image) < 0 || json_integer_value(image) >= image_count)
            return "image";
        if (!json_is_number(psnr) && !json_is_null(psnr)) return "psnr";
        if (!vw_is_webp_text(json_string_value(json_object_get(photo, "picture")))) return "picture";
    }
    return NULL;
}

enum vw_status vw_residuals_check(const char *path, json_t *residuals, const char *scene_hash, uint32_t image_count) {
    static const char remedy[] = "remove it, or value the photos again";
    const char *hash = json_string_value(json_object_get(residuals, "scene_hash"));
    if (!hash || strcmp(hash, scene_hash) != 0)
        return vw_fail(VW_ERROR_INPUT, "%s: is of another scene than the ledger; %s", path, remedy);
    const char *broken = find_broken(json_object_get(residuals, "photos"), image_count);
    return broken ? vw_fail(VW_ERROR_INPUT, "%s: %s: is not what the report needs; %s", path, broken, remedy) : VW_OK;
}
