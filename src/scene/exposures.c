// The exposure of each train photo, from the points of structure from motion: a point is seen by several photos, and
// each shows its colour with a gain and a bias of its own.
//
// Per channel, with L_p the colour of point p and c_ip that of its pixel in photo i, gains 1 + g_i, biases b_i and
// colours L_p minimise
//   sum_ip rho(c_ip - (1 + g_i) L_p - b_i) + sum_i (RIDGE (g_i^2 + b_i^2) + BIAS_PULL n_i b_i^2)
// by Gauss-Newton steps; rho is Huber's, so that specular points and people who walk by count less. A bias takes
// up the lost contrast of a blurred photo sooner than a change of exposure: without its pull, two blurred photos of
// scenes/courtyard.json have gains of 0.5, with it 0.75.
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "viewworth/scene.h"

enum {
    CHANNELS = 3,
    OBSERVATIONS_MIN = 8, // per photo; with fewer it keeps the identity
    FOLDS = 2,            // parts of the points; each is judged by a fit to the others
    STEPS = 16,
    STEPS_OF_LENGTH = 13, // after which rho stays as it is
    CONJUGATE_STEPS = 40,
};
static const double RIDGE = 0.1; // as if one observation were off by 0.3 for a gain or a bias of 1
static const double BIAS_PULL = 0.1;
static const double SLOPE_LEFT = 1e-2;                // share, where conjugate gradients stop
static const double STEP_MOST = 0.3;                  // share of a gain at a time, as the sum is far from quadratic
static const double DARKEST = 0.01, BRIGHTEST = 0.99; // beyond, a channel may be clipped
static const double HUBER_SPREADS = 1.345;            // 95 % as efficient as least squares where errors are normal
static const double SPREAD_MIN = 1.0 / 255.0;         // that of rounding
static const double OUTLIER_SPREADS = 3.0;            // observations that neither fit explains tell nothing of either

struct observation {
    uint32_t view;
    double value[CHANNELS]; // NaN: unusable
};

// Observations of train photos, point by point.
struct observations {
    struct observation *list;
    uint32_t *ends; // by point
    uint32_t point_count, count, view_count;
};

// A fit of one channel.
struct fit {
    const struct observations *observations;
    int channel;
    double *colours;        // by point; NaN: unknown
    double *gains, *biases; // by view; gains minus 1
    double *residuals;      // by observation; NaN: unusable
    double huber_length;    // residuals beyond it count less
};

// A gain and a bias of each view, or what belongs to these numbers.
struct pair {
    double gain, bias;
};

struct work {
    struct observations observations;
    struct fit with, without;                                // exposures; without, photos keep the identity
    bool *used;                                              // by point: the fit sees it
    uint32_t *counts;                                        // by view: observations in use
    struct pair *slope, *scale, *step, *direction, *product; // by view: of a Gauss-Newton step
    double *sorted;                                          // scratch, by observation or view
    struct tally {
        double without, with, differences_squared, count;
    } * tallies; // by view
};

// ---- Observations ---------------------------------------------------------------------------------------------------

// Reads a photo between pixel centres, bilinearly; NaN where one of the four pixels does not count or may be clipped.
static void read_pixel(const struct vw_view *view, const struct vw_track *track, double value[CHANNELS]) {
    const struct vw_image *image = &view->image;
    double x = track->x_px - 0.5, y = track->y_px - 0.5, left = floor(x), top = floor(y);
    bool inside = left >= 0 && top >= 0 && left + 1 < image->width_px && top + 1 < image->height_px;
    for (int channel = 0; channel < CHANNELS; channel++) value[channel] = inside ? 0.0 : NAN;
    for (uint32_t corner = 0; inside && corner < 4; corner++) {
        uint32_t right = corner & 1, below = corner >> 1, x_px = (uint32_t)left + right, y_px = (uint32_t)top + below;
        double weight = (right ? x - left : 1 - x + left) * (below ? y - top : 1 - y + top);
        float rgba[4];
        vw_image_pixel(image, x_px, y_px, rgba);
        bool counts = rgba[3] == 1.0f && vw_view_keeps(view, x_px, y_px);
        for (int channel = 0; channel < CHANNELS; channel++) {
            bool usable = counts && rgba[channel] >= DARKEST && rgba[channel] <= BRIGHTEST;
            value[channel] += usable ? weight * rgba[channel] : NAN;
        }
    }
}

