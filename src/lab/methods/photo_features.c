#include "lab/methods/photo_features.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "lab/methods/photo_pixels.h"
#include "lab/methods/photo_sightings.h"
#include "lab/methods/photo_transport.h"
#include "scene/view_distance.h"

static const double LOSS_LEAST = 1e-12; // in a logarithm

const struct vw_feature_about vw_features[VW_FEATURE_COUNT] = {
    [VW_FEATURE_BRIGHTNESS] = {"brightness", "", "mean luminance", false},
    [VW_FEATURE_CONTRAST] = {"contrast", "", "standard deviation of the luminance", false},
    [VW_FEATURE_SHARPNESS] = {"sharpness", "", "variance of the Laplacian of the luminance", false},
    [VW_FEATURE_NOISE] = {"noise", "", "standard deviation of the noise, by Immerkaer's estimate", false},
    [VW_FEATURE_EXPOSURE] = {"exposure_distance", "", "distance of the brightness from the median photo's", false},
    [VW_FEATURE_SFM_POINTS] = {"sfm_points", "points", "SfM points that it sees", false},
    [VW_FEATURE_REPROJECTION_MEAN] = {"reprojection_mean_px", "px", "mean reprojection error of these", false},
    [VW_FEATURE_REPROJECTION_MEDIAN] = {"reprojection_median_px", "px", "median reprojection error of these", false},
    [VW_FEATURE_SFM_COVERAGE] = {"sfm_coverage", "", "its part of the places that validation photos see", false},
    [VW_FEATURE_OVERLAP_TRAIN] = {"overlap_train", "", "mean share of the other train photos that see its places",
                                  false},
    [VW_FEATURE_OVERLAP_VAL] = {"overlap_val", "", "mean share of the validation photos that see its places", false},
    [VW_FEATURE_NEAREST_RATIO] = {"nearest_ratio", "", "distance to the nearest train view, in typical distances",
                                  false},
    [VW_FEATURE_NEAREST_ANGLE] = {"nearest_angle_deg", "degrees", "angle between its axis and that view's", false},
    [VW_FEATURE_TRANSPORT] = {"transport", "", "calibrated gradient of the transport from train to validation photos",
                              false},
    [VW_FEATURE_LOSS_FIRST] = {"loss_first", "", "mean training loss in the first third of its steps", true},
    [VW_FEATURE_LOSS_LATE] = {"loss_late", "", "mean training loss in the last third of its steps", true},
    [VW_FEATURE_LOSS_LAST] = {"loss_last", "", "training loss at its last step", true},
    [VW_FEATURE_LOSS_RELATIVE] = {"loss_relative", "", "loss_late divided by the median photo's", true},
    [VW_FEATURE_LOSS_SLOPE] = {"loss_slope", "1/step", "slope of the logarithm of its training loss", true},
    [VW_FEATURE_LOSS_CHANGE] = {"loss_change", "", "mean absolute change of its training loss from step to step", true},
    [VW_FEATURE_CREDIT_PSNR] = {"credit_psnr_db", "dB", "mean change of validation PSNR by its steps after epoch 0",
                                true},
    [VW_FEATURE_CREDIT_L1] = {"credit_l1", "", "mean fall of the mean absolute validation error by these", true},
};

static double *row_of(const struct vw_photo_features *features, uint32_t seed, uint32_t photo) {
    return features->values + ((size_t)seed * features->photo_count + photo) * VW_FEATURE_COUNT;
}

double vw_photo_feature(const struct vw_photo_features *features, uint32_t seed, uint32_t photo,
                        enum vw_feature feature) {
    return row_of(features, seed, photo)[feature];
}

// Returns the median of a feature over the photos that have it; `scratch` has room for all photos.
static double median_of(const struct vw_photo_features *features, uint32_t seed, enum vw_feature feature,
                        double *scratch) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < features->photo_count; i++)
        if (isfinite(row_of(features, seed, i)[feature])) scratch[count++] = row_of(features, seed, i)[feature];
    return vw_median(scratch, count);
}

// ---- Photos, cameras, points: the same for all seeds, of which this fills the first ----

