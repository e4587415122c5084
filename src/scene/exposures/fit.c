#include "scene/exposures/fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

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

static double weight_of(const struct exposure_fit *fit, uint32_t observation) {
    double size = fabs(fit->residuals[observation]), length = HUBER_SPREADS * fit->spread;
    return size > length ? length / size : 1.0;
}

static void add_observation(const struct exposure_fit *fit, uint32_t observation, double times,
                            struct exposure_colour_sums *sums) {
    const struct observation *it = &fit->observations->list[observation];
    double value = it->value[fit->channel], gain = 1.0 + fit->gains[it->view];
    if (isnan(value)) return;
    double weight = times * weight_of(fit, observation);
    sums->squares += weight * gain * gain;
    sums->products += weight * gain * (value - fit->biases[it->view]);
}

struct exposure_colour_sums vw_exposure_sum_point(const struct exposure_fit *fit, uint32_t point) {
    struct exposure_colour_sums sums = {0};
    for (uint32_t o = vw_observations_begin(fit->observations, point); o < fit->observations->ends[point]; o++)
        add_observation(fit, o, 1.0, &sums);
    return sums;
}

double vw_exposure_miss(const struct exposure_fit *fit, const struct exposure_colour_sums *all, uint32_t observation) {
    const struct observation *it = &fit->observations->list[observation];
    struct exposure_colour_sums others = *all;
    add_observation(fit, observation, -1.0, &others);
    double predicted = (1.0 + fit->gains[it->view]) * others.products / others.squares + fit->biases[it->view];
    return it->value[fit->channel] - predicted;
}

static void solve_points(struct exposure_fit *fit) {
    for (uint32_t p = 0; p < fit->observations->point_count; p++) {
        struct exposure_colour_sums sums = vw_exposure_sum_point(fit, p);
        fit->colours[p] = sums.squares > 0.0 ? sums.products / sums.squares : NAN;
    }
}

static bool is_fitted(const struct exposure_work *work, uint32_t view) {
    return work->counts[view] >= EXPOSURE_OBSERVATIONS_MIN / EXPOSURE_FOLDS;
}

// Computes the slope of the sum by each number, at the best colours, and the curvature by the number alone.
static void find_slope(struct exposure_work *work, const struct exposure_fit *fit) {
    const struct observations *observations = fit->observations;
    memset(work->counts, 0, observations->view_count * sizeof *work->counts);
    memset(work->slope, 0, observations->view_count * sizeof *work->slope);
    memset(work->scale, 0, observations->view_count * sizeof *work->scale);
    for (uint32_t p = 0; p < observations->point_count; p++)
        for (uint32_t o = vw_observations_begin(observations, p); work->used[p] && o < observations->ends[p]; o++) {
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
static void multiply(struct exposure_work *work, const struct exposure_fit *fit) {
    const struct observations *observations = fit->observations;
    for (uint32_t v = 0; v < observations->view_count; v++) {
        work->product[v].gain = work->direction[v].gain * work->scale[v].gain;
        work->product[v].bias = work->direction[v].bias * work->scale[v].bias;
    }
    for (uint32_t p = 0; p < observations->point_count; p++) {
        double squares = 0.0, moves = 0.0, colour = fit->colours[p];
        for (uint32_t o = vw_observations_begin(observations, p); work->used[p] && o < observations->ends[p]; o++) {
            uint32_t view = observations->list[o].view;
            double gain = 1.0 + fit->gains[view], weight = weight_of(fit, o);
            if (isnan(fit->residuals[o])) continue;
            squares += weight * gain * gain;
            moves += weight * gain * (colour * work->direction[view].gain + work->direction[view].bias);
        }
        for (uint32_t o = vw_observations_begin(observations, p); squares > 0.0 && o < observations->ends[p]; o++) {
            uint32_t view = observations->list[o].view;
            double gain = 1.0 + fit->gains[view], weight = weight_of(fit, o), follows = gain * moves / squares;
            if (isnan(fit->residuals[o])) continue;
            work->product[view].gain += weight * (colour * (work->direction[view].bias - follows));
            work->product[view].bias += weight * (colour * work->direction[view].gain - follows);
        }
    }
}

static double dot(const struct exposure_work *work, const struct exposure_pair *a, const struct exposure_pair *b) {
    double sum = 0.0;
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v)) sum += a[v].gain * b[v].gain + a[v].bias * b[v].bias;
    return sum;
}

// Returns the square of the slope, each number measured by its own curvature.
static double measure_slope(const struct exposure_work *work) {
    double sum = 0.0;
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v))
            sum += work->slope[v].gain * work->slope[v].gain / work->scale[v].gain +
                   work->slope[v].bias * work->slope[v].bias / work->scale[v].bias;
    return sum;
}