// Makes a channel unusable in which a point has a single value: that would only say of its photo what the fit says.
static void drop_single(struct observation *observations, uint32_t count) {
    for (int channel = 0; channel < CHANNELS; channel++) {
        uint32_t usable = 0;
        for (uint32_t i = 0; i < count; i++) usable += !isnan(observations[i].value[channel]);
        for (uint32_t i = 0; i < count && usable == 1; i++) observations[i].value[channel] = NAN;
    }
}

static enum vw_status list_observations(const struct vw_scene *scene, struct observations *observations) {
    *observations = (struct observations){.list = vw_allocate(scene->track_count, sizeof *observations->list),
                                          .ends = vw_allocate(scene->point_count, sizeof *observations->ends),
                                          .point_count = scene->point_count,
                                          .view_count = scene->view_count};
    uint32_t *latest = vw_allocate(scene->view_count, sizeof *latest), count = 0; // by view: 1 + its latest point
    if (!observations->list || !observations->ends || !latest) {
        free(latest);
        return VW_ERROR_MEMORY;
    }
    for (uint32_t p = 0; p < scene->point_count; p++) {
        const struct vw_point *point = &scene->points[p];
        uint32_t begin = count;
        for (uint32_t t = 0; t < point->track_count; t++) {
            const struct vw_track *track = &scene->tracks[point->first_track + t];
            const struct vw_view *view = &scene->views[track->view];
            if (view->split != VW_SPLIT_TRAIN || latest[track->view] == p + 1) continue;
            latest[track->view] = p + 1;
            observations->list[count].view = track->view;
            read_pixel(view, track, observations->list[count++].value);
        }
        drop_single(observations->list + begin, count - begin);
        observations->ends[p] = count;
    }
    observations->count = count;
    free(latest);
    return VW_OK;
}

static uint32_t begin_of(const struct observations *observations, uint32_t point) {
    return point ? observations->ends[point - 1] : 0;
}

// ---- The fit of one channel -----------------------------------------------------------------------------------------

static double weight_of(const struct fit *fit, uint32_t observation) {
    double size = fabs(fit->residuals[observation]);
    return size > fit->huber_length ? fit->huber_length / size : 1.0;
}

// Sums over the observations of a point; their ratio is its colour.
struct colour_sums {
    double squares, products;
};

static void add_observation(const struct fit *fit, uint32_t observation, double times, struct colour_sums *sums) {
    const struct observation *it = &fit->observations->list[observation];
    double value = it->value[fit->channel], gain = 1.0 + fit->gains[it->view];
    if (isnan(value)) return;
    double weight = times * weight_of(fit, observation);
    sums->squares += weight * gain * gain;
    sums->products += weight * gain * (value - fit->biases[it->view]);
}

static struct colour_sums sum_point(const struct fit *fit, uint32_t point) {
    struct colour_sums sums = {0};
    for (uint32_t o = begin_of(fit->observations, point); o < fit->observations->ends[point]; o++)
        add_observation(fit, o, 1.0, &sums);
    return sums;
}

static void solve_points(struct fit *fit) {
    for (uint32_t p = 0; p < fit->observations->point_count; p++) {
        struct colour_sums sums = sum_point(fit, p);
        fit->colours[p] = sums.squares > 0.0 ? sums.products / sums.squares : NAN;
    }
}

static bool is_fitted(const struct work *work, uint32_t view) { return work->counts[view] >= OBSERVATIONS_MIN / FOLDS; }

