#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"
#include "image/image.h"
#include "scene/builder.h"

enum {
    CHANNELS = 3,
    OBSERVATIONS_MIN = 8, // per photo; with fewer it keeps the identity
    FOLDS = 2,            // parts of the points; each is judged by a fit to the others
};

// ---- Observations ---------------------------------------------------------------------------------------------------

// The colour that a train photo shows of a point.
struct observation {
    uint32_t view;
    double value[CHANNELS]; // in [0,1], as stored; NaN: unusable
};

// Observations of points by train photos, point by point; at most one of a point by a photo.
struct observations {
    struct observation *list; // owned
    uint32_t *ends;           // owned; by point: the first observation of the next
    uint32_t point_count, count, view_count;
};

static uint32_t begin_of(const struct observations *observations, uint32_t point) {
    return point ? observations->ends[point - 1] : 0;
}

static const double DARKEST = 0.01, BRIGHTEST = 0.99; // beyond, a channel may be clipped

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

// Reads the colours of all points in all train photos, which must have been decoded. A channel is unusable where a
// photo is masked or transparent, where it may be clipped, and of a point that no other photo shows in it.
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

// ---- The fit -------------------------------------------------------------------------------------------------------

enum {
    STEPS = 16,
    STEPS_OF_SPREAD = 13, // after which rho stays as it is
    CONJUGATE_STEPS = 40,
};
static const double RIDGE = 0.1; // as if one observation were off by 0.3 for a gain or a bias of 1
// A bias takes up the lost contrast of a blurred photo sooner than a change of exposure: without its pull, two blurred
// photos of scenes/courtyard.json have gains of 0.5, with it 0.75.
static const double BIAS_PULL = 0.1;
static const double SLOPE_LEFT = 1e-2;        // share, where conjugate gradients stop
static const double STEP_MOST = 0.3;          // share of a gain at a time, as the sum is far from quadratic
static const double HUBER_SPREADS = 1.345;    // 95 % as efficient as least squares where errors are normal
static const double SPREAD_MIN = 1.0 / 255.0; // that of rounding

struct fit {
    const struct observations *observations; // borrowed
    int channel;
    double *colours;        // by point; NaN: unknown
    double *gains, *biases; // by view; gains minus 1
    double *residuals;      // by observation; NaN: unusable
    double spread;          // robust; residuals of more than 1.3 spreads count less
};

// A gain and a bias of a view, or what belongs to these numbers.
struct pair {
    double gain, bias;
};

// Scratch memory that fits to the same observations share.
struct work {
    const struct observations *observations;                 // borrowed
    bool *used;                                              // by point: fits see it
    uint32_t *counts;                                        // by view: observations in use
    struct pair *slope, *scale, *step, *direction, *product; // by view: of a Gauss-Newton step
    double *sorted;                                          // scratch, by observation or view
};

// Sums over the observations of a point; their ratio is its colour.
struct colour_sums {
    double squares, products;
};

static double weight_of(const struct fit *fit, uint32_t observation) {
    double size = fabs(fit->residuals[observation]), length = HUBER_SPREADS * fit->spread;
    return size > length ? length / size : 1.0;
}

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

// Returns how far an observation is from what the others of its point predict, which has these sums.
static double miss(const struct fit *fit, const struct colour_sums *all, uint32_t observation) {
    const struct observation *it = &fit->observations->list[observation];
    struct colour_sums others = *all;
    add_observation(fit, observation, -1.0, &others);
    double predicted = (1.0 + fit->gains[it->view]) * others.products / others.squares + fit->biases[it->view];
    return it->value[fit->channel] - predicted;
}

static void solve_points(struct fit *fit) {
    for (uint32_t p = 0; p < fit->observations->point_count; p++) {
        struct colour_sums sums = sum_point(fit, p);
        fit->colours[p] = sums.squares > 0.0 ? sums.products / sums.squares : NAN;
    }
}

static bool is_fitted(const struct work *work, uint32_t view) { return work->counts[view] >= OBSERVATIONS_MIN / FOLDS; }

// Computes the slope of the sum by each number, at the best colours, and the curvature by the number alone.
static void find_slope(struct work *work, const struct fit *fit) {
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
static void multiply(struct work *work, const struct fit *fit) {
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
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v)) sum += a[v].gain * b[v].gain + a[v].bias * b[v].bias;
    return sum;
}

