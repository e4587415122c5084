#include "lab/evaluation/full_agreement.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/statistics.h"

const char *vw_agreement_name(enum vw_agreement_measure measure) {
    static const char *const names[] = {"pearson",        "spearman",         "trimmed_pearson", "clean_pearson",
                                        "clean_spearman", "positive_jaccard", "same_sign",       "sign_kappa"};
    _Static_assert(VW_ARRAY_COUNT(names) == VW_AGREEMENT_COUNT, "a measure has no name");
    return names[measure];
}

// Two runs. A correlation of fewer than two photos or of equal scores is NaN.
struct correlations {
    double pearson, spearman;
    uint32_t photos; // compared
};

// Keeps the scores of photos that both runs have a finite score for, and that are `only`, unless that is NULL. Returns
// how many.
static uint32_t keep_known(const double *a, const double *b, const bool *only, uint32_t count, double *kept_a,
                           double *kept_b) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (!isfinite(a[i]) || !isfinite(b[i]) || (only && !only[i])) continue;
        kept_a[kept] = a[i];
        kept_b[kept++] = b[i];
    }
    return kept;
}

static enum vw_status correlate(const double *a, const double *b, const bool *only, uint32_t count,
                                struct correlations *correlations) {
    double *kept = vw_allocate(count, 2 * sizeof *kept);
    if (!kept) return VW_ERROR_MEMORY;
    uint32_t photos = keep_known(a, b, only, count, kept, kept + count);
    struct correlations made = {.pearson = vw_pearson(kept, kept + count, photos), .photos = photos};
    enum vw_status status = vw_spearman(kept, kept + count, photos, &made.spearman);
    free(kept);
    if (!status) *correlations = made;
    return status;
}

static double ratio(double part, double whole) { return whole > 0 ? part / whole : NAN; }

// Compares counts, so that rounding does not decide what is chance.
static void compare_signs(const double *a, const double *b, uint32_t count, struct vw_full_agreement *agreement) {
    double both = 0, of_a = 0, of_b = 0, all = count;
    for (uint32_t i = 0; i < count; i++) {
        of_a += a[i] > 0;
        of_b += b[i] > 0;
        both += a[i] > 0 && b[i] > 0;
    }
    double same = all - of_a - of_b + 2 * both;
    double by_chance = of_a * of_b + (all - of_a) * (all - of_b); // times the count
    agreement->values[VW_AGREEMENT_POSITIVE_JACCARD] = ratio(both, of_a + of_b - both);
    agreement->values[VW_AGREEMENT_SAME_SIGN] = ratio(same, all);
    agreement->values[VW_AGREEMENT_SIGN_KAPPA] = ratio(all * same - by_chance, all * all - by_chance);
}

enum { EXTREME_PHOTOS = 2, TRIMMED_LEAST = 5 };

// Raises distances[i] to that of value i; `sorted` is room for the values.
static void add_distances(const double *values, uint32_t count, double *sorted, double *distances) {
    memcpy(sorted, values, count * sizeof *sorted);
    double median = vw_median(sorted, count);
    double spread = vw_robust_spread(sorted, count);
    for (uint32_t i = 0; i < count; i++)
        distances[i] = fmax(distances[i], fabs(values[i] - median) / (spread > 0 ? spread : 1));
}

// Overwrites a and b.
static enum vw_status trimmed_pearson(double *a, double *b, uint32_t count, double *r) {
    *r = NAN;
    if (count < TRIMMED_LEAST) return VW_OK;
    double *distances = vw_allocate(count, 2 * sizeof *distances);
    if (!distances) return VW_ERROR_MEMORY;
    add_distances(a, count, distances + count, distances);
    add_distances(b, count, distances + count, distances);
    for (uint32_t gone = 0; gone < EXTREME_PHOTOS; gone++, count--) {
        uint32_t farthest = 0;
        for (uint32_t i = 1; i < count; i++)
            if (distances[i] > distances[farthest]) farthest = i;
        size_t behind_bytes = (count - farthest - 1) * sizeof *a;
        memmove(distances + farthest, distances + farthest + 1, behind_bytes);
        memmove(a + farthest, a + farthest + 1, behind_bytes);
        memmove(b + farthest, b + farthest + 1, behind_bytes);
    }
    *r = vw_pearson(a, b, count);
    free(distances);
    return VW_OK;
}

