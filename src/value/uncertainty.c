#include "value/uncertainty.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

enum {
    TREND_MOST = 3,         // constant, log and its square
    EPOCHS_PER_TREND = 4,   // epochs needed for each term of the trend
    FREQUENCIES_MOST = 64,  // the lowest ones; in a long run, higher ones say nothing about the sum
    CORRELATION_STEPS = 90, // steps of the search for the correlation, on either side of 0
    PRIOR_DEGREES = 2,      // degrees of freedom of the median photo's variance, added to the photo's own
};
static const double CORRELATION_MOST = 0.9;
static const double CORRELATION_PRIOR = 0.3; // standard deviation of the prior; it matters only for few numbers
static const double KEPT_LEAST = 0.5;        // frequencies of which less remains without the trend are left out
const double vw_run_variance = 1.5;
static const double RANK_ERRORS = 1.645; // see uncertainty.h
static const double LENGTH_SHARE = 0.2;
static const double PI = 3.14159265358979323846;

// The basis that all photos share: rows of `epochs` values.
struct design {
    uint32_t epochs, trend_count, frequency_count;
    double *trends;      // orthonormal
    double *cosines;     // orthonormal among themselves
    double *frequencies; // angles per epoch
    double *kept;        // share of white noise that remains at each frequency without the trends
};

static void subtract(double *from, const double *row, double times, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) from[i] -= times * row[i];
}

static void design_destroy(struct design *design) {
    free(design->trends);
    free(design->cosines);
    free(design->frequencies);
    free(design->kept);
}

// Makes powers of the logarithm orthonormal (Gram-Schmidt).
static void make_trends(struct design *design) {
    uint32_t epochs = design->epochs;
    for (uint32_t power = 0; power < design->trend_count; power++) {
        double *trend = design->trends + (size_t)power * epochs;
        for (uint32_t epoch = 0; epoch < epochs; epoch++) trend[epoch] = pow(log(epoch + 2.0), power);
        for (uint32_t before = 0; before < power; before++) {
            const double *other = design->trends + (size_t)before * epochs;
            subtract(trend, other, vw_dot(trend, other, epochs), epochs);
        }
        double length = sqrt(vw_dot(trend, trend, epochs));
        for (uint32_t epoch = 0; epoch < epochs; epoch++) trend[epoch] /= length;
    }
}

// Makes the cosines of which enough remains without the trends.
static void make_cosines(struct design *design, uint32_t candidates) {
    uint32_t epochs = design->epochs;
    for (uint32_t number = 1; number <= candidates; number++) {
        double *cosine = design->cosines + (size_t)design->frequency_count * epochs;
        double angle = PI * number / epochs, kept = 1;
        for (uint32_t epoch = 0; epoch < epochs; epoch++)
            cosine[epoch] = sqrt(2.0 / epochs) * cos(angle * (epoch + 0.5));
        for (uint32_t t = 0; t < design->trend_count; t++) {
            double share = vw_dot(cosine, design->trends + (size_t)t * epochs, epochs);
            kept -= share * share;
        }
        if (kept < KEPT_LEAST) continue;
        design->frequencies[design->frequency_count] = angle;
        design->kept[design->frequency_count++] = kept;
    }
}

static enum vw_status design_create(uint32_t epochs, struct design *design) {
    uint32_t trends = epochs / EPOCHS_PER_TREND,
             candidates = epochs - 1 < FREQUENCIES_MOST ? epochs - 1 : FREQUENCIES_MOST;
    *design = (struct design){.epochs = epochs,
                              .trend_count = trends < 1            ? 1
                                             : trends < TREND_MOST ? trends
                                                                   : TREND_MOST};
    design->trends = vw_allocate((size_t)design->trend_count * epochs, sizeof *design->trends);
    design->cosines = vw_allocate((size_t)candidates * epochs, sizeof *design->cosines);
    design->frequencies = vw_allocate(candidates, sizeof *design->frequencies);
    design->kept = vw_allocate(candidates, sizeof *design->kept);
    if (!design->trends || !design->cosines || !design->frequencies || !design->kept) return VW_ERROR_MEMORY;
    make_trends(design);
    make_cosines(design, candidates);
    return VW_OK;
}

// ---- A photo ----

