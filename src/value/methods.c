#include "value/methods.h"

#include <math.h>
#include <stdlib.h>

#include "viewworth/memory.h"
#include "viewworth/statistics.h"

// ---- Weights of epochs ------------------------------------------------------------------------------------------------------
// Where they differ they are scaled to a mean of 1, so that the scores of a run stay comparable with the plain sum.

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

// ---- Treatments of deltas ---------------------------------------------------------------------------------------------------

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

// The visits of one epoch that have a value.
struct epoch {
    uint32_t count;
    double *deltas, *results;
};
typedef enum vw_status epoch_treatment(struct epoch *epoch);

// Applies a treatment that looks at a whole epoch to each of them.
static enum vw_status treat_epochs(struct vw_series *series, epoch_treatment *treat) {
    double *block = vw_allocate(series->count, 2 * sizeof *block);
    if (!block) return VW_ERROR_MEMORY;
    enum vw_status status = VW_OK;
    for (uint64_t first = 0, end; !status && first < series->count; first = end) {
        struct epoch epoch = {0, block, block + series->count};
        for (end = first; end < series->count && series->visits[end].epoch == series->visits[first].epoch; end++)
            if (!isnan(series->visits[end].delta)) epoch.deltas[epoch.count++] = series->visits[end].delta;
        status = treat(&epoch);
        uint32_t taken = 0;
        for (uint64_t i = first; !status && i < end; i++)
            if (!isnan(series->visits[i].delta)) series->visits[i].delta = epoch.results[taken++];
    }
    free(block);
    return status;
}

// At twice the robust spread of the epoch on either side of its median; a spread of 0 tells nothing and clips nothing.
static enum vw_status clip_epoch(struct epoch *epoch) {
    for (uint32_t i = 0; i < epoch->count; i++) epoch->results[i] = epoch->deltas[i];
    double spread = vw_robust_spread(epoch->results, epoch->count);
    for (uint32_t i = 0; i < epoch->count; i++) epoch->results[i] = epoch->deltas[i];
    double middle = vw_median(epoch->results, epoch->count); // sorts them; the deltas keep their order
    for (uint32_t i = 0; i < epoch->count; i++)
        epoch->results[i] = spread > 0 ? fmin(fmax(epoch->deltas[i], middle - 2 * spread), middle + 2 * spread) : epoch->deltas[i];
    return VW_OK;
}

static enum vw_status clip_epochs(struct vw_series *series) { return treat_epochs(series, clip_epoch); }

static enum vw_status rank_epoch(struct epoch *epoch) {
    enum vw_status status = vw_ranks(epoch->deltas, epoch->count, epoch->results);
    for (uint32_t i = 0; !status && i < epoch->count; i++)
        epoch->results[i] = epoch->count > 1 ? 2 * (epoch->results[i] - 1) / (epoch->count - 1.0) - 1 : 0;
    return status;
}

static enum vw_status rank_epochs(struct vw_series *series) { return treat_epochs(series, rank_epoch); }

// ---- The table --------------------------------------------------------------------------------------------------------------
// Sources: dv_psnr and dv_loss are the equation of Cheimariotis et al. (CAIP 2025), revisit_* the wording of its overview figure; the last
// epoch and the weights of progress are what it weighs and rejects. The others are our own, over the same deltas.

#define PSNR &vw_measure_psnr, 1
#define POOLED &vw_measure_psnr_pooled, 1
#define LOSS &vw_measure_l1, -1
#define L1_UNIT "mean absolute error"

