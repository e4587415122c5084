#include "reference/reference.h"

#include <math.h>
#include <string.h>

const double reference_photo_ridge = 0.01, reference_fit_ridge = 0.1;

double reference_photo_rate(uint64_t visits) { return 20.0 / sqrt((double)visits); }

uint32_t reference_photo_count(const struct vw_model *model) {
    if (model->ranges[VW_SLOT_APPEARANCE].size_bytes)
        return (uint32_t)(model->ranges[VW_SLOT_APPEARANCE].size_bytes / (8 * sizeof(float)));
    return (uint32_t)(model->ranges[VW_SLOT_CODES].size_bytes / (REFERENCE_CODE * sizeof(float)));
}

struct reference_photo reference_photo_of(const struct vw_model *model, const float *params, uint32_t view) {
    struct reference_photo photo = {0};
    const float *affine = params + model->ranges[VW_SLOT_APPEARANCE].offset_bytes / sizeof *params + 8 * view;
    const float *code = params + model->ranges[VW_SLOT_CODES].offset_bytes / sizeof *params + REFERENCE_CODE * view;
    for (uint32_t c = 0; c < 3 && model->ranges[VW_SLOT_APPEARANCE].size_bytes; c++) {
        photo.gain[c] = affine[c];
        photo.bias[c] = affine[4 + c];
    }
    for (uint32_t k = 0; k < REFERENCE_CODE && model->ranges[VW_SLOT_CODES].size_bytes; k++) photo.code[k] = code[k];
    return photo;
}

void reference_appear(const struct reference_photo *photo, const double rendered[3], double seen[3]) {
    for (int c = 0; c < 3; c++) seen[c] = (1.0 + photo->gain[c]) * rendered[c] + photo->bias[c];
}

void reference_correct(const struct reference_photo *photo, const double shown[3], double corrected[3]) {
    for (int c = 0; c < 3; c++)
        corrected[c] = fmin(fmax((shown[c] - photo->bias[c]) / (1.0 + photo->gain[c]), 0.0), 1.0);
}

void reference_mix_code(uint32_t width, const double *code_weights, const double code[REFERENCE_CODE], double *shift) {
    memset(shift, 0, width * sizeof *shift);
    for (uint32_t i = 0; i < width; i++)
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) shift[i] += code_weights[i * REFERENCE_CODE + k] * code[k];
}

void reference_mix_code_gradient(uint32_t width, const double *code_weights, const double code[REFERENCE_CODE],
                                 const double *d_shift, double *d_code_weights, double d_code[REFERENCE_CODE]) {
    memset(d_code, 0, REFERENCE_CODE * sizeof *d_code);
    for (uint32_t i = 0; i < width; i++)
        for (uint32_t k = 0; k < REFERENCE_CODE; k++) {
            d_code_weights[i * REFERENCE_CODE + k] = d_shift[i] * code[k];
            d_code[k] += code_weights[i * REFERENCE_CODE + k] * d_shift[i];
        }
}

// Eliminates the bias, which the least sum gives for any gain; a gain at its limit has the bias that goes with it.
void reference_fit_photo(const struct reference_photo_sums *sums, struct reference_photo *photo) {
    const long double gain_pull = reference_fit_ridge, bias_pull = reference_fit_ridge + 0.1L * sums->rays,
                      least = -0.9L;
    for (int c = 0; c < 3; c++) {
        long double biased = sums->rays + bias_pull, mean = sums->rendered[c] / biased,
                    spread = sums->squares[c] + gain_pull - mean * sums->rendered[c],
                    gain = (sums->products[c] - mean * sums->missing[c]) / spread;
        if (gain < least) gain = least;
        photo->gain[c] = (double)gain;
        photo->bias[c] = (double)((sums->missing[c] - gain * sums->rendered[c]) / biased);
    }
}

struct reference_photo reference_photo_of_fits(const struct vw_photo_sums *sums, uint32_t count, uint32_t view) {
    struct reference_photo photo = {0};
    for (int c = 0; c < 3 && sums[view].gain.w > 3.0f; c++) {
        long double gain = 0.0L, bias = 0.0L, visited = 0.0L;
        for (uint32_t v = 0; v < count; v++) {
            if (sums[v].gain.w == 0.0f) continue;
            gain += (&sums[v].gain.x)[c];
            bias += (&sums[v].bias.x)[c];
            visited++;
        }
        long double ratio = (1.0L + (&sums[view].gain.x)[c]) / (1.0L + gain / visited);
        if (ratio < 0.1L) ratio = 0.1L;
        photo.gain[c] = (double)(ratio - 1.0L);
        photo.bias[c] = (double)((&sums[view].bias.x)[c] - ratio * bias / visited);
    }
    return photo;
}

// Solves the two normal equations of the ridge regression by Cramer's rule.
void reference_fit_channel(const double *rendered, const double *target, uint32_t count, double *gain, double *bias) {
    long double rr = reference_fit_ridge, r = 0.0L, n = count + (long double)reference_fit_ridge, rd = 0.0L, d = 0.0L;
    for (uint32_t i = 0; i < count; i++) {
        long double missing = (long double)target[i] - rendered[i];
        rr += (long double)rendered[i] * rendered[i];
        rd += rendered[i] * missing;
        r += rendered[i];
        d += missing;
    }
    *gain = (double)((rd * n - r * d) / (rr * n - r * r));
    *bias = (double)((rr * d - r * rd) / (rr * n - r * r));
}