struct photo {
    double sum;
    uint32_t visits;
    double variance; // variance of a visit if visits were independent; NaN below two visits
};

// Computes the powers of a photo's contributions at the design's frequencies. If visits are independent, the
// expectation of each is the variance of a visit. An epoch without a visit counts as the photo's mean.
static void measure_photo(const struct design *design, const double *by_epoch, double *residuals, struct photo *photo,
                          double *powers) {
    uint32_t epochs = design->epochs, frequencies = design->frequency_count;
    *photo = (struct photo){.variance = NAN};
    for (uint32_t epoch = 0; epoch < epochs; epoch++) {
        if (isnan(by_epoch[epoch])) continue;
        photo->sum += by_epoch[epoch];
        photo->visits++;
    }
    if (photo->visits < 2) return;
    double mean = photo->sum / photo->visits, total = 0;
    for (uint32_t epoch = 0; epoch < epochs; epoch++)
        residuals[epoch] = isnan(by_epoch[epoch]) ? 0 : by_epoch[epoch] - mean;
    for (uint32_t t = 0; t < design->trend_count; t++) {
        const double *trend = design->trends + (size_t)t * epochs;
        subtract(residuals, trend, vw_dot(residuals, trend, epochs), epochs);
    }
    for (uint32_t f = 0; f < frequencies; f++) {
        double amplitude = vw_dot(residuals, design->cosines + (size_t)f * epochs, epochs);
        powers[f] = amplitude * amplitude / design->kept[f] * epochs / photo->visits;
        total += powers[f];
    }
    photo->variance = total / frequencies;
}

// ---- All photos ----

// Averages the powers relative to the photo's variance over photos. Returns the number of photos with a variance.
static uint32_t pool_powers(const struct photo *photos, const double *powers, uint32_t photo_count,
                            uint32_t frequencies, double *pooled) {
    uint32_t pooled_count = 0;
    memset(pooled, 0, frequencies * sizeof *pooled);
    for (uint32_t p = 0; p < photo_count; p++) {
        if (!(photos[p].variance > 0)) continue;
        for (uint32_t f = 0; f < frequencies; f++)
            pooled[f] += powers[(size_t)p * frequencies + f] / photos[p].variance;
        pooled_count++;
    }
    for (uint32_t f = 0; f < frequencies && pooled_count; f++) pooled[f] /= pooled_count;
    return pooled_count;
}

static double spectrum(double correlation, double angle) {
    return 1 / (1 + correlation * correlation - 2 * correlation * cos(angle));
}

// Returns the misfit of a correlation to the pooled powers: minus twice the logarithm of Whittle's likelihood and of
// the prior, up to a constant. `at_zero` is the variance of a sum, per visit, divided by that of a visit.
static double misfit(const struct design *design, const double *pooled, uint32_t pooled_count, double correlation,
                     double *at_zero) {
    double level = 0, logarithms = 0;
    for (uint32_t f = 0; f < design->frequency_count; f++) {
        double shape = spectrum(correlation, design->frequencies[f]);
        level += pooled[f] / shape / design->frequency_count;
        logarithms += log(shape);
    }
    *at_zero = level * spectrum(correlation, 0);
    double prior = correlation / CORRELATION_PRIOR;
    return pooled_count * (logarithms + design->frequency_count * log(level)) + prior * prior;
}

// Returns the variance of a sum divided by that of as many independent visits, for the correlation of neighbouring
// epochs that fits best.
static double long_run_ratio(const struct design *design, const double *pooled, uint32_t pooled_count) {
    double best = INFINITY, ratio = 1;
    for (int step = -CORRELATION_STEPS; step <= CORRELATION_STEPS && pooled_count; step++) {
        double at_zero,
            badness = misfit(design, pooled, pooled_count, CORRELATION_MOST * step / CORRELATION_STEPS, &at_zero);
        if (badness >= best) continue;
        best = badness;
        ratio = at_zero;
    }
    return ratio;
}

// Returns the median. `scratch` has room for a number per photo.
static double median_variance(const struct photo *photos, uint32_t photo_count, double *scratch) {
    uint32_t count = 0;
    for (uint32_t p = 0; p < photo_count; p++)
        if (!isnan(photos[p].variance)) scratch[count++] = photos[p].variance;
    return vw_median(scratch, count);
}