// Computes the slope of the sum by each number, at the best colours, and the curvature by the number alone.
static void find_slope(struct work *work) {
    const struct fit *fit = &work->with;
    const struct observations *observations = fit->observations;
    memset(work->counts, 0, observations->view_count * sizeof *work->counts);
    memset(work->slope, 0, observations->view_count * sizeof *work->slope);
    memset(work->scale, 0, observations->view_count * sizeof *work->scale);
    for (uint32_t p = 0; p < observations->point_count; p++)
        for (uint32_t o = begin_of(observations, p); work->used[p] && o < observations->ends[p]; o++) {
            uint32_t view = observations->list[o].view;
            double colour = fit->colours[p], residual = fit->residuals[o], weight = weight_of(fit, o);
            if (isnan(residual)) continue;
            work->counts[view]++;
            work->slope[view].gain -= weight * colour * residual;
            work->slope[view].bias -= weight * residual;
            work->scale[view].gain += weight * colour * colour;
            work->scale[view].bias += weight;
        }
    for (uint32_t v = 0; v < observations->view_count; v++) {
        double pull = RIDGE + BIAS_PULL * work->scale[v].bias;
        work->slope[v].gain += RIDGE * fit->gains[v];
        work->slope[v].bias += pull * fit->biases[v];
        work->scale[v].gain += RIDGE;
        work->scale[v].bias += pull;
    }
}

// Multiplies the direction by the curvature of the sum at the best colours: each point's colour follows its photos.
static void multiply(struct work *work) {
    const struct fit *fit = &work->with;
    const struct observations *observations = fit->observations;
    for (uint32_t v = 0; v < observations->view_count; v++) {
        work->product[v].gain = work->direction[v].gain * work->scale[v].gain;
        work->product[v].bias = work->direction[v].bias * work->scale[v].bias;
    }
    for (uint32_t p = 0; p < observations->point_count; p++) {
        double squares = 0.0, moves = 0.0, colour = fit->colours[p];
        for (uint32_t o = begin_of(observations, p); work->used[p] && o < observations->ends[p]; o++) {
            uint32_t view = observations->list[o].view;
            double gain = 1.0 + fit->gains[view], weight = weight_of(fit, o);
            if (isnan(fit->residuals[o])) continue;
            squares += weight * gain * gain;
            moves += weight * gain * (colour * work->direction[view].gain + work->direction[view].bias);
        }
        for (uint32_t o = begin_of(observations, p); squares > 0.0 && o < observations->ends[p]; o++) {
            uint32_t view = observations->list[o].view;
            double gain = 1.0 + fit->gains[view], weight = weight_of(fit, o), follows = gain * moves / squares;
            if (isnan(fit->residuals[o])) continue;
            work->product[view].gain += weight * (colour * (work->direction[view].bias - follows));
            work->product[view].bias += weight * (colour * work->direction[view].gain - follows);
        }
    }
}

static double dot(const struct work *work, const struct pair *a, const struct pair *b) {
    double sum = 0.0;
    for (uint32_t v = 0; v < work->observations.view_count; v++)
        if (is_fitted(work, v)) sum += a[v].gain * b[v].gain + a[v].bias * b[v].bias;
    return sum;
}

// Returns the square of the slope, each number measured by its own curvature.
static double measure_slope(const struct work *work) {
    double sum = 0.0;
    for (uint32_t v = 0; v < work->observations.view_count; v++)
        if (is_fitted(work, v))
            sum += work->slope[v].gain * work->slope[v].gain / work->scale[v].gain +
                   work->slope[v].bias * work->slope[v].bias / work->scale[v].bias;
    return sum;
}

// Points the direction down the slope and, by `share`, along the one before.
static void turn(struct work *work, double share) {
    for (uint32_t v = 0; v < work->observations.view_count; v++) {
        struct pair *direction = &work->direction[v];
        if (!is_fitted(work, v)) continue;
        direction->gain = share * direction->gain - work->slope[v].gain / work->scale[v].gain;
        direction->bias = share * direction->bias - work->slope[v].bias / work->scale[v].bias;
    }
}

