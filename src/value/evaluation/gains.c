#include "value/evaluation/gains.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

// PSNR of all lists, and the means of each training over the photos: means[list * seeds + seed].
struct results {
    const double *psnr_db;
    double *means; // owned
    uint32_t lists, seeds, views;
};

static const double *of_list(const struct results *results, uint32_t list) {
    return &results->psnr_db[(size_t)list * results->seeds * results->views];
}

static bool are_equal(const struct results *results, uint32_t one, uint32_t other) {
    return memcmp(of_list(results, one), of_list(results, other),
                  (size_t)results->seeds * results->views * sizeof *results->psnr_db) == 0;
}

static enum vw_status take_means(struct results *results) {
    size_t trainings = (size_t)results->lists * results->seeds;
    results->means = vw_allocate(trainings, sizeof *results->means);
    if (!results->means) return VW_ERROR_MEMORY;
    for (size_t t = 0; t < trainings; t++)
        for (uint32_t v = 0; v < results->views; v++)
            results->means[t] += results->psnr_db[t * results->views + v] / results->views;
    return VW_OK;
}

// ---- Noise of seeds ----

static bool is_repeated(const struct results *results, uint32_t list) {
    for (uint32_t l = 0; l < list; l++)
        if (are_equal(results, l, list)) return true;
    return false;
}

// Means over distinct lists (by seed) and over all of their trainings.
static uint32_t average_lists(const struct results *results, double *by_seed, double *overall) {
    uint32_t distinct = 0;
    *overall = 0;
    for (uint32_t l = 0; l < results->lists; l++) distinct += !is_repeated(results, l);
    for (uint32_t s = 0; s < results->seeds; s++) {
        by_seed[s] = 0;
        for (uint32_t l = 0; l < results->lists; l++)
            if (!is_repeated(results, l)) by_seed[s] += results->means[(size_t)l * results->seeds + s] / distinct;
        *overall += by_seed[s] / results->seeds;
    }
    return distinct;
}

// Estimates the variance of one training's mean PSNR, without the effects of list and seed; `*degrees` of freedom.
static enum vw_status find_seed_variance(const struct results *results, double *variance, double *degrees) {
    double *by_seed = vw_allocate(results->seeds, sizeof *by_seed), overall, squares = 0;
    if (!by_seed) return VW_ERROR_MEMORY;
    uint32_t distinct = average_lists(results, by_seed, &overall);
    for (uint32_t l = 0; l < results->lists; l++) {
        const double *means = &results->means[(size_t)l * results->seeds];
        double of_this = 0;
        if (is_repeated(results, l)) continue;
        for (uint32_t s = 0; s < results->seeds; s++) of_this += means[s] / results->seeds;
        for (uint32_t s = 0; s < results->seeds; s++) {
            double residual = means[s] - of_this - by_seed[s] + overall;
            squares += residual * residual;
        }
    }
    *degrees = (distinct - 1.0) * (results->seeds - 1.0);
    *variance = squares / *degrees; // NaN without a degree of freedom
    free(by_seed);
    return VW_OK;
}

// ---- Gains ----

static struct vw_gain estimate(const struct results *results, uint32_t list, double seed_variance,
                               double seed_degrees) {
    const double *own = of_list(results, list), *all = of_list(results, 0);
    struct vw_spread spread = {0};
    if (are_equal(results, list, 0)) return (struct vw_gain){0};
    for (uint32_t v = 0; v < results->views; v++) {
        double difference = 0;
        for (uint32_t s = 0; s < results->seeds; s++) {
            size_t place = (size_t)s * results->views + v;
            difference += (own[place] - all[place]) / results->seeds;
        }
        vw_spread_add(&spread, difference);
    }
    double of_views = vw_spread_variance(&spread) / results->views, of_seeds = 2 * seed_variance / results->seeds,
           variance = of_views + of_seeds, half = 0;
    if (variance != 0) { // also of NaN
        double degrees =
            variance * variance / (of_views * of_views / (results->views - 1.0) + of_seeds * of_seeds / seed_degrees);
        half = vw_student_quantile_99(floor(degrees * (1 + 1e-9))) * sqrt(variance);
    }
    return (struct vw_gain){spread.mean, sqrt(variance), spread.mean - half, spread.mean + half};
}

enum vw_status vw_gains_estimate(const double *psnr_db, uint32_t lists, uint32_t seeds, uint32_t views,
                                 struct vw_gain *gains) {
    struct results results = {.psnr_db = psnr_db, .lists = lists, .seeds = seeds, .views = views};
    double variance = NAN, degrees = NAN;
    enum vw_status status = take_means(&results);
    if (!status) status = find_seed_variance(&results, &variance, &degrees);
    for (uint32_t l = 0; !status && l < lists; l++) gains[l] = estimate(&results, l, variance, degrees);
    free(results.means);
    return status;
}

uint32_t vw_gains_choose(const struct vw_gain *gains, uint32_t lists) {
    uint32_t best = 0;
    for (uint32_t l = 1; l < lists; l++)
        if (gains[l].ci_low > 0 && (!best || gains[l].gain_db > gains[best].gain_db)) best = l;
    return best;
}
