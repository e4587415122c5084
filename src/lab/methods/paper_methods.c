#include "lab/methods/paper_methods.h"

#include <math.h>

#include "base/memory.h"

// Weights that differ are scaled to a mean of 1, so that the scores remain comparable with the plain sum.

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

const struct vw_method vw_paper_methods[] = {
    {"revisit_psnr", "dB", VW_MEASURE_PSNR, VW_FORM_REVISIT, NULL},
    {"revisit_loss", "mean absolute error", VW_MEASURE_L1, VW_FORM_REVISIT, NULL},
    {"last_epoch_psnr", "dB", VW_MEASURE_PSNR, VW_FORM_STEP, weigh_last},
    {"linear_psnr", "dB", VW_MEASURE_PSNR, VW_FORM_STEP, weigh_linearly},
    {"exponential_psnr", "dB", VW_MEASURE_PSNR, VW_FORM_STEP, weigh_exponentially},
};
const uint32_t vw_paper_method_count = VW_ARRAY_COUNT(vw_paper_methods);