// X(name, unit, formula, measure and its sign, form, treatment, weighting, outcome); d is the delta of a visit, e = 1 ... E the epochs
// after burn-in. The order is that of the scores.
#define METHODS(X)                                                                                                                         \
    X("dv_psnr", "dB", "sum of d", PSNR, STEP, keep, weigh_all, SUM)                                                                       \
    X("dv_loss", L1_UNIT, "sum of d", LOSS, STEP, keep, weigh_all, SUM)                                                                    \
    X("dv_psnr_pooled", "dB", "sum of d", POOLED, STEP, keep, weigh_all, SUM)                                                              \
    X("revisit_psnr", "dB", "sum of d since the photo's visit before", PSNR, REVISIT, keep, weigh_all, SUM)                                \
    X("revisit_loss", L1_UNIT, "sum of d since the photo's visit before", LOSS, REVISIT, keep, weigh_all, SUM)                             \
    X("last_epoch_psnr", "dB", "d in the last epoch", PSNR, STEP, keep, weigh_last, SUM)                                                   \
    X("linear_psnr", "dB", "sum of 2 e / (E + 1) d", PSNR, STEP, keep, weigh_linearly, SUM)                                                \
    X("exponential_psnr", "dB", "sum of w d, w = exp(3 e / E) / its mean", PSNR, STEP, keep, weigh_exponentially, SUM)                     \
    X("middle_psnr", "dB", "sum of d, E / 6 < e <= E / 2 rounded up", PSNR, STEP, keep, weigh_middle, SUM)                                 \
    X("middle_loss", L1_UNIT, "sum of d, E / 6 < e <= E / 2 rounded up", LOSS, STEP, keep, weigh_middle, SUM)                              \
    X("win_rate_psnr", "wins less losses per visit", "mean of sign(d)", PSNR, STEP, take_signs, weigh_all, MEAN)                           \
    X("win_rate_loss", "wins less losses per visit", "mean of sign(d)", LOSS, STEP, take_signs, weigh_all, MEAN)                           \
    X("root_psnr", "dB^(1/3)", "cube root of the sum of d", PSNR, STEP, keep, weigh_all, CUBE_ROOT)                                        \
    X("root_loss", L1_UNIT "^(1/3)", "cube root of the sum of d", LOSS, STEP, keep, weigh_all, CUBE_ROOT)                                  \
    X("root_sum_psnr", "dB^(1/2)", "sum of sign(d) sqrt |d|", PSNR, STEP, take_roots, weigh_all, SUM)                                      \
    X("root_sum_loss", L1_UNIT "^(1/2)", "sum of sign(d) sqrt |d|", LOSS, STEP, take_roots, weigh_all, SUM)                                \
    X("clipped_psnr", "dB", "sum of d, clipped at 2 robust spreads from its epoch's median", PSNR, STEP, clip_epochs, weigh_all, SUM)      \
    X("clipped_loss", L1_UNIT, "sum of d, clipped at 2 robust spreads from its epoch's median", LOSS, STEP, clip_epochs, weigh_all, SUM)   \
    X("rank_psnr", "mean rank", "mean rank of d in its epoch, from -1 (lowest) to 1", PSNR, STEP, rank_epochs, weigh_all, MEAN)            \
    X("rank_loss", "mean rank", "mean rank of d in its epoch, from -1 (lowest) to 1", LOSS, STEP, rank_epochs, weigh_all, MEAN)            \
    X("momentum_psnr", "dB", "sum of credits c, d(t) = sum of (1 - beta1) beta1^k c(t - k)", PSNR, DECONVOLVED, keep, weigh_all, SUM)      \
    X("momentum_loss", L1_UNIT, "sum of credits c, d(t) = sum of (1 - beta1) beta1^k c(t - k)", LOSS, DECONVOLVED, keep, weigh_all, SUM)

#define LISTED(name, unit, formula, ...) {name, unit, formula},
#define MADE(name, unit, formula, measure, form, treatment, weighting, outcome)                                                            \
    {measure, VW_FORM_##form, treatment, weighting, VW_OUTCOME_##outcome},
static const struct vw_value_method listed[] = {METHODS(LISTED)};
const struct vw_method vw_methods[] = {METHODS(MADE)};
const uint32_t vw_method_count = VW_ARRAY_COUNT(vw_methods);

const char vw_value_default_method[] = "dv_psnr";

const struct vw_value_method *vw_value_methods(uint32_t *count) {
    *count = VW_ARRAY_COUNT(listed);
    return listed;
}

bool vw_method_is_sum_of_steps(const struct vw_method *method) {
    return method->form == VW_FORM_STEP && method->treatment == keep && method->outcome == VW_OUTCOME_SUM;
}
