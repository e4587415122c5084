#include "value/methods.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/statistics.h"

// ---- Weights of epochs ----
// Weights that differ are scaled to a mean of 1, so that the scores remain comparable with the plain sum.

static void weigh_all(double *weights, uint32_t epoch_count) {
    for (uint32_t e = 0; e < epoch_count; e++) weights[e] = 1;
}

static void weigh_last(double *weights, uint32_t epoch_count) {
    for (uint32_t e = 0; e < epoch_count; e++) weights[e] = e + 1 == epoch_count;
}

static void weigh_linearly(double *weights, uint32_t epoch_count) {
    for (uint32_t e = 0; e < epoch_count; e++) weights[e] = 2.0 * (e + 1) / (epoch_count + 1.0);
}

static void weigh_exponentially(double *weights, uint32_t epoch_count) {
    double sum = 0;
    for (uint32_t e = 0; e < epoch_count; e++) sum += weights[e] = exp(3.0 * (e + 1) / epoch_count);
    for (uint32_t e = 0; e < epoch_count; e++) weights[e] *= epoch_count / sum;
}

// From a sixth of the epochs after burn-in to half of them: epochs 5 to 15 of 30.
static void weigh_middle(double *weights, uint32_t epoch_count) {
    for (uint32_t e = 0; e < epoch_count; e++) weights[e] = e >= epoch_count / 6 && e < (epoch_count + 1) / 2;
}

// ---- Treatments of deltas ----

static enum vw_status keep(struct vw_series *series) {
    (void)series;
    return VW_OK;
}

static enum vw_status take_signs(struct vw_series *series) {
    for (uint64_t i = 0; i < series->count; i++) {
        double delta = series->visits[i].delta;
        if (!isnan(delta)) series->visits[i].delta = (delta > 0) - (delta < 0);
    }
    return VW_OK;
}

static enum vw_status take_roots(struct vw_series *series) {
    for (uint64_t i = 0; i < series->count; i++) {
        double delta = series->visits[i].delta;
        series->visits[i].delta = copysign(sqrt(fabs(delta)), delta);
    }
    return VW_OK;
}

// Clips the deltas of an epoch at three robust spreads on either side of their median. With a spread of 0, nothing is
// clipped. `values` has room for `count` numbers.
static void clip_epoch(struct vw_visit *visits, uint64_t count, double *values) {
    uint32_t valued = 0;
    for (uint64_t i = 0; i < count; i++)
        if (!isnan(visits[i].delta)) values[valued++] = visits[i].delta;
    double middle = vw_median(values, valued), most = 3 * vw_robust_spread(values, valued);
    for (uint64_t i = 0; i < count && most > 0; i++)
        if (!isnan(visits[i].delta)) visits[i].delta = fmin(fmax(visits[i].delta, middle - most), middle + most);
}

static enum vw_status clip_epochs(struct vw_series *series) {
    double *values = vw_allocate(series->count, sizeof *values);
    if (!values) return VW_ERROR_MEMORY;
    for (uint64_t first = 0, end; first < series->count; first = end) {
        for (end = first + 1; end < series->count && series->visits[end].epoch == series->visits[first].epoch;) end++;
        clip_epoch(&series->visits[first], end - first, values);
    }
    free(values);
    return VW_OK;
}

// ---- The table ----
// Sources: dv_psnr and dv_loss are the equation of Cheimariotis et al. (CAIP 2025), and revisit_* follows its overview
// figure. The paper also discusses and rejects the last epoch and progress weights. The other methods are our own.

#define PSNR &vw_measure_psnr, 1
#define POOLED &vw_measure_psnr_pooled, 1
#define LOSS &vw_measure_l1, -1
#define L1_UNIT "mean absolute error"

