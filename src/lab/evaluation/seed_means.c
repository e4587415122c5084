#include "lab/evaluation/seed_means.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

enum { PRIOR_DEGREES = 2 };

static bool has_all(const double *values, uint32_t seed_count, uint32_t photo_count, uint32_t photo) {
    bool all = true;
    for (uint32_t seed = 0; seed < seed_count; seed++) all &= isfinite(values[(size_t)seed * photo_count + photo]);
    return all;
}

// Finds the level of each seed over the photos that all seeds score. Returns the number of these photos.
static uint32_t find_levels(const double *values, uint32_t seed_count, uint32_t photo_count, double *levels) {
    uint32_t count = 0;
    for (uint32_t photo = 0; photo < photo_count; photo++) {
        if (!has_all(values, seed_count, photo_count, photo)) continue;
        count++;
        for (uint32_t seed = 0; seed < seed_count; seed++) levels[seed] += values[(size_t)seed * photo_count + photo];
    }
    for (uint32_t seed = 0; seed < seed_count && count; seed++) levels[seed] /= count;
    return count;
}

// Returns the variance of a photo's scores without the levels of the seeds; the mean keeps the mean level.
static double variance_of(const double *values, uint32_t seed_count, uint32_t photo_count, uint32_t photo,
                          const double *levels, double *mean) {
    double sum = 0, level = 0, squares = 0;
    for (uint32_t seed = 0; seed < seed_count; seed++) {
        sum += values[(size_t)seed * photo_count + photo];
        level += levels[seed];
    }
    *mean = sum / seed_count;
    for (uint32_t seed = 0; seed < seed_count; seed++) {
        double away = values[(size_t)seed * photo_count + photo] - levels[seed] - (sum - level) / seed_count;
        squares += away * away;
    }
    return squares / (seed_count - 1);
}

static void rank(struct vw_seed_mean *means, uint32_t photo_count) {
    for (uint32_t i = 0; i < photo_count; i++) {
        if (isnan(means[i].mean)) continue;
        uint32_t better = 0, above = 0, below = 0, others = 0;
        for (uint32_t j = 0; j < photo_count; j++) {
            if (j == i || isnan(means[j].mean)) continue;
            others++;
            better += means[j].mean > means[i].mean || (j < i && means[j].mean == means[i].mean);
            above += means[j].ci_low > means[i].ci_high;
            below += means[j].ci_high < means[i].ci_low;
        }
        means[i].rank = better + 1;
        means[i].rank_ci_low = above + 1;
        means[i].rank_ci_high = others + 1 - below;
        means[i].overlaps = others - above - below;
    }
}

enum vw_status vw_seed_means_make(const double *values, uint32_t seed_count, uint32_t photo_count,
                                  struct vw_seed_mean *means) {
    double *levels = vw_allocate(seed_count, sizeof *levels), *variances = vw_allocate(photo_count, sizeof *variances);
    double usual = 0, degrees = seed_count - 1 + PRIOR_DEGREES;
    if (!levels || !variances) {
        free(levels);
        free(variances);
        return VW_ERROR_MEMORY;
    }
    uint32_t count = find_levels(values, seed_count, photo_count, levels);
    double lost = count > 1 ? count / (count - 1.0) : 1; // corrects the variance for the levels, which are subtracted
    for (uint32_t i = 0; i < photo_count; i++) {
        means[i] = (struct vw_seed_mean){NAN, NAN, NAN, NAN, 0, 0, 0, 0};
        if (!has_all(values, seed_count, photo_count, i)) continue;
        variances[i] = lost * variance_of(values, seed_count, photo_count, i, levels, &means[i].mean);
        usual += variances[i] / count;
    }
    for (uint32_t i = 0; i < photo_count; i++) {
        if (isnan(means[i].mean)) continue;
        double variance = ((seed_count - 1) * variances[i] + PRIOR_DEGREES * usual) / degrees;
        means[i].standard_error = sqrt(variance / seed_count);
        means[i].ci_low = means[i].mean - vw_student_quantile(degrees) * means[i].standard_error;
        means[i].ci_high = means[i].mean + vw_student_quantile(degrees) * means[i].standard_error;
    }
    rank(means, photo_count);
    free(levels);
    free(variances);
    return VW_OK;
}
