#include "reference/effects/transient.h"

#include <math.h>
#include <string.h>

static void add_layer(struct reference_head *head, uint32_t out, uint32_t in, uint32_t second_in) {
    struct reference_layer *layer = &head->layers[head->count++];
    *layer = (struct reference_layer){.name = "head", .out = out, .in = in, .second_in = second_in};
    layer->relu = out != REFERENCE_HEAD_OUTPUTS;
    head->end_at = reference_layer_place(layer, head->end_at);
}

void reference_head_lay_out(uint32_t features, uint32_t width, uint32_t depth, uint32_t first_at,
                            struct reference_head *head) {
    *head = (struct reference_head){.features = features, .width = width, .end_at = first_at};
    for (uint32_t i = 0; i < depth; i++) add_layer(head, width, i ? width : features, i ? 0 : REFERENCE_TRANSIENT_CODE);
    add_layer(head, REFERENCE_HEAD_OUTPUTS, width, 0);
}

void reference_head_forward(const struct reference_head *head, const double *params, const double *features,
                            const double *code, double outputs[REFERENCE_HEAD_OUTPUTS]) {
    enum { WIDTH_MAX = 256 };
    double values[2][WIDTH_MAX];
    const double *from = features;
    for (uint32_t l = 0; l < head->count; l++) {
        const struct reference_layer *layer = &head->layers[l];
        double *to = values[l % 2];
        for (uint32_t out = 0; out < layer->out; out++) {
            double sum = params[layer->bias_at + out];
            for (uint32_t in = 0; in < layer->in; in++)
                sum += params[reference_mlp_index(layer, false, out, in)] * from[in];
            for (uint32_t in = 0; in < layer->second_in; in++)
                sum += params[reference_mlp_index(layer, true, out, in)] * code[in];
            to[out] = layer->relu && sum < 0.0 ? 0.0 : sum;
        }
        from = to;
    }
    memcpy(outputs, from, REFERENCE_HEAD_OUTPUTS * sizeof *outputs);
}

static double softplus(double x) { return x > 30.0 ? x : log1p(exp(x)); }

double reference_transient_loss(const struct reference_transient_ray *ray, double colour[3]) {
    double tau = 0.0, beta = ray->beta_min, density_sum = 0.0, square = 0.0;
    for (int c = 0; c < 3; c++) colour[c] = 0.0;
    for (uint32_t i = 0; i < ray->count; i++) {
        const struct reference_point *point = &ray->points[i];
        const double *out = ray->outputs[i];
        double density = softplus(out[3]), reached = exp(-tau);
        double weight = reached * -expm1(-point->density * point->length),
               transient_weight = reached * -expm1(-density * point->length);
        for (int c = 0; c < 3; c++) colour[c] += weight * point->rgb[c] + transient_weight / (1.0 + exp(-out[c]));
        beta += transient_weight * softplus(out[4]);
        density_sum += density;
        tau += (point->density + density) * point->length;
    }
    for (int c = 0; c < 3; c++) colour[c] += exp(-tau) * ray->backdrop[c];
    for (int c = 0; c < 3; c++) square += pow(colour[c] - ray->target[c], 2.0) / 3.0;
    // NeRF-W's loss, and what it would be without error and with the least uncertainty.
    double loss = square / (2.0 * beta * beta) + log(beta) + 0.01 * density_sum / ray->count,
           least = log(ray->beta_min);
    return 2.0 * ray->beta_min * ray->beta_min * (loss - least);
}