enum vw_status vw_full_agreement_of_pair(const double *a, const double *b, const bool *clean, uint32_t count,
                                         struct vw_full_agreement *agreement) {
    struct vw_full_agreement made = {.values[VW_AGREEMENT_CLEAN_PEARSON] = NAN,
                                     .values[VW_AGREEMENT_CLEAN_SPEARMAN] = NAN};
    struct correlations all, within;
    double *kept = vw_allocate(count, 2 * sizeof *kept);
    if (!kept) return VW_ERROR_MEMORY;
    enum vw_status status = correlate(a, b, NULL, count, &all);
    if (!status) {
        made.photos = keep_known(a, b, NULL, count, kept, kept + count);
        made.values[VW_AGREEMENT_PEARSON] = all.pearson;
        made.values[VW_AGREEMENT_SPEARMAN] = all.spearman;
        compare_signs(kept, kept + count, made.photos, &made);
        status = trimmed_pearson(kept, kept + count, made.photos, &made.values[VW_AGREEMENT_TRIMMED_PEARSON]);
    }
    if (!status && clean) {
        status = correlate(a, b, clean, count, &within);
        if (!status) {
            made.clean = within.photos;
            made.values[VW_AGREEMENT_CLEAN_PEARSON] = within.pearson;
            made.values[VW_AGREEMENT_CLEAN_SPEARMAN] = within.spearman;
        }
    }
    free(kept);
    if (!status) *agreement = made;
    return status;
}

static void forget_signs(struct vw_full_agreement *agreement) {
    agreement->values[VW_AGREEMENT_POSITIVE_JACCARD] = NAN;
    agreement->values[VW_AGREEMENT_SAME_SIGN] = NAN;
    agreement->values[VW_AGREEMENT_SIGN_KAPPA] = NAN;
}

enum vw_status vw_full_agreement_of_pairs(const struct vw_score_tables *tables, const struct vw_score_table *table,
                                          struct vw_full_agreement **pairs, uint32_t *pair_count) {
    uint32_t runs = tables->run_count, photos = tables->photo_count, count = 0;
    struct vw_full_agreement *made = vw_allocate((size_t)runs * runs / 2, sizeof *made);
    enum vw_status status = made ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t a = 0; a < runs; a++)
        for (uint32_t b = a + 1; b < runs && !status; b++)
            status = vw_full_agreement_of_pair(table->values + (size_t)a * photos, table->values + (size_t)b * photos,
                                               tables->clean, photos, &made[count++]);
    if (!table->has_zero)
        for (uint32_t i = 0; i < count; i++) forget_signs(&made[i]);
    if (status) {
        free(made);
        return status;
    }
    *pairs = made;
    *pair_count = count;
    return VW_OK;
}

// Counts the intervals. A score lies sqrt(1 + 1 / (runs - 1)) times as far from the mean of the others as from the mean
// of all possible runs.
struct vw_coverage vw_agreement_coverage(const struct vw_score_tables *tables, const struct vw_score_table *table) {
    struct vw_coverage coverage = {.share = NAN};
    uint32_t held = 0, runs = tables->run_count, photos = tables->photo_count;
    for (uint32_t photo = 0; runs > 1 && photo < photos; photo++) {
        double sum = 0;
        for (uint32_t run = 0; run < runs; run++) sum += table->values[(size_t)run * photos + photo];
        for (uint32_t run = 0; run < runs; run++) {
            size_t place = (size_t)run * photos + photo;
            double value = table->values[place], others = (sum - value) / (runs - 1);
            double mean = value + (others - value) / sqrt(1 + 1.0 / (runs - 1));
            if (isnan(mean) || isnan(table->ci_low[place]) || isnan(table->ci_high[place])) continue;
            held += table->ci_low[place] <= mean && mean <= table->ci_high[place];
            coverage.intervals++;
        }
    }
    if (coverage.intervals) coverage.share = (double)held / coverage.intervals;
    return coverage;
}

struct vw_agreement_summary vw_full_agreement_summarise(const struct vw_full_agreement *pairs, uint32_t pair_count,
                                                        enum vw_agreement_measure measure) {
    struct vw_agreement_summary summary = {.lowest = NAN, .highest = NAN};
    double sum = 0;
    for (uint32_t i = 0; i < pair_count; i++) {
        double value = pairs[i].values[measure];
        if (isnan(value)) continue;
        sum += value;
        summary.pairs++;
        summary.lowest = fmin(summary.lowest, value); // which prefers a number to NaN
        summary.highest = fmax(summary.highest, value);
    }
    summary.mean = summary.pairs ? sum / summary.pairs : NAN;
    return summary;
}