// Finds the Gauss-Newton step by conjugate gradients; `slope` becomes what is left of it. Steps of one photo at a time
// would take thousands where each shares points with its neighbours alone.
static void find_step(struct work *work) {
    uint32_t views = work->observations.view_count;
    double first = measure_slope(work), size = first, before = INFINITY;
    memset(work->step, 0, views * sizeof *work->step);
    memset(work->direction, 0, views * sizeof *work->direction);
    for (int i = 0; i < CONJUGATE_STEPS && size > SLOPE_LEFT * SLOPE_LEFT * first; i++) {
        turn(work, size / before);
        multiply(work);
        double length = size / dot(work, work->direction, work->product);
        for (uint32_t v = 0; v < views; v++) {
            work->step[v].gain += length * work->direction[v].gain;
            work->step[v].bias += length * work->direction[v].bias;
            work->slope[v].gain += length * work->product[v].gain;
            work->slope[v].bias += length * work->product[v].bias;
        }
        before = size;
        size = measure_slope(work);
    }
}

// Moves gains and biases by a Gauss-Newton step. A correction divides by a gain, which must stay above 0.
static void solve_photos(struct work *work) {
    struct fit *fit = &work->with;
    find_slope(work);
    find_step(work);
    for (uint32_t v = 0; v < work->observations.view_count; v++) {
        double most = STEP_MOST * (1.0 + fit->gains[v]), share = fmin(1.0, most / fabs(work->step[v].gain));
        bool moves = is_fitted(work, v);
        fit->gains[v] = moves ? fmax(fit->gains[v] + share * work->step[v].gain, -0.9) : 0.0;
        fit->biases[v] = moves ? fit->biases[v] + share * work->step[v].bias : 0.0;
    }
}

static double median_of_fitted(struct work *work, const double *values) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < work->observations.view_count; v++)
        if (is_fitted(work, v)) work->sorted[count++] = values[v];
    return count ? vw_median(work->sorted, count) : 0.0;
}

// Makes the median photo the identity, since all photos and points together leave that open.
static void centre(struct work *work) {
    struct fit *fit = &work->with;
    double gain = 1.0 + median_of_fitted(work, fit->gains), bias = median_of_fitted(work, fit->biases);
    for (uint32_t p = 0; p < work->observations.point_count; p++) fit->colours[p] = gain * fit->colours[p] + bias;
    for (uint32_t v = 0; v < work->observations.view_count; v++) {
        if (!is_fitted(work, v)) continue;
        fit->gains[v] = (1.0 + fit->gains[v]) / gain - 1.0;
        fit->biases[v] -= (1.0 + fit->gains[v]) * bias;
    }
}

static void measure_residuals(struct work *work, struct fit *fit, bool sets_length) {
    const struct observations *observations = fit->observations;
    uint32_t count = 0;
    for (uint32_t p = 0; p < observations->point_count; p++)
        for (uint32_t o = begin_of(observations, p); o < observations->ends[p]; o++) {
            const struct observation *it = &observations->list[o];
            double shown = (1.0 + fit->gains[it->view]) * fit->colours[p] + fit->biases[it->view];
            fit->residuals[o] = it->value[fit->channel] - shown;
            if (sets_length && work->used[p] && !isnan(fit->residuals[o])) work->sorted[count++] = fit->residuals[o];
        }
    if (sets_length)
        fit->huber_length = HUBER_SPREADS * fmax(count ? vw_robust_spread(work->sorted, count) : 0.0, SPREAD_MIN);
}

// Fits a channel to the points in use, in `work->without` with all photos as they are.
static void fit_channel(struct work *work, struct fit *fit, int channel) {
    uint32_t views = work->observations.view_count;
    fit->channel = channel;
    fit->huber_length = INFINITY;
    memset(fit->gains, 0, views * sizeof *fit->gains);
    memset(fit->biases, 0, views * sizeof *fit->biases);
    memset(fit->residuals, 0, work->observations.count * sizeof *fit->residuals);
    for (int i = 0; i < STEPS; i++) {
        solve_points(fit);
        measure_residuals(work, fit, i > 0 && i <= STEPS_OF_LENGTH);
        if (fit == &work->with) solve_photos(work);
        if (fit == &work->with) centre(work);
    }
    solve_points(fit);
    measure_residuals(work, fit, false);
}

