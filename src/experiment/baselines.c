#include "experiment/baselines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "image/image.h"
#include "base/statistics.h"

static const uint64_t RANDOM_BASELINE_SEED = 0x636f6e74726f6c; // plus the run's: other numbers for every valued seed

static enum vw_status score_randomly(const struct vw_baseline_input *input, double *scores) {
    for (uint32_t i = 0; i < input->photo_count; i++) {
        uint32_t words[4];
        vw_random_words(RANDOM_BASELINE_SEED + input->seed, VW_RANDOM_ORDER, 0, input->photos[i], 0, words);
        scores[i] = vw_random_unit(words[0]);
    }
    return VW_OK;
}

static enum vw_status score_ground_truth(const struct vw_baseline_input *input, double *scores) {
    for (uint32_t i = 0; i < input->photo_count; i++) {
        const char *ground_truth = input->scene->views[input->photos[i]].ground_truth;
        scores[i] = !ground_truth || !strcmp(ground_truth, "clean");
    }
    return VW_OK;
}

// ---- Training loss ----

// The photo's losses in the order of its steps; returns how many are finite.
static uint32_t list_losses(const struct vw_baseline_input *input, uint32_t photo, double *losses) {
    uint32_t count = 0;
    for (uint64_t i = 0; i < input->record_count; i++)
        if (input->records[i].view == photo && isfinite(input->records[i].train_loss))
            losses[count++] = input->records[i].train_loss;
    return count;
}

static double final_loss(const double *losses, uint32_t count) { return count ? -losses[count - 1] : 0; }

static double loss_change(const double *losses, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 1; i < count; i++) sum += fabs(losses[i] - losses[i - 1]);
    return count > 1 ? sum / (count - 1) : 0;
}

static enum vw_status score_losses(const struct vw_baseline_input *input, double measure(const double *, uint32_t),
                                   double *scores) {
    double *losses = vw_allocate(input->record_count, sizeof *losses);
    if (!losses) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->photo_count; i++)
        scores[i] = measure(losses, list_losses(input, input->photos[i], losses));
    free(losses);
    return VW_OK;
}

static enum vw_status score_final_loss(const struct vw_baseline_input *input, double *scores) {
    return score_losses(input, final_loss, scores);
}

static enum vw_status score_loss_change(const struct vw_baseline_input *input, double *scores) {
    return score_losses(input, loss_change, scores);
}

// ---- The photo itself ----

static double luminance_at(const struct vw_scene *scene, const struct vw_view *view, uint32_t x_px, uint32_t y_px) {
    return vw_image_luminance(&view->image, x_px, y_px, scene->background);
}

// The variance of the Laplacian (Pech-Pacheco et al., ICPR 2000): low in blurred photos, high in noisy ones.
static double sharpness_of(const struct vw_scene *scene, const struct vw_view *view) {
    double sum = 0, squares = 0;
    uint64_t count = 0;
    for (uint32_t y = 1; y + 1 < view->image.height_px; y++)
        for (uint32_t x = 1; x + 1 < view->image.width_px; x++, count++) {
            double laplacian = luminance_at(scene, view, x - 1, y) + luminance_at(scene, view, x + 1, y) +
                               luminance_at(scene, view, x, y - 1) + luminance_at(scene, view, x, y + 1) -
                               4 * luminance_at(scene, view, x, y);
            sum += laplacian;
            squares += laplacian * laplacian;
        }
    return count ? squares / (double)count - pow(sum / (double)count, 2) : 0;
}

static enum vw_status score_sharpness(const struct vw_baseline_input *input, double *scores) {
    enum vw_status status = vw_scene_decode(input->scene, input->photos, input->photo_count);
    if (status) return status;
    for (uint32_t i = 0; i < input->photo_count; i++)
        scores[i] = sharpness_of(input->scene, &input->scene->views[input->photos[i]]);
    return VW_OK;
}

static double brightness_of(const struct vw_scene *scene, const struct vw_view *view) {
    double sum = 0;
    for (uint32_t y = 0; y < view->image.height_px; y++)
        for (uint32_t x = 0; x < view->image.width_px; x++) sum += luminance_at(scene, view, x, y);
    return sum / ((double)view->image.width_px * view->image.height_px);
}

static enum vw_status score_exposure(const struct vw_baseline_input *input, double *scores) {
    enum vw_status status = vw_scene_decode(input->scene, input->photos, input->photo_count);
    if (status) return status;
    double *sorted = vw_allocate(input->photo_count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < input->photo_count; i++)
        scores[i] = brightness_of(input->scene, &input->scene->views[input->photos[i]]);
    memcpy(sorted, scores, input->photo_count * sizeof *sorted);
    double median = vw_median(sorted, input->photo_count);
    for (uint32_t i = 0; i < input->photo_count; i++) scores[i] = -fabs(scores[i] - median);
    free(sorted);
    return VW_OK;
}

static enum vw_status score_points(const struct vw_baseline_input *input, double *scores) {
    for (uint32_t i = 0; i < input->photo_count; i++) {
        scores[i] = 0;
        for (uint32_t t = 0; t < input->scene->track_count; t++)
            scores[i] += input->scene->tracks[t].view == input->photos[i];
    }
    return VW_OK;
}

const struct vw_baseline vw_baselines[] = {
    {"ground_truth", "whether the photo is clean", score_ground_truth, 0},
    {"random", "a random number", score_randomly, 0},
    {"train_loss", "the photo's training loss at its last step, negated", score_final_loss, 1},
    {"loss_change", "mean absolute change of its training loss from step to step, a stand-in for its gradient norm",
     score_loss_change, 1},
    {"sharpness", "variance of the Laplacian of its luminance", score_sharpness, 0},
    {"exposure", "distance of its mean luminance from the median photo's, negated", score_exposure, 0},
    {"sfm_points", "number of SfM points that it sees", score_points, 0},
};
const uint32_t vw_baseline_count = VW_ARRAY_COUNT(vw_baselines);
