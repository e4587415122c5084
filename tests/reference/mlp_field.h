// The plain-C reference of the field mlp (NeRF's), in double: see reference.h. Params are numbers at the places that
// they have on the device (src/train/fields/mlp.h), so that gradients and finite differences go by the same index.
#ifndef VIEWWORTH_TESTS_REFERENCE_MLP_FIELD_H
#define VIEWWORTH_TESTS_REFERENCE_MLP_FIELD_H

#include "reference/reference.h"

enum { REFERENCE_LAYERS_MAX = 24 };

// out = first * in (+ second * a second in) + bias, then ReLU or not.
struct reference_layer {
    const char *name;
    uint32_t out, in, second_in;           // numbers; second_in: 0 without one
    uint32_t first_at, bias_at, second_at; // index of the first number on the device
    bool relu;
};

struct reference_mlp {
    uint32_t depth, width, frequencies;
    uint32_t count, param_count;                         // layers; numbers on the device, with padding
    struct reference_layer layers[REFERENCE_LAYERS_MAX]; // the trunk, then density, feature, colour, rgb
};
void reference_mlp_lay_out(uint32_t depth, uint32_t width, uint32_t frequencies, struct reference_mlp *mlp);
// Places the numbers of a layer from `at` on; returns their end.
uint32_t reference_layer_place(struct reference_layer *layer, uint32_t at);
// Returns the index of a number of a layer's first or second matrix.
uint32_t reference_mlp_index(const struct reference_layer *layer, bool second, uint32_t out, uint32_t in);

// One sample on its way through the field; owned values of every layer.
struct reference_mlp_sample {
    double position[3], direction[3], *values[REFERENCE_LAYERS_MAX], *encodings; // position's, then direction's
    double rgb[3], density;
};
struct reference_mlp_sample *reference_mlp_samples(const struct reference_mlp *mlp, uint32_t count);
// Computes rgb and density from position and direction. `shift`: what a photo's code adds to the biases of the layer
// colour.
void reference_mlp_forward(const struct reference_mlp *mlp, const double *params, const double *shift,
                           struct reference_mlp_sample *sample);
// Accumulates into d_params.
void reference_mlp_backward(const struct reference_mlp *mlp, const double *params,
                            const struct reference_mlp_sample *sample, const double d_rgb[3], double d_raw,
                            double *d_params);

#endif
