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

void reference_appear_gradient(const struct reference_photo *photo, const double rendered[3], const double d_seen[3],
                               struct reference_photo *d_photo, double d_rendered[3]) {
    for (int c = 0; c < 3; c++) {
        d_photo->gain[c] += d_seen[c] * rendered[c];
        d_photo->bias[c] += d_seen[c];
        d_rendered[c] = d_seen[c] * (1.0 + photo->gain[c]);
    }
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