static enum vw_status measure_pixels(const struct vw_scene *scene, const uint32_t *photos,
                                     struct vw_photo_features *features) {
    uint32_t count = features->photo_count;
    struct vw_photo_pixels *pixels = vw_allocate(count, sizeof *pixels);
    double *scratch = vw_allocate(count, sizeof *scratch), *gradients = vw_allocate(count, sizeof *gradients);
    enum vw_status status = pixels && scratch && gradients ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_scene_decode(scene, photos, count);
    for (uint32_t i = 0; !status && i < count; i++) status = vw_photo_pixels_measure(scene, photos[i], &pixels[i]);
    if (!status) status = vw_photo_transport(scene, photos, count, pixels, gradients);
    for (uint32_t i = 0; !status && i < count; i++) {
        double *row = row_of(features, 0, i);
        row[VW_FEATURE_BRIGHTNESS] = pixels[i].luminance.brightness;
        row[VW_FEATURE_CONTRAST] = pixels[i].luminance.contrast;
        row[VW_FEATURE_SHARPNESS] = pixels[i].luminance.sharpness;
        row[VW_FEATURE_NOISE] = pixels[i].luminance.noise;
        row[VW_FEATURE_TRANSPORT] = gradients[i];
    }
    double median = status ? NAN : median_of(features, 0, VW_FEATURE_BRIGHTNESS, scratch);
    for (uint32_t i = 0; !status && i < count; i++)
        row_of(features, 0, i)[VW_FEATURE_EXPOSURE] = fabs(pixels[i].luminance.brightness - median);
    free(gradients);
    free(scratch);
    free(pixels);
    return status;
}

static enum vw_status measure_sightings(const struct vw_scene *scene, const uint32_t *photos,
                                        struct vw_photo_features *features) {
    struct vw_photo_sightings *sightings = vw_allocate(features->photo_count, sizeof *sightings);
    if (!sightings) return VW_ERROR_MEMORY;
    enum vw_status status = vw_photo_sightings_find(scene, photos, features->photo_count, sightings);
    for (uint32_t i = 0; !status && i < features->photo_count; i++) {
        double *row = row_of(features, 0, i);
        row[VW_FEATURE_SFM_POINTS] = sightings[i].points;
        row[VW_FEATURE_REPROJECTION_MEAN] = sightings[i].reprojection_mean_px;
        row[VW_FEATURE_REPROJECTION_MEDIAN] = sightings[i].reprojection_median_px;
        row[VW_FEATURE_SFM_COVERAGE] = sightings[i].coverage;
        row[VW_FEATURE_OVERLAP_TRAIN] = sightings[i].overlap_train;
        row[VW_FEATURE_OVERLAP_VAL] = sightings[i].overlap_val;
    }
    free(sightings);
    return status;
}

static enum vw_status measure_distances(const struct vw_scene *scene, const uint32_t *photos,
                                        struct vw_photo_features *features) {
    struct vw_view_distance *distances = NULL;
    uint32_t count = 0;
    enum vw_status status = vw_scene_view_distances(scene, VW_SPLIT_TRAIN, &distances, &count);
    for (uint32_t i = 0, next = 0; !status && i < features->photo_count; i++) {
        while (next < count && distances[next].view < photos[i]) next++;
        if (next == count || distances[next].view != photos[i]) continue; // it has no other
        row_of(features, 0, i)[VW_FEATURE_NEAREST_RATIO] = distances[next].ratio;
        row_of(features, 0, i)[VW_FEATURE_NEAREST_ANGLE] = distances[next].angle_deg;
    }
    free(distances);
    return status;
}

enum vw_status vw_photo_features_make(const struct vw_scene *scene, const uint32_t *photos, uint32_t photo_count,
                                      uint32_t seed_count, struct vw_photo_features *features) {
    size_t of_seed = (size_t)photo_count * VW_FEATURE_COUNT;
    *features = (struct vw_photo_features){.photo_count = photo_count, .seed_count = seed_count};
    features->values = vw_allocate(seed_count, of_seed * sizeof *features->values);
    if (!features->values) return VW_ERROR_MEMORY;
    for (size_t i = 0; i < of_seed; i++) features->values[i] = NAN;
    enum vw_status status = measure_pixels(scene, photos, features);
    if (!status) status = measure_sightings(scene, photos, features);
    if (!status) status = measure_distances(scene, photos, features);
    for (uint32_t seed = 1; seed < seed_count; seed++)
        memcpy(row_of(features, seed, 0), features->values, of_seed * sizeof *features->values);
    return status;
}

