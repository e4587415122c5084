// The effect `sky` as splats, for programs that know no sky: a dome around all others, of splats that overlap.
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "train/renderers/splats/splats.h"

enum { DOME = 2000 };
static const double RADIUS = 40.0; // box edges; splats begin within 21 of a camera
static const float WIDTH = 0.07f;  // standard deviation, in radii: what neighbours are apart (sqrt(4 pi / DOME) = 0.08)
static const float LOGIT = 5.0f;   // an opacity of 0.993
static const double GOLDEN_ANGLE = 2.399963229728653, CONSTANT_HARMONIC = 0.28209479177387814;

// Computes the colour in a direction, as shaders/effects/sky/sky.glsl does.
static void sky_colour(const vw_float4 *sky, const double d[3], double rgb[3]) {
    const double basis[VW_SKY_COLUMNS] = {CONSTANT_HARMONIC,
                                          -0.48860251190291987 * d[1],
                                          0.48860251190291987 * d[2],
                                          -0.48860251190291987 * d[0],
                                          1.0925484305920792 * d[0] * d[1],
                                          -1.0925484305920792 * d[1] * d[2],
                                          0.31539156525252005 * (3.0 * d[2] * d[2] - 1.0),
                                          -1.0925484305920792 * d[0] * d[2],
                                          0.54627421529603959 * (d[0] * d[0] - d[1] * d[1])};
    double logits[3] = {0.0};
    for (int k = 0; k < VW_SKY_COLUMNS; k++) {
        const double columns[3] = {sky[k].x, sky[k].y, sky[k].z};
        for (int i = 0; i < 3; i++) logits[i] += basis[k] * columns[i];
    }
    for (int i = 0; i < 3; i++) rgb[i] = 1.0 / (1.0 + exp(-logits[i]));
}

// Writes a splat of the dome, which lies on a spiral from pole to pole.
static void write_splat(const vw_float4 *sky, uint32_t splat, float *own, size_t column) {
    double height = 1.0 - (2.0 * splat + 1.0) / DOME, around = sqrt(1.0 - height * height), rgb[3];
    double direction[3] = {around * cos(GOLDEN_ANGLE * splat), around * sin(GOLDEN_ANGLE * splat), height};
    sky_colour(sky, direction, rgb);
    for (int i = 0; i < 3; i++) {
        own[SPLAT_MEAN * column + i] = (float)(0.5 + RADIUS * direction[i]);
        own[SPLAT_SCALE * column + i] = logf(WIDTH * (float)RADIUS);
        own[SPLAT_HARMONICS * column + i] = (float)((rgb[i] - 0.5) / CONSTANT_HARMONIC);
    }
    own[SPLAT_MEAN * column + 3] = LOGIT;
    own[SPLAT_TURN * column] = 1.0f;
}

enum vw_status vw_splats_add_sky(const vw_float4 *sky, uint32_t columns, float **params, uint32_t *count) {
    uint32_t before = *count, after = before + DOME;
    float *all = vw_allocate((size_t)columns * after, sizeof(vw_float4));
    if (!all) return VW_ERROR_MEMORY;
    for (uint32_t column = 0; column < columns; column++)
        memcpy(all + 4 * (size_t)column * after, *params + 4 * (size_t)column * before, before * sizeof(vw_float4));
    for (uint32_t i = 0; i < DOME; i++) write_splat(sky, i, all + 4 * (size_t)(before + i), 4 * (size_t)after);
    free(*params);
    *params = all;
    *count = after;
    return VW_OK;
}
