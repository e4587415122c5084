#include "value/verdict.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"

static const struct {
    const char *key;
    size_t offset;
} reals[] = {
    {"psnr_db", offsetof(struct vw_reconstruction, psnr_db)},
    {"ssim", offsetof(struct vw_reconstruction, ssim)},
    {"mean_colour_db", offsetof(struct vw_reconstruction, mean_colour_db)},
    {"nearest_photo_db", offsetof(struct vw_reconstruction, nearest_photo_db)},
};

const struct vw_reconstruction vw_reconstruction_unknown = {
    .psnr_db = NAN, .ssim = NAN, .mean_colour_db = NAN, .nearest_photo_db = NAN};

json_t *vw_reconstruction_to_json(const struct vw_reconstruction *reconstruction) {
    const struct vw_reconstruction *seen = reconstruction;
    json_t *json = json_pack("{s:I, s:s, s:[I, I], s:[I, I]}", "views", (json_int_t)seen->view_count, "split",
                             seen->of_test ? "test" : "val", "trained_px", (json_int_t)seen->trained_px[0],
                             (json_int_t)seen->trained_px[1], "measured_px", (json_int_t)seen->measured_px[0],
                             (json_int_t)seen->measured_px[1]);
    for (size_t i = 0; i < VW_ARRAY_COUNT(reals); i++)
        vw_json_set(&json, reals[i].key,
                    vw_json_real(*(const double *)((const char *)reconstruction + reals[i].offset)));
    return json;
}

// Reads an array of two sizes.
static bool read_size(const json_t *json, const char *key, uint32_t size_px[2]) {
    json_int_t width = 0, height = 0;
    if (json_unpack(json_object_get(json, key), "[II!]", &width, &height)) return false;
    if (width < 0 || width > UINT32_MAX || height < 0 || height > UINT32_MAX) return false;
    size_px[0] = (uint32_t)width;
    size_px[1] = (uint32_t)height;
    return true;
}

const char *vw_reconstruction_from_json(const json_t *json, struct vw_reconstruction *reconstruction) {
    json_int_t views = json_integer_value(json_object_get(json, "views"));
    const char *split = json_string_value(json_object_get(json, "split"));
    if (!json_is_integer(json_object_get(json, "views")) || views < 0 || views > UINT32_MAX) return "views";
    if (!split || (strcmp(split, "test") != 0 && strcmp(split, "val") != 0)) return "split";
    *reconstruction = (struct vw_reconstruction){.view_count = (uint32_t)views, .of_test = strcmp(split, "test") == 0};
    if (!read_size(json, "trained_px", reconstruction->trained_px)) return "trained_px";
    if (!read_size(json, "measured_px", reconstruction->measured_px)) return "measured_px";
    for (size_t i = 0; i < VW_ARRAY_COUNT(reals); i++) {
        const json_t *number = json_object_get(json, reals[i].key);
        if (!json_is_number(number) && !json_is_null(number)) return reals[i].key;
        *(double *)((char *)reconstruction + reals[i].offset) =
            json_is_number(number) ? json_number_value(number) : NAN;
    }
    return NULL;
}

// PSNR above the better of the trivial predictions, in dB, and SSIM.
static const double USABLE_GAIN_DB = 3, USABLE_SSIM = 0.5, GOOD_GAIN_DB = 6, GOOD_SSIM = 0.7;

enum vw_verdict vw_verdict_judge(const struct vw_reconstruction *reconstruction) {
    double trivial_db = fmax(reconstruction->mean_colour_db, reconstruction->nearest_photo_db);
    double gain_db = reconstruction->psnr_db - trivial_db, ssim = reconstruction->ssim;
    if (isnan(gain_db) || isnan(ssim)) return VW_VERDICT_UNKNOWN;
    if (gain_db < USABLE_GAIN_DB || ssim < USABLE_SSIM) return VW_VERDICT_TOO_COARSE;
    return gain_db >= GOOD_GAIN_DB && ssim >= GOOD_SSIM ? VW_VERDICT_GOOD : VW_VERDICT_USABLE;
}

const char *vw_verdict_word(enum vw_verdict verdict) {
    static const char *const words[] = {"unknown", "too coarse to rank photos by", "usable", "good"};
    return words[verdict];
}

json_t *vw_verdict_to_json(const struct vw_reconstruction *reconstruction,
                           const struct vw_ranking_agreement *agreement) {
    json_t *ranking = json_pack(
        "{s:I, s:I, s:o, s:o, s:o, s:o, s:o, s:b}", "epochs", (json_int_t)agreement->epochs, "views",
        (json_int_t)agreement->view_count, "epoch_halves", vw_json_real(agreement->epoch_halves), "better_training",
        vw_json_real(agreement->better_training), "other_views", vw_json_real(agreement->other_views),
        "other_views_low", vw_json_real(agreement->other_views_low), "other_views_high",
        vw_json_real(agreement->other_views_high), "low", vw_ranking_agreement_is_low(agreement));
    return json_pack("{s:s, s:o, s:o}", "verdict", vw_verdict_word(vw_verdict_judge(reconstruction)), "reconstruction",
                     vw_reconstruction_to_json(reconstruction), "ranking", ranking);
}