// ---- Evidence -------------------------------------------------------------------------------------------------------

// Returns how far an observation is from what the others of its point predict.
static double miss_of(const struct fit *fit, const struct colour_sums *all, uint32_t observation) {
    const struct observation *it = &fit->observations->list[observation];
    struct colour_sums others = *all;
    add_observation(fit, observation, -1.0, &others);
    double predicted = (1.0 + fit->gains[it->view]) * others.products / others.squares + fit->biases[it->view];
    return it->value[fit->channel] - predicted;
}

// Adds squared errors of predictions from the other photos of a point. Times (n - 1) / n they estimate without bias
// what a photo adds to the error of a field that all photos share.
static void judge_point(struct work *work, uint32_t point, int channel) {
    const struct observations *observations = &work->observations;
    const struct colour_sums all_without = sum_point(&work->without, point), all_with = sum_point(&work->with, point);
    double limit = pow(OUTLIER_SPREADS / HUBER_SPREADS * work->with.huber_length, 2), seen = 0.0;
    for (uint32_t o = begin_of(observations, point); o < observations->ends[point]; o++)
        seen += !isnan(observations->list[o].value[channel]);
    for (uint32_t o = begin_of(observations, point); o < observations->ends[point] && seen > 1.0; o++) {
        if (isnan(observations->list[o].value[channel])) continue;
        double without = pow(miss_of(&work->without, &all_without, o), 2),
               with = pow(miss_of(&work->with, &all_with, o), 2);
        if (!(fmin(without, with) <= limit)) continue;
        struct tally *tally = &work->tallies[observations->list[o].view];
        double share = (seen - 1.0) / seen;
        tally->without += share * without;
        tally->with += share * with;
        tally->differences_squared += pow(share * (without - with), 2);
        tally->count++;
    }
}

static void judge(struct work *work, struct vw_exposure *exposures) {
    for (int fold = 0; fold < FOLDS; fold++)
        for (int channel = 0; channel < CHANNELS; channel++) {
            for (uint32_t p = 0; p < work->observations.point_count; p++) work->used[p] = p % FOLDS != (uint32_t)fold;
            fit_channel(work, &work->without, channel);
            fit_channel(work, &work->with, channel);
            for (uint32_t p = 0; p < work->observations.point_count; p++)
                if (!work->used[p]) judge_point(work, p, channel);
        }
    for (uint32_t v = 0; v < work->observations.view_count; v++) {
        const struct tally *tally = &work->tallies[v];
        double count = tally->count, mean = (tally->without - tally->with) / count;
        if (count < OBSERVATIONS_MIN * CHANNELS) continue;
        exposures[v].error_without = tally->without / count;
        exposures[v].error_with = tally->with / count;
        // The channels of an observation say much the same.
        exposures[v].reduction_stderr =
            sqrt(fmax(tally->differences_squared / count - mean * mean, 0.0) * CHANNELS / count);
    }
}

// ---- All ------------------------------------------------------------------------------------------------------------

static void count_observations(const struct observations *observations, struct vw_exposure *exposures) {
    for (uint32_t o = 0; o < observations->count; o++) {
        const double *value = observations->list[o].value;
        exposures[observations->list[o].view].observation_count +=
            !isnan(value[0]) && !isnan(value[1]) && !isnan(value[2]);
    }
}

static void take_fit(const struct fit *fit, struct vw_exposure *exposures) {
    for (uint32_t v = 0; v < fit->observations->view_count; v++) {
        if (exposures[v].observation_count < OBSERVATIONS_MIN) continue;
        exposures[v].gain[fit->channel] = fit->gains[v];
        exposures[v].bias[fit->channel] = fit->biases[v];
    }
}

