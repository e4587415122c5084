// The plain-C reference of the effect transient, in double: see reference.h.
#ifndef VIEWWORTH_TESTS_REFERENCE_TRANSIENT_H
#define VIEWWORTH_TESTS_REFERENCE_TRANSIENT_H

#include "reference/mlp_field.h"

enum { REFERENCE_TRANSIENT_CODE = 16, REFERENCE_HEAD_MAX = 8, REFERENCE_HEAD_OUTPUTS = 5 };

// The head: hidden layers with ReLU, of which the first takes in features and code, and one of five numbers. Indices of
// params are those of the range weights on the device.
struct reference_head {
    uint32_t features, width, count; // count: layers, the last among them
    struct reference_layer layers[REFERENCE_HEAD_MAX];
    uint32_t end_at; // index of the number after its params
};
void reference_head_lay_out(uint32_t features, uint32_t width, uint32_t depth, uint32_t first_at,
                            struct reference_head *head);
// Computes the head's outputs for a sample's features: logits of rgb, raw density, raw uncertainty.
void reference_head_forward(const struct reference_head *head, const double *params, const double *features,
                            const double *code, double outputs[REFERENCE_HEAD_OUTPUTS]);

// The loss of a ray of weight 1 (NeRF-W, equations 8 to 13; shaders/effects/transient/transient.glsl says by what it is
// scaled), and its colour. `outputs`: of the head, five a sample.
struct reference_transient_ray {
    const struct reference_point *points;
    const double (*outputs)[REFERENCE_HEAD_OUTPUTS];
    uint32_t count;
    const double *backdrop, *target;
    double beta_min;
};
double reference_transient_loss(const struct reference_transient_ray *ray, double colour[3]);

#endif
