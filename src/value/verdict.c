#include "value/verdict.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/json.h"
#include "base/memory.h"
#include "base/statistics.h"
#include "ledger/find_image.h"
#include "value/halves.h"
#include "value/series.h"

struct pair {
    double *first, *second; // owned, in one allocation
    uint32_t count;
};

static enum vw_status create_pair(uint32_t count, struct pair *pair) {
    *pair = (struct pair){.first = vw_allocate(count, 2 * sizeof *pair->first), .count = count};
    if (!pair->first) return VW_ERROR_MEMORY;
    pair->second = pair->first + count;
    return VW_OK;
}

// ---- Epochs --------------------------------------------------------------------------------------------------------

// Adds each visit to the half of its epoch, and computes the correlation over the train photos.
static enum vw_status compare_epochs(const struct vw_value_input *input, const struct vw_series *series,
                                     struct pair *halves, struct vw_ranking_agreement *agreement) {
    uint32_t photos = 0, half = series->epoch_count / 2;
    for (uint64_t i = 0; i < series->count; i++) {
        const struct vw_visit *visit = &series->visits[i];
        if (isfinite(visit->delta))
            (visit->epoch < half ? halves->first : halves->second)[visit->image] += visit->delta;
    }
    for (uint32_t i = 0; i < input->image_count; i++) {
        if (strcmp(input->images[i].split, "train") != 0) continue;
        halves->first[photos] = halves->first[i];
        halves->second[photos++] = halves->second[i];
    }
    return vw_spearman(halves->first, halves->second, photos, &agreement->epoch_halves);
}

static enum vw_status measure_epochs(const struct vw_value_input *input, struct vw_ranking_agreement *agreement) {
    struct vw_series series = {0};
    struct pair halves = {0};
    enum vw_status status = vw_series_make(input, VW_MEASURE_PSNR, VW_FORM_STEP, &series);
    agreement->epochs = series.epoch_count;
    if (!status && series.epoch_count >= VW_AGREEMENT_EPOCHS_MIN) {
        status = create_pair(input->image_count, &halves);
        if (!status) status = compare_epochs(input, &series, &halves, agreement);
    }
    free(halves.first);
    vw_series_free(&series);
    return status;
}

// ---- Validation photos ---------------------------------------------------------------------------------------------

// Sums the columns of each half. Halves of an odd number differ by one photo.
static void sum_halves(const struct vw_value_input *input, const struct vw_matrix *matrix, const uint8_t *of_images,
                       struct pair *sums) {
    memset(sums->first, 0, sums->count * sizeof *sums->first);
    memset(sums->second, 0, sums->count * sizeof *sums->second);
    for (uint32_t v = 0; v < matrix->view_count; v++) {
        const struct vw_ledger_image *image = vw_ledger_find_image(input->images, input->image_count, matrix->views[v]);
        if (!image) continue;
        double *half = of_images[image - input->images] == VW_HALF_A ? sums->first : sums->second;
        for (uint32_t p = 0; p < matrix->photo_count; p++)
            half[p] += vw_matrix_weight(matrix, v) * matrix->psnr[(size_t)p * matrix->view_count + v];
    }
}

static enum vw_status measure_views(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                    struct vw_ranking_agreement *agreement) {
    struct pair sums = {0};
    uint8_t *of_images = vw_allocate(input->image_count, 1);
    enum vw_status status = of_images ? create_pair(matrix->photo_count, &sums) : VW_ERROR_MEMORY;
    double sum = 0;
    for (uint32_t division = 0; !status && division < VW_AGREEMENT_DIVISIONS; division++) {
        uint32_t sizes[VW_HALVES];
        double correlation = NAN;
        status = vw_halves_split(input->images, input->image_count, division, of_images, sizes);
        if (status) break;
        sum_halves(input, matrix, of_images, &sums);
        status = vw_spearman(sums.first, sums.second, sums.count, &correlation);
        sum += correlation / VW_AGREEMENT_DIVISIONS;
    }
    if (!status) agreement->view_halves = sum > 0 ? 2 * sum / (1 + sum) : sum;
    free(of_images);
    free(sums.first);
    return status;
}

// ---- A better training ---------------------------------------------------------------------------------------------

// The agreement that was measured, over the reliability.
static const double BETTER_TRAINING_SHARE = 0.85;

double vw_ranking_agreement_predict(const struct vw_ledger_score *scores, uint32_t score_count) {
    struct vw_spread spread = {0};
    double squared_errors = 0;
    for (uint32_t i = 0; i < score_count; i++) {
        const struct vw_ledger_score *score = &scores[i];
        if (strcmp(score->method, vw_value_default_method) != 0 || !isfinite(score->standard_error)) continue;
        vw_spread_add(&spread, score->value);
        squared_errors += score->standard_error * score->standard_error;
    }
    if (spread.count < 3) return NAN;
    return BETTER_TRAINING_SHARE * fmax(0, 1 - squared_errors / spread.count / vw_spread_variance(&spread));
}

enum vw_status vw_ranking_agreement_measure(const struct vw_value_input *input, const struct vw_matrix *matrix,
                                            const struct vw_ledger_score *scores, uint32_t score_count,
                                            struct vw_ranking_agreement *agreement) {
    *agreement = (struct vw_ranking_agreement){
        .epoch_halves = NAN, .better_training = vw_ranking_agreement_predict(scores, score_count), .view_halves = NAN};
    for (uint32_t v = 0; v < matrix->view_count; v++) agreement->view_count += vw_matrix_weight(matrix, v) > 0;
    enum vw_status status = measure_epochs(input, agreement);
    if (status || agreement->view_count < 2 || !matrix->visit_count) return status;
    return measure_views(input, matrix, agreement);
}

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
        "{s:I, s:I, s:o, s:o, s:o}", "epochs", (json_int_t)agreement->epochs, "views",
        (json_int_t)agreement->view_count, "epoch_halves", vw_json_real(agreement->epoch_halves), "better_training",
        vw_json_real(agreement->better_training), "view_halves", vw_json_real(agreement->view_halves));
    return json_pack("{s:s, s:o, s:o}", "verdict", vw_verdict_word(vw_verdict_judge(reconstruction)), "reconstruction",
                     vw_reconstruction_to_json(reconstruction), "ranking", ranking);
}