// X(name, unit, formula, measure and its sign, form, treatment, weighting, aggregate); d is the delta of a visit, e = 1
// ... E the epochs after burn-in. The order is that of the scores.
#define METHODS(X)                                                                                                     \
    X("dv_psnr", "dB", "sum of d", PSNR, STEP, keep, weigh_all, SUM)                                                   \
    X("dv_loss", L1_UNIT, "sum of d", LOSS, STEP, keep, weigh_all, SUM)                                                \
    X("dv_psnr_pooled", "dB", "sum of d", POOLED, STEP, keep, weigh_all, SUM)                                          \
    X("revisit_psnr", "dB", "sum of d since the photo's visit before", PSNR, REVISIT, keep, weigh_all, SUM)            \
    X("revisit_loss", L1_UNIT, "sum of d since the photo's visit before", LOSS, REVISIT, keep, weigh_all, SUM)         \
    X("last_epoch_psnr", "dB", "d in the last epoch", PSNR, STEP, keep, weigh_last, SUM)                               \
    X("linear_psnr", "dB", "sum of 2 e / (E + 1) d", PSNR, STEP, keep, weigh_linearly, SUM)                            \
    X("exponential_psnr", "dB", "sum of w d, w = exp(3 e / E) / its mean", PSNR, STEP, keep, weigh_exponentially, SUM) \
    X("middle_psnr", "dB", "sum of d, E / 6 < e <= E / 2 rounded up", PSNR, STEP, keep, weigh_middle, SUM)             \
    X("middle_loss", L1_UNIT, "sum of d, E / 6 < e <= E / 2 rounded up", LOSS, STEP, keep, weigh_middle, SUM)          \
    X("win_rate_psnr", "wins less losses per visit", "mean of sign(d)", PSNR, STEP, take_signs, weigh_all, MEAN)       \
    X("win_rate_loss", "wins less losses per visit", "mean of sign(d)", LOSS, STEP, take_signs, weigh_all, MEAN)       \
    X("root_psnr", "dB^(1/3)", "cube root of the sum of d", PSNR, STEP, keep, weigh_all, CUBE_ROOT)                    \
    X("root_loss", L1_UNIT "^(1/3)", "cube root of the sum of d", LOSS, STEP, keep, weigh_all, CUBE_ROOT)              \
    X("root_sum_psnr", "dB^(1/2)", "sum of sign(d) sqrt |d|", PSNR, STEP, take_roots, weigh_all, SUM)                  \
    X("clipped_psnr", "dB", "sum of d, clipped at 3 robust spreads from its epoch's median", PSNR, STEP, clip_epochs,  \
      weigh_all, SUM)                                                                                                  \
    X("clipped_loss", L1_UNIT, "sum of d, clipped at 3 robust spreads from its epoch's median", LOSS, STEP,            \
      clip_epochs, weigh_all, SUM)                                                                                     \
    X("momentum_psnr", "dB", "sum of (d(t) - beta1 d(t - 1)) / (1 - beta1)", PSNR, DECONVOLVED, keep, weigh_all, SUM)  \
    X("momentum_loss", L1_UNIT, "sum of (d(t) - beta1 d(t - 1)) / (1 - beta1)", LOSS, DECONVOLVED, keep, weigh_all, SUM)

#define LISTED(name, unit, formula, measure, form, treatment, weighting, aggregate)                                    \
    {name, unit, formula, VW_AGGREGATE_##aggregate == VW_AGGREGATE_SUM},
#define MADE(name, unit, formula, measure, form, treatment, weighting, aggregate)                                      \
    {measure, VW_FORM_##form, treatment, weighting, VW_AGGREGATE_##aggregate},
static const struct vw_value_method listed[] = {METHODS(LISTED)};
const struct vw_method vw_methods[] = {METHODS(MADE)};
const uint32_t vw_method_count = VW_ARRAY_COUNT(vw_methods);

const char vw_value_default_method[] = "dv_psnr";

const struct vw_value_method *vw_value_methods(uint32_t *count) {
    *count = VW_ARRAY_COUNT(listed);
    return listed;
}

bool vw_method_is_sum_of_steps(const struct vw_method *method) {
    return method->form == VW_FORM_STEP && method->treatment == keep && method->aggregate == VW_AGGREGATE_SUM;
}