// Returns the square of the slope, each number measured by its own curvature.
static double measure_slope(const struct work *work) {
    double sum = 0.0;
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v))
            sum += work->slope[v].gain * work->slope[v].gain / work->scale[v].gain +
                   work->slope[v].bias * work->slope[v].bias / work->scale[v].bias;
    return sum;
}

// Points the direction down the slope and, by `share`, along the one before.
static void turn(struct work *work, double share) {
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        struct pair *direction = &work->direction[v];
        if (!is_fitted(work, v)) continue;
        direction->gain = share * direction->gain - work->slope[v].gain / work->scale[v].gain;
        direction->bias = share * direction->bias - work->slope[v].bias / work->scale[v].bias;
    }
}

// Finds the Gauss-Newton step by conjugate gradients; `slope` becomes what is left of it. Steps of one photo at a time
// would take thousands where each shares points with its neighbours alone.
static void find_step(struct work *work, const struct fit *fit) {
    uint32_t views = work->observations->view_count;
    double first = measure_slope(work), size = first, before = INFINITY;
    memset(work->step, 0, views * sizeof *work->step);
    memset(work->direction, 0, views * sizeof *work->direction);
    for (int i = 0; i < CONJUGATE_STEPS && size > SLOPE_LEFT * SLOPE_LEFT * first; i++) {
        turn(work, size / before);
        multiply(work, fit);
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
static void solve_photos(struct work *work, struct fit *fit) {
    find_slope(work, fit);
    find_step(work, fit);
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        double most = STEP_MOST * (1.0 + fit->gains[v]), share = fmin(1.0, most / fabs(work->step[v].gain));
        bool moves = is_fitted(work, v);
        fit->gains[v] = moves ? fmax(fit->gains[v] + share * work->step[v].gain, -0.9) : 0.0;
        fit->biases[v] = moves ? fit->biases[v] + share * work->step[v].bias : 0.0;
    }
}

static double median_of_fitted(struct work *work, const double *values) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v)) work->sorted[count++] = values[v];
    return count ? vw_median(work->sorted, count) : 0.0;
}

// Makes the median photo the identity, since all photos and points together leave that open.
static void centre(struct work *work, struct fit *fit) {
    double gain = 1.0 + median_of_fitted(work, fit->gains), bias = median_of_fitted(work, fit->biases);
    for (uint32_t p = 0; p < work->observations->point_count; p++) fit->colours[p] = gain * fit->colours[p] + bias;
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        if (!is_fitted(work, v)) continue;
        fit->gains[v] = (1.0 + fit->gains[v]) / gain - 1.0;
        fit->biases[v] -= (1.0 + fit->gains[v]) * bias;
    }
}

static void measure_residuals(struct work *work, struct fit *fit, bool sets_spread) {
    const struct observations *observations = fit->observations;
    uint32_t count = 0;
    for (uint32_t p = 0; p < observations->point_count; p++)
        for (uint32_t o = begin_of(observations, p); o < observations->ends[p]; o++) {
            const struct observation *it = &observations->list[o];
            double shown = (1.0 + fit->gains[it->view]) * fit->colours[p] + fit->biases[it->view];
            fit->residuals[o] = it->value[fit->channel] - shown;
            if (sets_spread && work->used[p] && !isnan(fit->residuals[o])) work->sorted[count++] = fit->residuals[o];
        }
    if (sets_spread) fit->spread = fmax(count ? vw_robust_spread(work->sorted, count) : 0.0, SPREAD_MIN);
}

// Fits a channel to the points in use; without `exposures`, the colours of points alone.
static void fit_channel(struct work *work, struct fit *fit, int channel, bool exposures) {
    uint32_t views = work->observations->view_count;
    fit->channel = channel;
    fit->spread = INFINITY;
    memset(fit->gains, 0, views * sizeof *fit->gains);
    memset(fit->biases, 0, views * sizeof *fit->biases);
    memset(fit->residuals, 0, work->observations->count * sizeof *fit->residuals);
    for (int i = 0; i < STEPS; i++) {
        solve_points(fit);
        measure_residuals(work, fit, i > 0 && i <= STEPS_OF_SPREAD);
        if (exposures) solve_photos(work, fit);
        if (exposures) centre(work, fit);
    }
    solve_points(fit);
    measure_residuals(work, fit, false);
}

