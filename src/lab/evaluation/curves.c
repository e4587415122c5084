// Removal and addition curves: retrainings after photos are removed, or added, in the order of their scores.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "lab/evaluation/evaluation.h"
#include "value/evaluation/resampling.h"

static const uint32_t percents[] = {10, 20, 30, 50};
static const size_t GAIN_END = 0, GAIN_PERCENT = 1;       // the point that a curve of gains has: removal_low/20
static const uint64_t RANDOM_ORDER_SEED = 0x637572766573; // no training has it

// End of the order whose photos are moved: they are removed, or they are the only ones that are trained on.
struct end {
    const char *group;
    bool removes, highest;
};
static const struct end ends[] = {{"removal_low", true, false},
                                  {"removal_high", true, true},
                                  {"addition_high", false, true},
                                  {"addition_low", false, false}};

// Retrainings of a curve: those of a point with all seeds, point after point.
struct curve {
    const struct vw_curve_params *params;
    const struct vw_evaluation *evaluation; // evaluation of the params, as are the seeds
    uint32_t seeds;
    const uint32_t *orders; // several of all photos, lowest score first
    uint32_t order_count;
    uint32_t *views; // owned, as the next two
    struct vw_retrain_params *retrainings;
    struct vw_retrain_result *results;
    uint32_t count, read; // retrainings; of these, whose results were taken
};

static double quality_of(const struct vw_retrain_result *result) {
    return isnan(result->test_psnr) ? result->val_psnr : result->test_psnr;
}

// Adds a point: training on these photos.
static void add_point(struct curve *curve, const uint32_t *photos, uint32_t count) {
    uint32_t *views = curve->views + (size_t)(curve->count / curve->seeds) * curve->evaluation->photo_count;
    for (uint32_t i = 0; i < count; i++) views[i] = curve->evaluation->photos[photos[i]];
    vw_sort_places(views, count);
    for (uint32_t seed = 0; seed < curve->seeds; seed++)
        curve->retrainings[curve->count++] =
            (struct vw_retrain_params){.views = views, .view_count = count, .seed = curve->params->first_seed + seed};
}

static uint32_t moved_photos(const struct curve *curve, uint32_t percent) {
    return (curve->evaluation->photo_count * percent + 50) / 100;
}

static void add_end(struct curve *curve, const struct end *end, uint32_t percent, const uint32_t *order) {
    uint32_t count = curve->evaluation->photo_count, moved = moved_photos(curve, percent);
    uint32_t kept = end->removes ? count - moved : moved;
    bool from_start = end->removes == end->highest; // the kept photos are at the low end
    add_point(curve, order + (from_start ? 0 : count - kept), kept);
}

// Computes the gain of the next point over training on all photos, in dB: means over its orders by seed, and over the
// seeds by order. The retrainings of all photos come first.
static void take_gains(struct curve *curve, struct vw_spread *over_seeds, struct vw_spread *over_orders) {
    const struct vw_retrain_result *results = curve->results + curve->read;
    uint32_t seeds = curve->seeds, orders = curve->order_count;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        double gain_db = -quality_of(&curve->results[seed]);
        for (uint32_t i = 0; i < orders; i++) gain_db += quality_of(&results[(size_t)i * seeds + seed]) / orders;
        vw_spread_add(over_seeds, gain_db);
    }
    for (uint32_t i = 0; i < orders; i++) {
        double psnr_db = 0;
        for (uint32_t seed = 0; seed < seeds; seed++) psnr_db += quality_of(&results[(size_t)i * seeds + seed]) / seeds;
        vw_spread_add(over_orders, psnr_db);
    }
    curve->read += seeds * orders;
}

// Returns half the width of a 95 % interval of a mean; NaN for a single value.
static double half_interval(const struct vw_spread *spread) {
    if (spread->count < 2) return NAN;
    double count = (double)spread->count;
    return vw_student_quantile(count - 1) * sqrt(vw_spread_variance(spread) / count);
}

static enum vw_status add_row(struct curve *curve, const struct end *end, uint32_t percent, const char *method,
                              struct vw_metrics *metrics) {
    struct vw_spread over_seeds = {0}, over_orders = {0};
    char name[8];
    snprintf(name, sizeof name, "%u", percent);
    take_gains(curve, &over_seeds, &over_orders);
    double half = half_interval(&over_seeds);
    if (curve->order_count > 1) half = hypot(half, half_interval(&over_orders));
    return vw_metrics_add(metrics, end->group, name,
                          (struct vw_metric){.method = method,
                                             .value = over_seeds.mean,
                                             .ci_low = over_seeds.mean - half,
                                             .ci_high = over_seeds.mean + half,
                                             .count = curve->seeds * curve->order_count});
}

