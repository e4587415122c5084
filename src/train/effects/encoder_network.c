#include "train/effects/encoder_network.h"

#include <math.h>

#include "interface.h"

enum { LAYER_BLOCKS = ENCODER_TAPS * ENCODER4 };
_Static_assert(THUMBNAIL_PIXELS == THUMBNAIL_SIDE * THUMBNAIL_SIDE && ENCODER_LAYERS == 3 &&
                   ENCODER_LAYER2 == 4 * LAYER_BLOCKS + ENCODER4 &&
                   ENCODER_LAYER3 == ENCODER_LAYER2 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE == ENCODER_LAYER3 + 4 * LAYER_BLOCKS * ENCODER4 + ENCODER4 &&
                   ENCODER_CODE_BIAS == ENCODER_CODE + 4 * CODE4 * ENCODER4 &&
                   ENCODER_SHIFT == ENCODER_CODE_BIAS + CODE4,
               "the network's parts do not follow one another");
_Static_assert(ENCODER_ROW_LAYER2 == ENCODER4 * THUMBNAIL_PIXELS / 4 &&
                   ENCODER_ROW_LAYER3 == ENCODER_ROW_LAYER2 + ENCODER4 * THUMBNAIL_PIXELS / 16 &&
                   ENCODER_ROW_MEAN == ENCODER_ROW_LAYER3 + ENCODER4 * THUMBNAIL_PIXELS / 64 &&
                   ENCODER_ROW_CODE == ENCODER_ROW_MEAN + ENCODER4 && ENCODER_ROWS == ENCODER_ROW_CODE + CODE4,
               "its rows do not follow one another");

// He's bound by what a convolution sums; biases and the matrix to the code stay 0.
static void draw_convolution(float *values, const struct vw_drawn *drawn, uint32_t inputs) {
    vw_fill_weights(values, drawn, LAYER_BLOCKS * 4 * (uint64_t)inputs, sqrtf(6.0f / (float)(ENCODER_TAPS * inputs)));
}

void vw_encoder_initialise(uint32_t width4, float *values, const struct vw_drawn *drawn) {
    draw_convolution(values, drawn, 4);
    draw_convolution(values + 4 * ENCODER_LAYER2, drawn, 4 * ENCODER4);
    draw_convolution(values + 4 * ENCODER_LAYER3, drawn, 4 * ENCODER4);
    vw_fill_matrix(values + 4 * ENCODER_SHIFT, drawn, width4, CODE4);
}
