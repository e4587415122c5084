#include "detect/pilot_run.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "detect/occupied_share.h"
#include "train/effects/registry.h"
#include "train/evaluator.h"
#include "train/pixels.h"
#include "train/trainer.h"

enum {
    STEPS = 128,
    STEPS_PER_BATCH = 32,
    PHOTOS_MAX = 32, // whose exposure is measured, evenly spaced: bounds the work
    PHOTOS_MIN = 4,
    PIXELS_PER_PHOTO = 256,
    PIXELS_MIN = 12, // of half a photo, comparable ones
};
static const double MISFIT =
    0.1; // what photos of one exposure show at most after so few steps (0.02 to 0.1, tests/train/test_detection.c)

static struct vw_config pilot_config(void) {
    struct vw_config config = vw_config_default;
    config.rays = 256;
    config.levels = 4;
    config.growth = 1.8;
    config.width = 16;
    config.learning_rate = 1e-2;
    config.loss = VW_LOSS_L1; // whatever the run takes: sharper after so few steps, and thresholds were found with it
    config.epochs = STEPS; // more than enough
    return config;
}

// The number of steps depends on the sizes of batches alone, which are fixed.
static enum vw_status take_steps(struct vw_trainer *trainer) {
    const struct vw_step_record *records;
    uint32_t count = 1;
    uint64_t last = 0;
    enum vw_status status = VW_OK;
    while (status == VW_OK && count > 0 && last < STEPS) {
        status = vw_trainer_advance(trainer, &records, &count);
        if (status == VW_OK && count > 0) last = records[count - 1].step;
    }
    while (status == VW_OK && count > 0) status = vw_trainer_collect(trainer, &records, &count);
    return status;
}

// ---- Exposure -------------------------------------------------------------------------------------------------------

static double channel_of(vw_float4 colour, int channel) {
    return channel == 0 ? colour.x : channel == 1 ? colour.y : colour.z;
}

// The log gain of either half of a photo, of all that can be compared: log(sum of photo / sum of render), which blur
// alone does not move.
static bool half_gains(const struct vw_pixel *pixels, const vw_float4 *colours, uint32_t count, double middle_px,
                       int channel, double gains[2]) {
    double here[2] = {0.0}, rendered[2] = {0.0};
    uint32_t used[2] = {0};
    for (uint32_t i = 0; i < count; i++) {
        double photo = channel_of(pixels[i].rgba, channel), render = channel_of(colours[i], channel);
        bool comparable = photo > EVIDENCE_DARK && photo < EVIDENCE_SATURATED && render > EVIDENCE_DARK &&
                          render < EVIDENCE_SATURATED;
        if (pixels[i].weight != 1.0f || pixels[i].rgba.w != 1.0f || !comparable) continue;
        int half = pixels[i].x_px > middle_px;
        here[half] += photo;
        rendered[half] += render;
        used[half]++;
    }
    for (int half = 0; half < 2; half++) gains[half] = log(here[half] / rendered[half]);
    return used[0] >= PIXELS_MIN && used[1] >= PIXELS_MIN;
}

// A photo's exposure changes both halves equally; what the short run has not fitted yet changes each on its own. Their
// difference estimates that part.
static double common_spread(double *means, double *halved_differences, uint32_t count) {
    double all = vw_robust_spread(means, count), own = vw_robust_spread(halved_differences, count);
    return sqrt(fmax(all * all - own * own - MISFIT * MISFIT, 0.0));
}

// The photos that are compared with their renders, and where.
struct comparison {
    const struct vw_scene *scene;
    bool masks; // mask files are obeyed
    struct evaluator evaluator;
    struct vw_pixel *pixels; // of one photo
    vw_float4 *colours;
};

// Renders fixed pixels of a photo. Adds, of each channel in which both halves can be compared, the mean of their gains
// and half of their difference.
static enum vw_status measure_photo(struct comparison *compared, uint32_t view, double *means,
                                    double *halved_differences, uint32_t *count) {
    const struct vw_scene *scene = compared->scene;
    double gains[2], middle_px = scene->views[view].image.width_px / 2.0;
    uint32_t taken =
        pixels_stratify(scene, view, pixels_all_columns(scene, view), 0, PIXELS_PER_PHOTO, compared->pixels);
    if (!compared->masks) pixels_unmask(scene, compared->pixels, taken);
    enum vw_status status = evaluator_render(&compared->evaluator, compared->pixels, taken, compared->colours);
    for (int channel = 0; channel < 3 && status == VW_OK; channel++) {
        if (!half_gains(compared->pixels, compared->colours, taken, middle_px, channel, gains)) continue;
        means[*count] = 0.5 * (gains[0] + gains[1]);
        halved_differences[(*count)++] = 0.5 * (gains[0] - gains[1]);
    }
    return status;
}

// Of photos that are trained on.
static enum vw_status measure_photos(struct comparison *compared, double *spread) {
    double means[3 * PHOTOS_MAX], halved_differences[3 * PHOTOS_MAX];
    uint32_t *views = NULL, view_count = 0, count = 0;
    enum vw_status status = vw_scene_list_views(compared->scene, VW_SPLIT_TRAIN, &views, &view_count);
    uint32_t stride = (view_count + PHOTOS_MAX - 1) / PHOTOS_MAX;
    for (uint32_t i = 0; i < view_count && status == VW_OK; i += stride)
        status = measure_photo(compared, views[i], means, halved_differences, &count);
    if (status == VW_OK && count >= 3 * PHOTOS_MIN) *spread = common_spread(means, halved_differences, count);
    free(views);
    return status;
}

static enum vw_status measure_exposure(struct field *field, const struct vw_scene *scene, bool masks, double *spread) {
    struct comparison compared = {.scene = scene,
                                  .masks = masks,
                                  .pixels = vw_allocate(PIXELS_PER_PHOTO, sizeof *compared.pixels),
                                  .colours = vw_allocate(PIXELS_PER_PHOTO, sizeof *compared.colours)};
    enum vw_status status = compared.pixels && compared.colours
                                ? evaluator_create(field, PIXELS_PER_PHOTO, &compared.evaluator)
                                : VW_ERROR_MEMORY;
    if (status == VW_OK) status = measure_photos(&compared, spread);
    evaluator_destroy(&compared.evaluator);
    free(compared.pixels);
    free(compared.colours);
    return status;
}

enum vw_status pilot_run(struct vw_gpu *gpu, const struct vw_scene *scene, const struct vw_effect_verdict *verdicts,
                         uint32_t count, struct pilot_findings *findings) {
    const struct vw_config config = pilot_config();
    const struct vw_trainer_params params = {.gpu = gpu,
                                             .scene = scene,
                                             .config = &config,
                                             .effects = verdicts,
                                             .effect_count = count,
                                             .steps_per_batch = STEPS_PER_BATCH};
    struct vw_trainer *trainer = NULL;
    double occupied = NAN;
    bool masks = effects_obey_masks(scene, verdicts, count);
    *findings = (struct pilot_findings){.gain_spread = NAN, .empty_share = NAN};
    enum vw_status status = vw_trainer_create(&params, &trainer);
    if (status == VW_OK) status = take_steps(trainer);
    if (status == VW_OK) status = measure_exposure(vw_trainer_field(trainer), scene, masks, &findings->gain_spread);
    if (status == VW_OK) status = occupied_share(vw_trainer_field(trainer), config.samples, &occupied);
    findings->empty_share = 1.0 - occupied;
    vw_trainer_destroy(&trainer);
    return status;
}
