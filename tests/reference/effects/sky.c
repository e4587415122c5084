#include "reference/reference.h"

#include <math.h>

#include "base/random.h"

void reference_sky_read(const struct vw_model *model, const float *params, double coefficients[VW_SKY_COLUMNS][3]) {
    const float *sky = params + model->ranges[VW_SLOT_SKY].offset_bytes / sizeof *params;
    for (size_t i = 0; i < model->ranges[VW_SLOT_SKY].size_bytes / sizeof *sky; i++)
        if (i % 4 < 3) coefficients[i / 4][i % 4] = sky[i];
}

static void colour_of_sky(const double coefficients[VW_SKY_COLUMNS][3], const double direction[3], double rgb[3]) {
    double basis[VW_SKY_COLUMNS];
    reference_spherical_harmonics(direction, basis);
    for (int c = 0; c < 3; c++) {
        double logit = 0.0;
        for (int k = 0; k < VW_SKY_COLUMNS; k++) logit += coefficients[k][c] * basis[k];
        rgb[c] = 1.0 / (1.0 + exp(-logit));
    }
}

void reference_sky_d_logit(const double rgb[3], double left, const double d_colour[3], double d_logit[3]) {
    for (int c = 0; c < 3; c++) d_logit[c] = d_colour[c] * left * rgb[c] * (1.0 - rgb[c]);
}

void reference_sky_gradient(const double direction[3], const double d_logit[3],
                            double d_coefficients[VW_SKY_COLUMNS][3]) {
    double basis[VW_SKY_COLUMNS];
    reference_spherical_harmonics(direction, basis);
    for (int k = 0; k < VW_SKY_COLUMNS; k++)
        for (int c = 0; c < 3; c++) d_coefficients[k][c] += basis[k] * d_logit[c];
}

static void find_background(const struct vw_specialization *s, uint32_t ray, vw_uint4 key, double background[3]) {
    const float fixed[3] = {s->background_red, s->background_green, s->background_blue};
    uint32_t words[4];
    vw_random_words((uint64_t)key.y << 32 | key.x, VW_RANDOM_BACKGROUND, (uint64_t)key.w << 32 | key.z, ray, 0, words);
    for (int c = 0; c < 3; c++) {
        background[c] = s->effect_background ? fixed[c] : 0.0;
        if (s->training && s->effect_background == BACKGROUND_RANDOM) background[c] = (words[c] >> 8) / 16777216.0;
    }
}

void reference_backdrop(const struct vw_specialization *s, const double sky[VW_SKY_COLUMNS][3],
                        const double direction[3], uint32_t ray, vw_uint4 key, double backdrop[3]) {
    if (s->effect_sky) colour_of_sky(sky, direction, backdrop);
    else find_background(s, ray, key, backdrop);
}

void reference_target(const struct vw_specialization *s, const struct reference_photo *photo,
                      const struct vw_pixel *pixel, uint32_t ray, vw_uint4 key, double target[3]) {
    const double shown[3] = {pixel->rgba.x, pixel->rgba.y, pixel->rgba.z};
    double rgb[3], background[3], alpha = s->effect_background ? pixel->rgba.w : 1.0;
    reference_correct(photo, shown, rgb);
    find_background(s, ray, key, background);
    for (int i = 0; i < 3; i++) target[i] = alpha * rgb[i] + (1.0 - alpha) * background[i];
}