// Points the direction down the slope and, by `share`, along the one before.
static void turn(struct exposure_work *work, double share) {
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        struct exposure_pair *direction = &work->direction[v];
        if (!is_fitted(work, v)) continue;
        direction->gain = share * direction->gain - work->slope[v].gain / work->scale[v].gain;
        direction->bias = share * direction->bias - work->slope[v].bias / work->scale[v].bias;
    }
}

// Finds the Gauss-Newton step by conjugate gradients; `slope` becomes what is left of it. Steps of one photo at a time
// would take thousands where each shares points with its neighbours alone.
static void find_step(struct exposure_work *work, const struct exposure_fit *fit) {
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
static void solve_photos(struct exposure_work *work, struct exposure_fit *fit) {
    find_slope(work, fit);
    find_step(work, fit);
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        double most = STEP_MOST * (1.0 + fit->gains[v]), share = fmin(1.0, most / fabs(work->step[v].gain));
        bool moves = is_fitted(work, v);
        fit->gains[v] = moves ? fmax(fit->gains[v] + share * work->step[v].gain, -0.9) : 0.0;
        fit->biases[v] = moves ? fit->biases[v] + share * work->step[v].bias : 0.0;
    }
}

static double median_of_fitted(struct exposure_work *work, const double *values) {
    uint32_t count = 0;
    for (uint32_t v = 0; v < work->observations->view_count; v++)
        if (is_fitted(work, v)) work->sorted[count++] = values[v];
    return count ? vw_median(work->sorted, count) : 0.0;
}

// Makes the median photo the identity, since all photos and points together leave that open.
static void centre(struct exposure_work *work, struct exposure_fit *fit) {
    double gain = 1.0 + median_of_fitted(work, fit->gains), bias = median_of_fitted(work, fit->biases);
    for (uint32_t p = 0; p < work->observations->point_count; p++) fit->colours[p] = gain * fit->colours[p] + bias;
    for (uint32_t v = 0; v < work->observations->view_count; v++) {
        if (!is_fitted(work, v)) continue;
        fit->gains[v] = (1.0 + fit->gains[v]) / gain - 1.0;
        fit->biases[v] -= (1.0 + fit->gains[v]) * bias;
    }
}

static void measure_residuals(struct exposure_work *work, struct exposure_fit *fit, bool sets_spread) {
    const struct observations *observations = fit->observations;
    uint32_t count = 0;
    for (uint32_t p = 0; p < observations->point_count; p++)
        for (uint32_t o = vw_observations_begin(observations, p); o < observations->ends[p]; o++) {
            const struct observation *it = &observations->list[o];
            double shown = (1.0 + fit->gains[it->view]) * fit->colours[p] + fit->biases[it->view];
            fit->residuals[o] = it->value[fit->channel] - shown;
            if (sets_spread && work->used[p] && !isnan(fit->residuals[o])) work->sorted[count++] = fit->residuals[o];
        }
    if (sets_spread) fit->spread = fmax(count ? vw_robust_spread(work->sorted, count) : 0.0, SPREAD_MIN);
}

void vw_exposure_fit_channel(struct exposure_work *work, struct exposure_fit *fit, int channel, bool exposures) {
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

enum vw_status vw_exposure_fit_create(const struct observations *observations, struct exposure_fit *fit) {
    *fit = (struct exposure_fit){.observations = observations,
                                 .colours = vw_allocate(observations->point_count, sizeof *fit->colours),
                                 .gains = vw_allocate(observations->view_count, sizeof *fit->gains),
                                 .biases = vw_allocate(observations->view_count, sizeof *fit->biases),
                                 .residuals = vw_allocate(observations->count, sizeof *fit->residuals)};
    return fit->colours && fit->gains && fit->biases && fit->residuals ? VW_OK : VW_ERROR_MEMORY;
}

void vw_exposure_fit_release(const struct exposure_fit *fit) {
    free(fit->colours);
    free(fit->gains);
    free(fit->biases);
    free(fit->residuals);
}

enum vw_status vw_exposure_work_create(const struct observations *observations, struct exposure_work *work) {
    uint32_t views = observations->view_count, most = observations->count > views ? observations->count : views;
    struct exposure_pair *pairs = vw_allocate(views, 5 * sizeof *pairs);
    *work = (struct exposure_work){.observations = observations,
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

void vw_exposure_work_release(const struct exposure_work *work) {
    free(work->used);
    free(work->counts);
    free(work->slope);
    free(work->sorted);
}
