// Removal and addition curves: retrainings after photos are removed, or added, in the order of their scores. And
// leave-one-out.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "value/evaluation/evaluation.h"
#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"

static const uint32_t percents[] = {10, 20, 30, 50};
static const uint64_t RANDOM_ORDER_SEED = 0x637572766573; // no training has it

// Which end of the order is moved, and whether it is removed or is all that is trained on.
struct end {
    const char *group;
    bool removes, highest;
};
static const struct end ends[] = {{"removal_low", true, false},
                                  {"removal_high", true, true},
                                  {"addition_high", false, true},
                                  {"addition_low", false, false}};

// Retrainings of a curve: those of a point with VW_SUBSET_SEEDS seeds, point after point.
struct curve {
    const struct vw_evaluation *evaluation;
    uint64_t first_seed;
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

static bool all_finite(const double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

// Adds a point: training on these photos.
static void add_point(struct curve *curve, const uint32_t *photos, uint32_t count) {
    uint32_t *views = curve->views + (size_t)(curve->count / VW_SUBSET_SEEDS) * curve->evaluation->photo_count;
    for (uint32_t i = 0; i < count; i++) views[i] = curve->evaluation->photos[photos[i]];
    vw_sort_places(views, count);
    for (uint32_t seed = 0; seed < VW_SUBSET_SEEDS; seed++)
        curve->retrainings[curve->count++] =
            (struct vw_retrain_params){.views = views, .view_count = count, .seed = curve->first_seed + seed};
}

// The PSNR of the next point, mean over its seeds.
static double take_point(struct curve *curve) {
    double psnr_db = 0;
    for (uint32_t seed = 0; seed < VW_SUBSET_SEEDS; seed++)
        psnr_db += quality_of(&curve->results[curve->read++]) / VW_SUBSET_SEEDS;
    return psnr_db;
}

static uint32_t moved_photos(const struct curve *curve, uint32_t percent) {
    return (curve->evaluation->photo_count * percent + 50) / 100;
}

static void add_end(struct curve *curve, const struct end *end, uint32_t percent, const uint32_t *order) {
    uint32_t count = curve->evaluation->photo_count, moved = moved_photos(curve, percent);
    uint32_t kept = end->removes ? count - moved : moved;
    bool from_start = end->removes == end->highest; // what is kept lies at the low end
    add_point(curve, order + (from_start ? 0 : count - kept), kept);
}

static enum vw_status add_row(const struct end *end, uint32_t percent, const char *method, double gain_db,
                              uint32_t trainings, struct vw_metrics *metrics) {
    char name[8];
    snprintf(name, sizeof name, "%u", percent);
    return vw_metrics_add(
        metrics, end->group, name,
        (struct vw_metric){.method = method, .value = gain_db, .ci_low = NAN, .ci_high = NAN, .count = trainings});
}

// Both ends of a random order are equivalent: one of each pair is enough.
static size_t end_stride(const struct curve *curve) { return curve->order_count > 1 ? 2 : 1; }

static void add_points(struct curve *curve) {
    uint32_t photo_count = curve->evaluation->photo_count;
    add_point(curve, curve->orders, photo_count);
    for (size_t e = 0; e < VW_ARRAY_COUNT(ends); e += end_stride(curve))
        for (size_t p = 0; p < VW_ARRAY_COUNT(percents); p++)
            for (uint32_t i = 0; moved_photos(curve, percents[p]) && i < curve->order_count; i++)
                add_end(curve, &ends[e], percents[p], curve->orders + (size_t)i * photo_count);
}

// Means over the orders.
static enum vw_status add_rows(struct curve *curve, const char *method, struct vw_metrics *metrics) {
    double whole_db = take_point(curve);
    enum vw_status status = VW_OK;
    for (size_t e = 0; !status && e < VW_ARRAY_COUNT(ends); e += end_stride(curve))
        for (size_t p = 0; !status && p < VW_ARRAY_COUNT(percents); p++) {
            double gain_db = 0;
            if (!moved_photos(curve, percents[p])) continue; // too few photos to remove any
            for (uint32_t i = 0; i < curve->order_count; i++)
                gain_db += (take_point(curve) - whole_db) / curve->order_count;
            status = add_row(&ends[e], percents[p], method, gain_db, VW_SUBSET_SEEDS * curve->order_count, metrics);
        }
    return status;
}

static enum vw_status evaluate_orders(struct curve *curve, const char *method, vw_retrain_function *retrain,
                                      void *context, struct vw_metrics *metrics) {
    size_t points = 1 + VW_ARRAY_COUNT(ends) * VW_ARRAY_COUNT(percents) * (size_t)curve->order_count;
    curve->views = vw_allocate(points * curve->evaluation->photo_count, sizeof *curve->views);
    curve->retrainings = vw_allocate(points * VW_SUBSET_SEEDS, sizeof *curve->retrainings);
    curve->results = vw_allocate(points * VW_SUBSET_SEEDS, sizeof *curve->results);
    bool enough = curve->views && curve->retrainings && curve->results;
    enum vw_status status = enough ? VW_OK : VW_ERROR_MEMORY;
    if (enough) add_points(curve);
    if (!status) status = retrain(context, curve->retrainings, curve->count, curve->results);
    if (!status) status = add_rows(curve, method, metrics);
    free(curve->views);
    free(curve->retrainings);
    free(curve->results);
    return status;
}

uint32_t vw_curve_trainings(void) { return VW_SUBSET_SEEDS * (1 + VW_ARRAY_COUNT(ends) * VW_ARRAY_COUNT(percents)); }

// Lowest score first; of equal ones the earlier photo.
static void order_by(const double *scores, uint32_t count, uint32_t *order) {
    for (uint32_t i = 0; i < count; i++) {
        uint32_t place = i;
        for (; place > 0 && scores[order[place - 1]] > scores[i]; place--) order[place] = order[place - 1];
        order[place] = i;
    }
}

enum vw_status vw_evaluate_curve(const struct vw_evaluation *evaluation, const struct vw_scorer *scorer,
                                 uint64_t first_seed, vw_retrain_function *retrain, void *context,
                                 struct vw_metrics *metrics) {
    if (!all_finite(scorer->scores, evaluation->photo_count)) return VW_OK; // they give no order
    uint32_t *order = vw_allocate(evaluation->photo_count, sizeof *order);
    if (!order) return VW_ERROR_MEMORY;
    struct curve curve = {.evaluation = evaluation, .first_seed = first_seed, .orders = order, .order_count = 1};
    order_by(scorer->scores, evaluation->photo_count, order);
    enum vw_status status = evaluate_orders(&curve, scorer->name, retrain, context, metrics);
    free(order);
    return status;
}

enum vw_status vw_evaluate_random_curve(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                        vw_retrain_function *retrain, void *context, struct vw_metrics *metrics) {
    uint32_t *orders = vw_allocate(evaluation->photo_count, VW_CURVE_ORDERS * sizeof *orders);
    if (!orders) return VW_ERROR_MEMORY;
    struct curve curve = {
        .evaluation = evaluation, .first_seed = first_seed, .orders = orders, .order_count = VW_CURVE_ORDERS};
    for (uint32_t i = 0; i < VW_CURVE_ORDERS; i++)
        vw_random_order(RANDOM_ORDER_SEED, i, evaluation->photo_count, orders + (size_t)i * evaluation->photo_count);
    enum vw_status status = evaluate_orders(&curve, "random", retrain, context, metrics);
    free(orders);
    return status;
}

// ---- Leave one out ----

// Training on all photos but one, whose place is left_out; on all of them when it is the number of photos.
static struct vw_retrain_params retraining_without(const struct vw_evaluation *evaluation, uint32_t left_out,
                                                   uint64_t seed, uint32_t *views) {
    struct vw_retrain_params retraining = {.views = views, .seed = seed};
    for (uint32_t i = 0; i < evaluation->photo_count; i++)
        if (i != left_out) views[retraining.view_count++] = evaluation->photos[i];
    return retraining;
}

enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, double *scores) {
    uint32_t photos = evaluation->photo_count, of_seed = photos + 1, count = evaluation->seed_count * of_seed;
    uint32_t *views = vw_allocate((size_t)count * photos, sizeof *views);
    struct vw_retrain_params *retrainings = vw_allocate(count, sizeof *retrainings);
    struct vw_retrain_result *results = vw_allocate(count, sizeof *results);
    enum vw_status status = views && retrainings && results ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t i = 0; !status && i < count; i++) // of each seed first that on all photos
        retrainings[i] = retraining_without(evaluation, i % of_seed ? i % of_seed - 1 : photos,
                                            first_seed + i / of_seed, views + (size_t)i * photos);
    if (!status) status = retrain(context, retrainings, count, results);
    for (uint32_t i = 0; !status && i < count; i++)
        if (i % of_seed)
            scores[(size_t)(i / of_seed) * photos + i % of_seed - 1] =
                results[i / of_seed * of_seed].val_psnr - results[i].val_psnr;
    free(views);
    free(retrainings);
    free(results);
    return status;
}