// Computes an interval. `usual` is the variance of a visit of the median photo, `ratio` that of long_run_ratio.
static struct vw_interval interval_of(const struct photo *photo, uint32_t frequencies, double usual, double ratio) {
    if (isnan(photo->variance)) return (struct vw_interval){NAN, NAN, NAN};
    double degrees = frequencies + PRIOR_DEGREES;
    double variance = (frequencies * photo->variance + PRIOR_DEGREES * usual) / degrees;
    double error = sqrt(photo->visits * variance * ratio * vw_run_variance),
           half = vw_student_quantile(degrees) * error;
    return (struct vw_interval){error, photo->sum - half, photo->sum + half};
}

// The epochs in which any photo contributes: a method may use some epochs only.
struct window {
    uint32_t first, end;
};

static struct window find_window(const double *by_epoch, uint32_t photos, uint32_t epochs) {
    struct window window = {epochs, 0};
    for (size_t i = 0; i < (size_t)photos * epochs; i++) {
        uint32_t epoch = (uint32_t)(i % epochs);
        if (isnan(by_epoch[i])) continue;
        if (epoch < window.first) window.first = epoch;
        if (epoch >= window.end) window.end = epoch + 1;
    }
    return window;
}

enum vw_status vw_intervals_of_sums(const double *by_epoch, uint32_t photos, uint32_t epochs,
                                    struct vw_interval *intervals) {
    struct window window = find_window(by_epoch, photos, epochs);
    for (uint32_t p = 0; p < photos; p++) intervals[p] = (struct vw_interval){NAN, NAN, NAN};
    if (window.end < window.first + 2) return VW_OK;
    struct design design;
    enum vw_status status = design_create(window.end - window.first, &design);
    uint32_t frequencies = design.frequency_count;
    struct photo *measured = vw_allocate(photos, sizeof *measured);
    double *powers = vw_allocate((size_t)photos * frequencies, sizeof *powers),
           *pooled = vw_allocate(frequencies, sizeof *pooled);
    double *residuals = vw_allocate(design.epochs, sizeof *residuals);
    if (!measured || !powers || !pooled || !residuals) status = VW_ERROR_MEMORY;
    for (uint32_t p = 0; !status && p < photos; p++)
        measure_photo(&design, by_epoch + (size_t)p * epochs + window.first, residuals, &measured[p],
                      powers + (size_t)p * frequencies);
    if (!status) {
        double ratio = long_run_ratio(&design, pooled, pool_powers(measured, powers, photos, frequencies, pooled));
        double usual = median_variance(measured, photos, powers); // the powers are pooled by now
        for (uint32_t p = 0; p < photos; p++) intervals[p] = interval_of(&measured[p], frequencies, usual, ratio);
    }
    design_destroy(&design);
    free(measured);
    free(powers);
    free(pooled);
    free(residuals);
    return status;
}

// ---- Ranks ----

// Returns whether a is better than b by more than their standard errors and the variance added to each explain; false
// if one of these is unknown.
static bool is_surely_better(const struct vw_ledger_score *a, const struct vw_ledger_score *b, double added_variance) {
    double difference = a->value - b->value;
    double variance = a->standard_error * a->standard_error + b->standard_error * b->standard_error;
    variance += 2 * added_variance;
    return difference > 0 && difference * difference > RANK_ERRORS * RANK_ERRORS * variance;
}

double vw_length_variance(double *values, uint32_t count) {
    double spread = vw_robust_spread(values, count);
    return count ? LENGTH_SHARE * spread * spread : 0;
}

void vw_rank_intervals(struct vw_ledger_score *scores, uint32_t count, double added_variance) {
    for (uint32_t i = 0; i < count; i++) {
        bool known = !isnan(scores[i].standard_error);
        scores[i].rank_ci_low = known ? 1 : 0;
        scores[i].rank_ci_high = known ? count : 0;
    }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t other = i + 1; other < count; other++) {
            struct vw_ledger_score *better = &scores[i], *worse = &scores[other];
            if (better->value < worse->value) better = &scores[other], worse = &scores[i];
            if (!is_surely_better(better, worse, added_variance)) continue; // also if one has no standard error
            worse->rank_ci_low++;
            better->rank_ci_high--;
        }
}