static enum vw_status allocate_fit(const struct observations *observations, struct fit *fit) {
    *fit = (struct fit){.observations = observations,
                        .colours = vw_allocate(observations->point_count, sizeof *fit->colours),
                        .gains = vw_allocate(observations->view_count, sizeof *fit->gains),
                        .biases = vw_allocate(observations->view_count, sizeof *fit->biases),
                        .residuals = vw_allocate(observations->count, sizeof *fit->residuals)};
    return fit->colours && fit->gains && fit->biases && fit->residuals ? VW_OK : VW_ERROR_MEMORY;
}

static enum vw_status allocate_work(struct work *work) {
    const struct observations *observations = &work->observations;
    size_t most = observations->count > observations->view_count ? observations->count : observations->view_count;
    work->used = vw_allocate(observations->point_count, sizeof *work->used);
    work->counts = vw_allocate(observations->view_count, sizeof *work->counts);
    work->slope = vw_allocate(observations->view_count, 5 * sizeof *work->slope);
    work->scale = work->slope + observations->view_count;
    work->step = work->scale + observations->view_count;
    work->direction = work->step + observations->view_count;
    work->product = work->direction + observations->view_count;
    work->tallies = vw_allocate(observations->view_count, sizeof *work->tallies);
    work->sorted = vw_allocate(most, sizeof *work->sorted);
    enum vw_status status =
        work->used && work->counts && work->slope && work->tallies && work->sorted ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = allocate_fit(observations, &work->with);
    return status ? status : allocate_fit(observations, &work->without);
}

static void release_fit(const struct fit *fit) {
    free(fit->colours);
    free(fit->gains);
    free(fit->biases);
    free(fit->residuals);
}

static void release_work(const struct work *work) {
    free(work->observations.list);
    free(work->observations.ends);
    free(work->used);
    free(work->counts);
    free(work->slope);
    free(work->tallies);
    free(work->sorted);
    release_fit(&work->with);
    release_fit(&work->without);
}

static enum vw_status estimate(const struct vw_scene *scene, struct vw_exposure *exposures) {
    struct work work = {0};
    enum vw_status status = list_observations(scene, &work.observations);
    if (!status) status = allocate_work(&work);
    if (!status) count_observations(&work.observations, exposures);
    if (!status) judge(&work, exposures);
    for (uint32_t p = 0; p < scene->point_count && !status; p++) work.used[p] = true;
    for (int channel = 0; channel < CHANNELS && !status; channel++) {
        fit_channel(&work, &work.with, channel);
        take_fit(&work.with, exposures);
    }
    release_work(&work);
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
    if (!status && scene->track_count) status = estimate(scene, *exposures);
    free(views);
    if (status) free(*exposures);
    return status;
}

bool vw_scene_tells_exposures(const struct vw_scene *scene) {
    uint32_t *shared = vw_allocate(scene->view_count, sizeof *shared), telling = 0;
    for (uint32_t p = 0; shared && p < scene->point_count; p++) {
        const struct vw_track *tracks = &scene->tracks[scene->points[p].first_track];
        uint32_t count = scene->points[p].track_count, trained = 0;
        for (uint32_t t = 0; t < count; t++) trained += scene->views[tracks[t].view].split == VW_SPLIT_TRAIN;
        for (uint32_t t = 0; t < count && trained > 1; t++) shared[tracks[t].view]++;
    }
    for (uint32_t v = 0; shared && v < scene->view_count; v++)
        telling += scene->views[v].split == VW_SPLIT_TRAIN && shared[v] >= OBSERVATIONS_MIN;
    free(shared);
    return telling > 0 && 2 * telling >= scene->split_count[VW_SPLIT_TRAIN];
}

double vw_exposure_brightness(const struct vw_exposure *exposure) {
    double sum = 0.0;
    for (int i = 0; i < CHANNELS; i++) sum += 1.0 + exposure->gain[i] + 2.0 * exposure->bias[i];
    return sum / CHANNELS;
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
