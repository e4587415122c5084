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

struct curve {
    const struct vw_evaluation *evaluation;
    uint64_t first_seed;
    vw_retrain_function *retrain;
    void *context;
    uint32_t *views; // scratch
};

static double quality_of(const struct vw_retrain_result *result) {
    return isnan(result->test_psnr) ? result->val_psnr : result->test_psnr;
}

static bool all_finite(const double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (!isfinite(values[i])) return false;
    return true;
}

// The PSNR of training on these photos, mean over two seeds.
static enum vw_status train_on(struct curve *curve, const uint32_t *photos, uint32_t count, double *psnr_db) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count; i++) curve->views[i] = curve->evaluation->photos[photos[i]];
    vw_sort_places(curve->views, count);
    *psnr_db = 0;
    for (uint32_t seed = 0; !status && seed < VW_SUBSET_SEEDS; seed++) {
        const struct vw_retrain_params retraining = {
            .views = curve->views, .view_count = count, .seed = curve->first_seed + seed};
        struct vw_retrain_result result;
        status = curve->retrain(curve->context, &retraining, &result);
        if (!status) *psnr_db += quality_of(&result) / VW_SUBSET_SEEDS;
    }
    return status;
}

// `order`: the photos, lowest score first. Adds a share of the gain to *gain_db.
static enum vw_status train_on_end(struct curve *curve, const struct end *end, uint32_t percent, const uint32_t *order,
                                   double whole_db, uint32_t shares, double *gain_db) {
    uint32_t count = curve->evaluation->photo_count, moved = (count * percent + 50) / 100;
    uint32_t kept = end->removes ? count - moved : moved;
    bool from_start = end->removes == end->highest; // what is kept lies at the low end
    double psnr_db = NAN;
    enum vw_status status = train_on(curve, order + (from_start ? 0 : count - kept), kept, &psnr_db);
    *gain_db += (psnr_db - whole_db) / shares;
    return status;
}

static enum vw_status add_row(const struct end *end, uint32_t percent, const char *method, double gain_db,
                              uint32_t trainings, struct vw_metrics *metrics) {
    char name[8];
    snprintf(name, sizeof name, "%u", percent);
    return vw_metrics_add(
        metrics, end->group, name,
        (struct vw_metric){.method = method, .value = gain_db, .ci_low = NAN, .ci_high = NAN, .count = trainings});
}

// `orders`: several of all photos, over which the mean is taken.
static enum vw_status evaluate_orders(struct curve *curve, const char *method, const uint32_t *orders,
                                      uint32_t order_count, struct vw_metrics *metrics) {
    double whole_db = NAN;
    uint32_t photo_count = curve->evaluation->photo_count;
    size_t stride = order_count > 1 ? 2 : 1; // both ends of a random order are equivalent: one of each pair is enough
    enum vw_status status = train_on(curve, orders, photo_count, &whole_db);
    for (size_t e = 0; !status && e < VW_ARRAY_COUNT(ends); e += stride)
        for (size_t p = 0; !status && p < VW_ARRAY_COUNT(percents); p++) {
            double gain_db = 0;
            if (!((photo_count * percents[p] + 50) / 100)) continue; // too few photos to remove any
            for (uint32_t i = 0; !status && i < order_count; i++)
                status = train_on_end(curve, &ends[e], percents[p], orders + (size_t)i * photo_count, whole_db,
                                      order_count, &gain_db);
            if (!status)
                status = add_row(&ends[e], percents[p], method, gain_db, VW_SUBSET_SEEDS * order_count, metrics);
        }
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
    struct curve curve = {.evaluation = evaluation, .first_seed = first_seed, .retrain = retrain, .context = context};
    if (!all_finite(scorer->scores, evaluation->photo_count)) return VW_OK; // they give no order
    uint32_t *order = vw_allocate(evaluation->photo_count, 2 * sizeof *order);
    if (!order) return VW_ERROR_MEMORY;
    curve.views = order + evaluation->photo_count;
    order_by(scorer->scores, evaluation->photo_count, order);
    enum vw_status status = evaluate_orders(&curve, scorer->name, order, 1, metrics);
    free(order);
    return status;
}

enum vw_status vw_evaluate_random_curve(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                        vw_retrain_function *retrain, void *context, struct vw_metrics *metrics) {
    struct curve curve = {.evaluation = evaluation, .first_seed = first_seed, .retrain = retrain, .context = context};
    uint32_t *orders = vw_allocate(evaluation->photo_count, (VW_CURVE_ORDERS + 1) * sizeof *orders);
    if (!orders) return VW_ERROR_MEMORY;
    curve.views = orders + (size_t)VW_CURVE_ORDERS * evaluation->photo_count;
    for (uint32_t i = 0; i < VW_CURVE_ORDERS; i++)
        vw_random_order(RANDOM_ORDER_SEED, i, evaluation->photo_count, orders + (size_t)i * evaluation->photo_count);
    enum vw_status status = evaluate_orders(&curve, "random", orders, VW_CURVE_ORDERS, metrics);
    free(orders);
    return status;
}

// ---- Leave one out ----

static enum vw_status retrain_without(const struct vw_evaluation *evaluation, uint32_t left_out, uint64_t seed,
                                      vw_retrain_function *retrain, void *context, uint32_t *views, double *psnr_db) {
    struct vw_retrain_params retraining = {.views = views, .seed = seed};
    struct vw_retrain_result result;
    for (uint32_t i = 0; i < evaluation->photo_count; i++)
        if (i != left_out) views[retraining.view_count++] = evaluation->photos[i];
    enum vw_status status = retrain(context, &retraining, &result);
    if (!status) *psnr_db = result.val_psnr;
    return status;
}

enum vw_status vw_leave_one_out(const struct vw_evaluation *evaluation, uint64_t first_seed,
                                vw_retrain_function *retrain, void *context, double *scores) {
    uint32_t *views = vw_allocate(evaluation->photo_count, sizeof *views);
    enum vw_status status = views ? VW_OK : VW_ERROR_MEMORY;
    for (uint32_t seed = 0; !status && seed < evaluation->seed_count; seed++) {
        double whole_db = NAN, without_db = NAN;
        status = retrain_without(evaluation, UINT32_MAX, first_seed + seed, retrain, context, views, &whole_db);
        for (uint32_t i = 0; !status && i < evaluation->photo_count; i++) {
            status = retrain_without(evaluation, i, first_seed + seed, retrain, context, views, &without_db);
            scores[(size_t)seed * evaluation->photo_count + i] = whole_db - without_db;
        }
    }
    free(views);
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
