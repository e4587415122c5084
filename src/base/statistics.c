#include "base/statistics.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "base/memory.h"

static int compare(const void *a, const void *b) {
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

static int compare_places(const void *a, const void *b) {
    uint32_t left = *(const uint32_t *)a, right = *(const uint32_t *)b;
    return (left > right) - (left < right);
}

static int compare_ordered(const void *a, const void *b) {
    const struct vw_ordered *left = a, *right = b;
    int by_value = compare(&left->value, &right->value);
    return by_value ? by_value : compare_places(&left->place, &right->place);
}

void vw_sort(double *values, uint32_t count) { qsort(values, count, sizeof *values, compare); }

void vw_sort_places(uint32_t *places, uint32_t count) {
    if (count) qsort(places, count, sizeof *places, compare_places);
}

void vw_order(const double *values, uint32_t count, struct vw_ordered *ordered) {
    for (uint32_t i = 0; i < count; i++) ordered[i] = (struct vw_ordered){values[i], i};
    if (count) qsort(ordered, count, sizeof *ordered, compare_ordered);
}

double vw_quantile_of_sorted(const double *sorted, uint32_t count, double share) {
    double place = share * (count - 1);
    uint32_t below = (uint32_t)place, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (place - below) * (sorted[above] - sorted[below]);
}

double vw_median(double *values, uint32_t count) {
    if (!count) return NAN;
    vw_sort(values, count);
    return vw_quantile_of_sorted(values, count, 0.5);
}

double vw_robust_spread(double *values, uint32_t count) {
    double middle = vw_median(values, count);
    for (uint32_t i = 0; i < count; i++) values[i] = fabs(values[i] - middle);
    return VW_NORMAL_SPREAD * vw_median(values, count);
}

void vw_spread_add(struct vw_spread *spread, double value) {
    spread->count++;
    double deviation = value - spread->mean;
    spread->mean += deviation / (double)spread->count;
    spread->squared_deviations += deviation * (value - spread->mean);
}

double vw_spread_variance(const struct vw_spread *spread) {
    return spread->count < 2 ? NAN : spread->squared_deviations / (double)(spread->count - 1);
}

static bool varies(const double *values, uint32_t count) {
    for (uint32_t i = 1; i < count; i++)
        if (values[i] != values[0]) return true;
    return false;
}

double vw_dot(const double *a, const double *b, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

double vw_pearson(const double *a, const double *b, uint32_t count) {
    double mean_a = 0, mean_b = 0, aa = 0, bb = 0, ab = 0;
    if (!varies(a, count) || !varies(b, count)) return NAN; // the rounded mean of equal values may differ from them
    for (uint32_t i = 0; i < count; i++) {
        mean_a += a[i] / count;
        mean_b += b[i] / count;
    }
    for (uint32_t i = 0; i < count; i++) {
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
        ab += (a[i] - mean_a) * (b[i] - mean_b);
    }
    return aa > 0 && bb > 0 ? ab / (sqrt(aa) * sqrt(bb)) : NAN;
}

enum vw_status vw_ranks(const double *values, uint32_t count, double *ranks) {
    struct vw_ordered *sorted = vw_allocate(count, sizeof *sorted);
    if (!sorted) return VW_ERROR_MEMORY;
    vw_order(values, count, sorted);
    for (uint32_t begin = 0, end; begin < count; begin = end) {
        for (end = begin + 1; end < count && sorted[end].value == sorted[begin].value;) end++;
        for (uint32_t i = begin; i < end; i++) ranks[sorted[i].place] = 0.5 * (begin + 1 + end);
    }
    free(sorted);
    return VW_OK;
}

enum vw_status vw_spearman(const double *a, const double *b, uint32_t count, double *correlation) {
    double *ranks = vw_allocate(count, 2 * sizeof *ranks);
    enum vw_status status = ranks ? vw_ranks(a, count, ranks) : VW_ERROR_MEMORY;
    if (!status) status = vw_ranks(b, count, ranks + count);
    if (!status) *correlation = vw_pearson(ranks, ranks + count, count);
    free(ranks);
    return status;
}

// Expands the quantile about the normal quantile z.
static double expand_student(double z, double n) {
    const double z3 = z * z * z, z5 = z3 * z * z, z7 = z5 * z * z, z9 = z7 * z * z;
    return z + (z3 + z) / 4 / n + (5 * z5 + 16 * z3 + 3 * z) / 96 / (n * n) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / 384 / (n * n * n) +
           (79 * z9 + 776 * z7 + 1482 * z5 - 1920 * z3 - 945 * z) / 92160 / (n * n * n * n);
}

double vw_student_quantile(double degrees) {
    if (degrees == 1) return 12.7062047361747; // tan(0.475 pi)
    if (degrees == 2) return 4.30265272974946; // 0.95 / sqrt(2 * 0.975 * 0.025)
    return expand_student(1.959963984540054, degrees);
}

double vw_student_quantile_95(double degrees) {
    if (degrees == 1) return 6.31375151467504; // tan(0.45 pi)
    if (degrees == 2) return 2.91998558035373; // 0.9 / sqrt(2 * 0.95 * 0.05)
    return expand_student(1.644853626951473, degrees);
}

double vw_student_quantile_99(double degrees) {
    if (degrees == 1) return 31.8205159537740; // tan(0.49 pi)
    if (degrees == 2) return 6.96455673428326; // 0.98 / sqrt(2 * 0.99 * 0.01)
    return expand_student(2.326347874040841, degrees);
}

static bool dominates(double cost, double quality, double other_cost, double other_quality) {
    return cost <= other_cost && quality >= other_quality && (cost < other_cost || quality > other_quality);
}

void vw_pareto_front_mark(const double *costs, const double *qualities, uint32_t count, bool *on_front) {
    for (uint32_t i = 0; i < count; i++) {
        on_front[i] = !isnan(costs[i]) && !isnan(qualities[i]);
        for (uint32_t other = 0; other < count && on_front[i]; other++)
            on_front[i] = !dominates(costs[other], qualities[other], costs[i], qualities[i]); // false for NaN
    }
}

double vw_psnr_db(double mse) { return -10.0 * log10(mse < VW_MSE_FLOOR ? VW_MSE_FLOOR : mse); }