static void mean_over_seeds(const struct vw_evaluation *evaluation, const double *scores, double *means) {
    for (uint32_t i = 0; i < evaluation->photo_count; i++) {
        means[i] = 0;
        for (uint32_t seed = 0; seed < evaluation->seed_count; seed++)
            means[i] += scores[(size_t)seed * evaluation->photo_count + i] / evaluation->seed_count;
    }
}

enum vw_status vw_evaluate_leave_one_out(const struct vw_evaluation *evaluation, const double *scores,
                                         struct vw_metrics *metrics) {
    double *worths = vw_allocate(evaluation->photo_count, 2 * sizeof *worths);
    if (!worths) return VW_ERROR_MEMORY;
    double *said = worths + evaluation->photo_count;
    enum vw_status status = VW_OK;
    mean_over_seeds(evaluation, scores, worths);
    for (uint32_t i = 0; !status && i < evaluation->scorer_count; i++) {
        struct vw_metric row = {
            .method = evaluation->scorers[i].name, .ci_low = NAN, .ci_high = NAN, .count = evaluation->photo_count};
        mean_over_seeds(evaluation, evaluation->scorers[i].scores, said);
        row.value = NAN;
        if (all_finite(worths, evaluation->photo_count) && all_finite(said, evaluation->photo_count))
            status = vw_spearman(worths, said, evaluation->photo_count, &row.value);
        if (!status) status = vw_metrics_add(metrics, "leave_one_out", "spearman", row);
    }
    free(worths);
    return status;
}
