#include "value/evaluation/resampling.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"

static const uint64_t RESAMPLING_SEED = 0x626f6f74; // used by no training
static const double TAIL = 0.025;

bool vw_all_finite(const double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

uint16_t *vw_resamples_draw(uint32_t count) {
    uint16_t *times = vw_allocate((1 + (size_t)VW_RESAMPLES) * count, sizeof *times);
    for (uint32_t r = 0; times && r <= VW_RESAMPLES; r++)
        for (uint32_t i = 0; i < count; i++) {
            uint32_t words[4];
            vw_random_words(RESAMPLING_SEED, VW_RANDOM_ORDER, r, i, 0, words);
            times[(size_t)r * count + (r ? vw_random_below(words[0], count) : i)]++;
        }
    return times;
}

double vw_resampling_unit(uint32_t resample, uint32_t item) {
    uint32_t words[4];
    vw_random_words(RESAMPLING_SEED, VW_RANDOM_ORDER, resample, item, 1, words);
    return vw_random_unit(words[0]);
}

double vw_resampling_normal(uint32_t resample, uint32_t item) {
    uint32_t words[4];
    vw_random_words(RESAMPLING_SEED, VW_RANDOM_ORDER, resample, item, 2, words);
    double radius = (words[0] + 0.5) / 4294967296.0; // above 0
    return sqrt(-2 * log(radius)) * cos(2 * M_PI * ((words[1] + 0.5) / 4294967296.0));
}

void vw_resampling_interval(double *resampled, double *ci_low, double *ci_high) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < VW_RESAMPLES; i++)
        if (isfinite(resampled[i])) resampled[count++] = resampled[i];
    *ci_low = *ci_high = NAN;
    if (!count) return;
    vw_sort(resampled, count);
    *ci_low = vw_quantile_of_sorted(resampled, count, TAIL);
    *ci_high = vw_quantile_of_sorted(resampled, count, 1 - TAIL);
}

// Ranks the items drawn; equal ones share the mean of their ranks.
static void rank_drawn(const struct vw_ordered *ordered, const uint16_t *times, uint32_t count, double *ranks) {
    double below = 0;
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        double level = times[ordered[begin].place];
        for (end = begin + 1; end < count && ordered[end].value == ordered[begin].value; end++)
            level += times[ordered[end].place];
        for (uint32_t i = begin; i < end; i++) ranks[ordered[i].place] = below + 0.5 * (level + 1);
        below += level;
    }
}

// Computes Spearman's correlation over the items drawn: that of Pearson of their ranks, each as often as it was drawn.
// The mean of all ranks is known. NaN if one side does not vary.
static double spearman_drawn(const double *ranks_a, const double *ranks_b, const uint16_t *times, uint32_t count) {
    double mean = 0.5 * (count + 1), aa = 0, bb = 0, ab = 0;
    for (uint32_t i = 0; i < count; i++) {
        aa += times[i] * (ranks_a[i] - mean) * (ranks_a[i] - mean);
        bb += times[i] * (ranks_b[i] - mean) * (ranks_b[i] - mean);
        ab += times[i] * (ranks_a[i] - mean) * (ranks_b[i] - mean);
    }
    return aa > 0 && bb > 0 ? ab / (sqrt(aa) * sqrt(bb)) : NAN;
}

enum vw_status vw_resampled_spearman_add(const double *a, const double *b, const uint16_t *times, uint32_t count,
                                         double weight, double *values) {
    if (!vw_all_finite(a, count) || !vw_all_finite(b, count)) {
        for (uint32_t r = 0; r <= VW_RESAMPLES; r++) values[r] = NAN;
        return VW_OK;
    }
    struct vw_ordered *ordered = vw_allocate(count, 2 * sizeof *ordered);
    double *ranks = vw_allocate(count, 2 * sizeof *ranks);
    enum vw_status status = ordered && ranks ? VW_OK : VW_ERROR_MEMORY;
    if (!status) vw_order(a, count, ordered);
    if (!status) vw_order(b, count, ordered + count);
    for (uint32_t r = 0; !status && r <= VW_RESAMPLES; r++) {
        const uint16_t *drawn = times + (size_t)r * count;
        rank_drawn(ordered, drawn, count, ranks);
        rank_drawn(ordered + count, drawn, count, ranks + count);
        values[r] += weight * spearman_drawn(ranks, ranks + count, drawn, count);
    }
    free(ordered);
    free(ranks);
    return status;
}