// ---- Memory ---------------------------------------------------------------------------------------------------------

static enum vw_status create_fit(const struct observations *observations, struct fit *fit) {
    *fit = (struct fit){.observations = observations,
                        .colours = vw_allocate(observations->point_count, sizeof *fit->colours),
                        .gains = vw_allocate(observations->view_count, sizeof *fit->gains),
                        .biases = vw_allocate(observations->view_count, sizeof *fit->biases),
                        .residuals = vw_allocate(observations->count, sizeof *fit->residuals)};
    return fit->colours && fit->gains && fit->biases && fit->residuals ? VW_OK : VW_ERROR_MEMORY;
}

static void release_fit(const struct fit *fit) {
    free(fit->colours);
    free(fit->gains);
    free(fit->biases);
    free(fit->residuals);
}

static enum vw_status create_work(const struct observations *observations, struct work *work) {
    uint32_t views = observations->view_count, most = observations->count > views ? observations->count : views;
    struct pair *pairs = vw_allocate(views, 5 * sizeof *pairs);
    *work = (struct work){.observations = observations,
                          .used = vw_allocate(observations->point_count, sizeof *work->used),
                          .counts = vw_allocate(views, sizeof *work->counts),
                          .slope = pairs,
                          .sorted = vw_allocate(most, sizeof *work->sorted)};
    if (!work->used || !work->counts || !pairs || !work->sorted) return VW_ERROR_MEMORY;
    work->scale = pairs + views;
    work->step = work->scale + views;
    work->direction = work->step + views;
    work->product = work->direction + views;
    return VW_OK;
}

static void release_work(const struct work *work) {
    free(work->used);
    free(work->counts);
    free(work->slope);
    free(work->sorted);
}

// ---- Evidence -------------------------------------------------------------------------------------------------------

static const double OUTLIER_SPREADS = 3.0; // observations that neither fit explains tell nothing of either

struct estimate {
    struct observations observations;
    struct fit with, without; // exposures; without, photos keep the identity
    struct work work;
    struct tally {
        double without, with, differences_squared, count;
    } * tallies; // by view
};