// Returns true if the curve has the point. Both ends of a random order are equivalent, so one of each pair is enough.
// There may be too few photos to remove any.
static bool has_point(const struct curve *curve, size_t end, size_t percent) {
    if (curve->params->gain_only && (end != GAIN_END || percent != GAIN_PERCENT)) return false;
    return moved_photos(curve, percents[percent]) && (curve->order_count == 1 || end % 2 == 0);
}

static void add_points(struct curve *curve) {
    uint32_t photo_count = curve->evaluation->photo_count;
    add_point(curve, curve->orders, photo_count);
    for (size_t e = 0; e < VW_ARRAY_COUNT(ends); e++)
        for (size_t p = 0; p < VW_ARRAY_COUNT(percents); p++)
            for (uint32_t i = 0; has_point(curve, e, p) && i < curve->order_count; i++)
                add_end(curve, &ends[e], percents[p], curve->orders + (size_t)i * photo_count);
}

static enum vw_status add_rows(struct curve *curve, const char *method, struct vw_metrics *metrics) {
    enum vw_status status = VW_OK;
    curve->read = curve->seeds;
    for (size_t e = 0; !status && e < VW_ARRAY_COUNT(ends); e++)
        for (size_t p = 0; !status && p < VW_ARRAY_COUNT(percents); p++)
            if (has_point(curve, e, p)) status = add_row(curve, &ends[e], percents[p], method, metrics);
    return status;
}

static enum vw_status evaluate_orders(const struct vw_curve_params *params, const uint32_t *orders,
                                      uint32_t order_count, const char *method, struct vw_metrics *metrics) {
    struct curve curve = {.params = params,
                          .evaluation = params->evaluation,
                          .seeds = params->seed_count,
                          .orders = orders,
                          .order_count = order_count};
    size_t points = 1 + VW_ARRAY_COUNT(ends) * VW_ARRAY_COUNT(percents) * (size_t)order_count;
    curve.views = vw_allocate(points * curve.evaluation->photo_count, sizeof *curve.views);
    curve.retrainings = vw_allocate(points * curve.seeds, sizeof *curve.retrainings);
    curve.results = vw_allocate(points * curve.seeds, sizeof *curve.results);
    bool enough = curve.views && curve.retrainings && curve.results;
    enum vw_status status = enough ? VW_OK : VW_ERROR_MEMORY;
    if (enough) add_points(&curve);
    if (!status) status = params->retrain(params->context, curve.retrainings, curve.count, curve.results);
    if (!status) status = add_rows(&curve, method, metrics);
    free(curve.views);
    free(curve.retrainings);
    free(curve.results);
    return status;
}

uint32_t vw_curve_trainings(uint32_t seed_count, bool gain_only) {
    return seed_count * (1 + (gain_only ? 1 : VW_ARRAY_COUNT(ends) * VW_ARRAY_COUNT(percents)));
}

// Sorts the photos by score, the lowest first; of equal ones the earlier photo comes first.
static void order_by(const double *scores, uint32_t count, uint32_t *order) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t place = i;
        for (; place > 0 && scores[order[place - 1]] > scores[i]; place--) order[place] = order[place - 1];
        order[place] = i;
    }
}

enum vw_status vw_evaluate_curve(const struct vw_curve_params *params, const struct vw_scorer *scorer,
                                 struct vw_metrics *metrics) {
    uint32_t photos = params->evaluation->photo_count;
    if (!vw_all_finite(scorer->scores, photos)) return VW_OK; // they give no order
    uint32_t *order = vw_allocate(photos, sizeof *order);
    if (!order) return VW_ERROR_MEMORY;
    order_by(scorer->scores, photos, order);
    enum vw_status status = evaluate_orders(params, order, 1, scorer->name, metrics);
    free(order);
    return status;
}

enum vw_status vw_evaluate_random_curve(const struct vw_curve_params *params, struct vw_metrics *metrics) {
    uint32_t photos = params->evaluation->photo_count;
    uint32_t *orders = vw_allocate(photos, VW_CURVE_ORDERS * sizeof *orders);
    if (!orders) return VW_ERROR_MEMORY;
    for (uint32_t i = 0; i < VW_CURVE_ORDERS; i++)
        vw_random_order(RANDOM_ORDER_SEED, i, photos, orders + (size_t)i * photos);
    enum vw_status status = evaluate_orders(params, orders, VW_CURVE_ORDERS, "random", metrics);
    free(orders);
    return status;
}