void vw_photo_features_free(struct vw_photo_features *features) {
    free(features->values);
    *features = (struct vw_photo_features){0};
}

// ---- The steps of a run ----

// Lists the photo's losses in the order of its steps; returns how many are finite.
static uint32_t list_losses(const struct vw_step_record *records, uint64_t record_count, uint32_t photo,
                            double *losses) {
    uint32_t count = 0;
    for (uint64_t i = 0; i < record_count; i++)
        if (records[i].view == photo && isfinite(records[i].train_loss)) losses[count++] = records[i].train_loss;
    return count;
}

static double mean_of(const double *values, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += values[i];
    return sum / count;
}

// Returns the slope of the line through the logarithms by least squares.
static double slope_of(const double *losses, uint32_t count) {
    double middle = (count - 1) / 2.0, products = 0, squares = 0;
    for (uint32_t i = 0; i < count; i++) {
        products += (i - middle) * log(fmax(losses[i], LOSS_LEAST));
        squares += (i - middle) * (i - middle);
    }
    return count > 1 ? products / squares : NAN;
}

static double change_of(const double *losses, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 1; i < count; i++) sum += fabs(losses[i] - losses[i - 1]);
    return count > 1 ? sum / (count - 1) : NAN;
}

static void fill_losses(const double *losses, uint32_t count, double *row) {
    uint32_t third = (count + 2) / 3;
    if (!count) return;
    row[VW_FEATURE_LOSS_FIRST] = mean_of(losses, third);
    row[VW_FEATURE_LOSS_LATE] = mean_of(losses + count - third, third);
    row[VW_FEATURE_LOSS_LAST] = losses[count - 1];
    row[VW_FEATURE_LOSS_SLOPE] = slope_of(losses, count);
    row[VW_FEATURE_LOSS_CHANGE] = change_of(losses, count);
}

// Fills the credits as dv_psnr and dv_loss (viewworth/value.h), per step. Without validation they stay unknown.
static void fill_credits(const struct vw_step_record *records, uint64_t record_count, uint32_t photo, double *row) {
    double psnr_db = 0, l1 = 0;
    const struct vw_step_record *before = NULL;
    uint32_t count = 0;
    for (uint64_t i = 0; i < record_count; i++) {
        const struct vw_step_record *record = &records[i];
        if (!record->validated || !isfinite(record->val_psnr) || !isfinite(record->val_l1)) continue;
        if (before && record->view == photo && record->epoch > 0) {
            psnr_db += record->val_psnr - before->val_psnr;
            l1 += before->val_l1 - record->val_l1;
            count++;
        }
        before = record;
    }
    if (!count) return;
    row[VW_FEATURE_CREDIT_PSNR] = psnr_db / count;
    row[VW_FEATURE_CREDIT_L1] = l1 / count;
}

enum vw_status vw_photo_features_add_run(struct vw_photo_features *features, uint32_t seed, const uint32_t *photos,
                                         const struct vw_step_record *records, uint64_t record_count) {
    uint32_t photo_count = features->photo_count;
    double *losses = vw_allocate(record_count, sizeof *losses), *scratch = vw_allocate(photo_count, sizeof *scratch);
    enum vw_status status = losses && scratch ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < photo_count; i++) {
        fill_losses(losses, list_losses(records, record_count, photos[i], losses), row_of(features, seed, i));
        fill_credits(records, record_count, photos[i], row_of(features, seed, i));
    }
    double median = status ? NAN : median_of(features, seed, VW_FEATURE_LOSS_LATE, scratch);
    for (uint32_t i = 0; !status && i < photo_count; i++) {
        double *row = row_of(features, seed, i);
        row[VW_FEATURE_LOSS_RELATIVE] = median > 0 ? row[VW_FEATURE_LOSS_LATE] / median : NAN;
    }
    free(losses);
    free(scratch);
    return status;
}
