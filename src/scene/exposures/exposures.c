// The exposure of each train photo, from the points of structure from motion, and what that explains of other points.
#include "scene/exposures/exposures.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "base/memory.h"
#include "scene/exposures/fit.h"

static const double OUTLIER_SPREADS = 3.0; // observations that neither fit explains tell nothing of either

struct estimate {
    struct observations observations;
    struct exposure_fit with, without; // exposures; without, photos keep the identity
    struct exposure_work work;
    struct tally {
        double without, with, differences_squared, count;
    } * tallies; // by view
};

// ---- Evidence -------------------------------------------------------------------------------------------------------

// Adds squared errors of predictions from the other photos of a point. Times (n - 1) / n they estimate without bias
// what a photo adds to the error of a field that all photos share.
static void judge_point(const struct estimate *estimate, uint32_t point, int channel) {
    const struct observations *observations = &estimate->observations;
    const struct exposure_fit *without = &estimate->without, *with = &estimate->with;
    const struct exposure_colour_sums all_without = vw_exposure_sum_point(without, point),
                                      all_with = vw_exposure_sum_point(with, point);
    uint32_t begin = vw_observations_begin(observations, point), end = observations->ends[point];
    double limit = pow(OUTLIER_SPREADS * with->spread, 2), seen = 0.0;
    for (uint32_t o = begin; o < end; o++) seen += !isnan(observations->list[o].value[channel]);
    for (uint32_t o = begin; o < end && seen > 1.0; o++) {
        if (isnan(observations->list[o].value[channel])) continue;
        double error_without = pow(vw_exposure_miss(without, &all_without, o), 2),
               error_with = pow(vw_exposure_miss(with, &all_with, o), 2);
        if (!(fmin(error_without, error_with) <= limit)) continue;
        struct tally *tally = &estimate->tallies[observations->list[o].view];
        double share = (seen - 1.0) / seen;
        tally->without += share * error_without;
        tally->with += share * error_with;
        tally->differences_squared += pow(share * (error_without - error_with), 2);
        tally->count++;
    }
}

static void judge_fold(struct estimate *estimate, uint32_t fold, int channel) {
    uint32_t points = estimate->observations.point_count;
    bool *used = estimate->work.used;
    for (uint32_t p = 0; p < points; p++) used[p] = p % EXPOSURE_FOLDS != fold;
    vw_exposure_fit_channel(&estimate->work, &estimate->without, channel, false);
    vw_exposure_fit_channel(&estimate->work, &estimate->with, channel, true);
    for (uint32_t p = 0; p < points; p++)
        if (!used[p]) judge_point(estimate, p, channel);
}

static void judge(struct estimate *estimate, struct vw_exposure *exposures) {
    for (uint32_t fold = 0; fold < EXPOSURE_FOLDS; fold++)
        for (int channel = 0; channel < EXPOSURE_CHANNELS; channel++) judge_fold(estimate, fold, channel);
    for (uint32_t v = 0; v < estimate->observations.view_count; v++) {
        const struct tally *tally = &estimate->tallies[v];
        double count = tally->count, mean = (tally->without - tally->with) / count;
        if (count < EXPOSURE_OBSERVATIONS_MIN * EXPOSURE_CHANNELS) continue;
        exposures[v].error_without = tally->without / count;
        exposures[v].error_with = tally->with / count;
        // The channels of an observation say much the same.
        exposures[v].reduction_stderr =
            sqrt(fmax(tally->differences_squared / count - mean * mean, 0.0) * EXPOSURE_CHANNELS / count);
    }
}

// ---- The estimate ---------------------------------------------------------------------------------------------------

static void count_observations(const struct observations *observations, struct vw_exposure *exposures) {
    for (uint32_t o = 0; o < observations->count; o++) {
        const double *value = observations->list[o].value;
        exposures[observations->list[o].view].observation_count +=
            !isnan(value[0]) && !isnan(value[1]) && !isnan(value[2]);
    }
}

static void take_fit(const struct exposure_fit *fit, struct vw_exposure *exposures) {
    for (uint32_t v = 0; v < fit->observations->view_count; v++) {
        if (exposures[v].observation_count < EXPOSURE_OBSERVATIONS_MIN) continue;
        exposures[v].gain[fit->channel] = fit->gains[v];
        exposures[v].bias[fit->channel] = fit->biases[v];
    }
}