// Adds squared errors of predictions from the other photos of a point. Times (n - 1) / n they estimate without bias
// what a photo adds to the error of a field that all photos share.
static void judge_point(const struct estimate *estimate, uint32_t point, int channel) {
    const struct observations *observations = &estimate->observations;
    const struct fit *without = &estimate->without, *with = &estimate->with;
    const struct colour_sums all_without = sum_point(without, point), all_with = sum_point(with, point);
    uint32_t begin = begin_of(observations, point), end = observations->ends[point];
    double limit = pow(OUTLIER_SPREADS * with->spread, 2), seen = 0.0;
    for (uint32_t o = begin; o < end; o++) seen += !isnan(observations->list[o].value[channel]);
    for (uint32_t o = begin; o < end && seen > 1.0; o++) {
        if (isnan(observations->list[o].value[channel])) continue;
        double error_without = pow(miss(without, &all_without, o), 2), error_with = pow(miss(with, &all_with, o), 2);
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
    for (uint32_t p = 0; p < points; p++) used[p] = p % FOLDS != fold;
    fit_channel(&estimate->work, &estimate->without, channel, false);
    fit_channel(&estimate->work, &estimate->with, channel, true);
    for (uint32_t p = 0; p < points; p++)
        if (!used[p]) judge_point(estimate, p, channel);
}

static void judge(struct estimate *estimate, struct vw_exposure *exposures) {
    for (uint32_t fold = 0; fold < FOLDS; fold++)
        for (int channel = 0; channel < CHANNELS; channel++) judge_fold(estimate, fold, channel);
    for (uint32_t v = 0; v < estimate->observations.view_count; v++) {
        const struct tally *tally = &estimate->tallies[v];
        double count = tally->count, mean = (tally->without - tally->with) / count;
        if (count < OBSERVATIONS_MIN * CHANNELS) continue;
        exposures[v].error_without = tally->without / count;
        exposures[v].error_with = tally->with / count;
        // The channels of an observation say much the same.
        exposures[v].reduction_stderr =
            sqrt(fmax(tally->differences_squared / count - mean * mean, 0.0) * CHANNELS / count);
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

static void take_fit(const struct fit *fit, struct vw_exposure *exposures) {
    for (uint32_t v = 0; v < fit->observations->view_count; v++) {
        if (exposures[v].observation_count < OBSERVATIONS_MIN) continue;
        exposures[v].gain[fit->channel] = fit->gains[v];
        exposures[v].bias[fit->channel] = fit->biases[v];
    }
}

static enum vw_status begin(const struct vw_scene *scene, struct estimate *estimate) {
    enum vw_status status = list_observations(scene, &estimate->observations);
    if (!status) status = create_work(&estimate->observations, &estimate->work);
    if (!status) status = create_fit(&estimate->observations, &estimate->without);
    if (!status) status = create_fit(&estimate->observations, &estimate->with);
    estimate->tallies = vw_allocate(scene->view_count, sizeof *estimate->tallies);
    return !status && !estimate->tallies ? VW_ERROR_MEMORY : status;
}

static void end(const struct estimate *estimate) {
    free(estimate->observations.list);
    free(estimate->observations.ends);
    release_work(&estimate->work);
    release_fit(&estimate->without);
    release_fit(&estimate->with);
    free(estimate->tallies);
}

static enum vw_status estimate_all(const struct vw_scene *scene, struct vw_exposure *exposures) {
    struct estimate estimate = {0};
    enum vw_status status = begin(scene, &estimate);
    if (!status) count_observations(&estimate.observations, exposures);
    if (!status) judge(&estimate, exposures);
    for (uint32_t p = 0; p < scene->point_count && !status; p++) estimate.work.used[p] = true;
    for (int channel = 0; channel < CHANNELS && !status; channel++) {
        fit_channel(&estimate.work, &estimate.with, channel, true);
        take_fit(&estimate.with, exposures);
    }
    end(&estimate);
    return status;
}

static enum vw_status create(const struct vw_scene *scene, struct vw_exposure **exposures) {
    uint32_t *views = NULL, count = 0;
    struct vw_exposure *made = vw_allocate(scene->view_count, sizeof *made);
    if (!made) return VW_ERROR_MEMORY;
    for (uint32_t v = 0; v < scene->view_count; v++)
        made[v].error_without = made[v].error_with = made[v].reduction_stderr = NAN;
    enum vw_status status = vw_scene_list_views(scene, VW_SPLIT_TRAIN, &views, &count);
    if (!status && scene->track_count) status = vw_scene_decode(scene, views, count);
    if (!status && scene->track_count) status = estimate_all(scene, made);
    free(views);
    if (status) free(made);
    else *exposures = made;
    return status;
}

// The estimate of a scene, made when it is first asked for.
struct vw_exposures {
    pthread_mutex_t lock;
    struct vw_exposure *list; // owned; NULL: none yet
};

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

enum vw_status vw_scene_prepare_exposures(struct vw_scene *scene) {
    struct sharing *views = vw_allocate(scene->view_count, sizeof *views);
    uint32_t telling = 0;
    if (!scene->exposures && (scene->exposures = vw_allocate(1, sizeof *scene->exposures)))
        (void)pthread_mutex_init(&scene->exposures->lock, NULL);
    if (views && scene->exposures) {
        for (uint32_t p = 0; p < scene->point_count; p++) count_shared(scene, p, views);
        for (uint32_t v = 0; v < scene->view_count; v++) telling += views[v].shared >= OBSERVATIONS_MIN;
        scene->points_tell_exposures = telling > 0 && 2 * telling >= scene->split_count[VW_SPLIT_TRAIN];
    }
    free(views);
    return views && scene->exposures ? VW_OK : VW_ERROR_MEMORY;
}

void vw_scene_forget_exposures(struct vw_scene *scene) {
    if (scene->exposures) free(scene->exposures->list);
    free(scene->exposures);
}

double vw_exposure_brightness(const struct vw_exposure *exposure) {
    double sum = 0.0;
    for (int i = 0; i < CHANNELS; i++) sum += 1.0 + exposure->gain[i] + 2.0 * exposure->bias[i];
    return sum / CHANNELS;
}

enum vw_status vw_scene_estimate_exposures(const struct vw_scene *scene, const struct vw_exposure **exposures) {
    struct vw_exposures *estimated = scene->exposures;
    pthread_mutex_lock(&estimated->lock);
    enum vw_status status = estimated->list ? VW_OK : create(scene, &estimated->list);
    *exposures = estimated->list;
    pthread_mutex_unlock(&estimated->lock);
    return status;
}