static enum vw_status begin(const struct vw_scene *scene, struct estimate *estimate) {
    enum vw_status status = vw_observations_list(scene, &estimate->observations);
    if (!status) status = vw_exposure_work_create(&estimate->observations, &estimate->work);
    if (!status) status = vw_exposure_fit_create(&estimate->observations, &estimate->without);
    if (!status) status = vw_exposure_fit_create(&estimate->observations, &estimate->with);
    estimate->tallies = vw_allocate(scene->view_count, sizeof *estimate->tallies);
    return !status && !estimate->tallies ? VW_ERROR_MEMORY : status;
}

static void end(const struct estimate *estimate) {
    vw_observations_release(&estimate->observations);
    vw_exposure_work_release(&estimate->work);
    vw_exposure_fit_release(&estimate->without);
    vw_exposure_fit_release(&estimate->with);
    free(estimate->tallies);
}

static enum vw_status estimate_all(const struct vw_scene *scene, struct vw_exposure *exposures) {
    struct estimate estimate = {0};
    enum vw_status status = begin(scene, &estimate);
    if (!status) count_observations(&estimate.observations, exposures);
    if (!status) judge(&estimate, exposures);
    for (uint32_t p = 0; p < scene->point_count && !status; p++) estimate.work.used[p] = true;
    for (int channel = 0; channel < EXPOSURE_CHANNELS && !status; channel++) {
        vw_exposure_fit_channel(&estimate.work, &estimate.with, channel, true);
        take_fit(&estimate.with, exposures);
    }
    end(&estimate);
    return status;
}

static enum vw_status create(const struct vw_scene *scene, struct vw_exposure **exposures) {
    uint32_t *views = NULL, count = 0;
    *exposures = vw_allocate(scene->view_count, sizeof **exposures);
    if (!*exposures) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        (*exposures)[v].error_without = (*exposures)[v].error_with = (*exposures)[v].reduction_stderr = NAN;
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &views, &count);
    if (!status && scene->track_count) status = vw_scene_decode(scene, views, count);
    if (!status && scene->track_count) status = estimate_all(scene, *exposures);
    free(views);
    if (status) free(*exposures);
    return status;
}

struct sharing {
    uint32_t shared, latest; // points that another train photo sees, too; 1 + the latest point
};

static void count_shared(const struct vw_scene *scene, uint32_t point, struct sharing *views) {
    const struct vw_track *tracks = &scene->tracks[scene->points[point].first_track];
    uint32_t count = scene->points[point].track_count, photos = 0;
    for (uint32_t t = 0; t < count; t++) {
        struct sharing *view = &views[tracks[t].view];
        if (scene->views[tracks[t].view].split != VW_SPLIT_TRAIN || view->latest == point + 1) continue;
        view->latest = point + 1;
        photos++;
    }
    for (uint32_t t = 0; t < count && photos > 1; t++) {
        struct sharing *view = &views[tracks[t].view];
        view->shared += view->latest == point + 1;
        view->latest = 0; // a photo may see a point twice
    }
}

enum vw_status vw_scene_ask_points_for_exposures(struct vw_scene *scene) {
    struct sharing *views = vw_allocate(scene->view_count, sizeof *views);
    uint32_t telling = 0;
    if (!views) return VW_ERROR_MEMORY;
    for (uint32_t p = 0; p < scene->point_count; p++) count_shared(scene, p, views);
    for (uint32_t v = 0; v < scene->view_count; v++) telling += views[v].shared >= EXPOSURE_OBSERVATIONS_MIN;
    free(views);
    scene->points_tell_exposures = telling > 0 && 2 * telling >= scene->split_count[VW_SPLIT_TRAIN];
    return VW_OK;
}

double vw_exposure_brightness(const struct vw_exposure *exposure) {
    double sum = 0.0;
    for (int i = 0; i < EXPOSURE_CHANNELS; i++) sum += 1.0 + exposure->gain[i] + 2.0 * exposure->bias[i];
    return sum / EXPOSURE_CHANNELS;
}

enum vw_status vw_scene_estimate_exposures(const struct vw_scene *scene, const struct vw_exposure **exposures) {
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    struct vw_exposure *estimated = NULL;
    enum vw_status status = VW_OK;
    pthread_mutex_lock(&lock);
    if (!scene->exposures) status = create(scene, &estimated);
    // Nothing else of the scene changes, and no scene is an object that was defined const.
    if (!status && estimated) ((struct vw_scene *)(uintptr_t)scene)->exposures = estimated;
    *exposures = scene->exposures;
    pthread_mutex_unlock(&lock);
    return status;
}
