#include "reference/mlp_field.h"
#include "support/cmocka_test.h"

#include "base/memory.h"

enum { SKIP = 5, DIRECTION_FREQUENCIES = 4 }; // the layer of the trunk that takes in the encoding again

static uint32_t fours(uint32_t numbers) { return (numbers + 3) / 4; }

uint32_t reference_layer_place(struct reference_layer *layer, uint32_t at) {
    layer->first_at = at;
    layer->bias_at = at + 16 * fours(layer->out) * fours(layer->in);
    layer->second_at = layer->bias_at + 4 * fours(layer->out);
    return layer->second_at + 16 * fours(layer->out) * fours(layer->second_in);
}

static void add_layer(struct reference_mlp *mlp, const char *name, uint32_t out, uint32_t in, uint32_t second_in,
                      bool relu) {
    struct reference_layer *layer = &mlp->layers[mlp->count++];
    *layer = (struct reference_layer){.name = name, .out = out, .in = in, .second_in = second_in, .relu = relu};
    mlp->param_count = reference_layer_place(layer, mlp->param_count);
}

void reference_mlp_lay_out(uint32_t depth, uint32_t width, uint32_t frequencies, struct reference_mlp *mlp) {
    *mlp = (struct reference_mlp){.depth = depth, .width = width, .frequencies = frequencies};
    uint32_t encoding = 3 + 6 * frequencies;
    for (uint32_t i = 0; i < depth; i++)
        add_layer(mlp, "trunk", width, i ? width : encoding, i == SKIP ? encoding : 0, true);
    add_layer(mlp, "density", 1, width, 0, false);
    add_layer(mlp, "feature", width, width, 0, false);
    add_layer(mlp, "colour", width / 2, width, 3 + 6 * DIRECTION_FREQUENCIES, true);
    add_layer(mlp, "rgb", 3, width / 2, 0, false);
}

uint32_t reference_mlp_index(const struct reference_layer *layer, bool second, uint32_t out, uint32_t in) {
    uint32_t columns = fours(second ? layer->second_in : layer->in);
    return (second ? layer->second_at : layer->first_at) + 16 * (out / 4 * columns + in / 4) + 4 * (in % 4) + out % 4;
}

// Lists three numbers and their sines and cosines: 3 + 6 * frequencies numbers.
static void encode(const double v[3], uint32_t frequencies, double *encoding) {
    for (int i = 0; i < 3; i++) encoding[i] = v[i];
    for (uint32_t k = 0; k < frequencies; k++)
        for (int i = 0; i < 3; i++) {
            double turns = fmod(ldexp(v[i], (int)k), 2.0); // exact; M_PI times a large number is not
            encoding[3 + 6 * k + (uint32_t)i] = sin(M_PI * turns);
            encoding[6 + 6 * k + (uint32_t)i] = cos(M_PI * turns);
        }
}

struct reference_mlp_sample *reference_mlp_samples(const struct reference_mlp *mlp, uint32_t count) {
    struct reference_mlp_sample *samples = test_allocate(count, sizeof *samples);
    for (uint32_t i = 0; i < count; i++) {
        samples[i].encodings = test_allocate(6 + 6 * (mlp->frequencies + DIRECTION_FREQUENCIES), sizeof(double));
        for (uint32_t l = 0; l < mlp->count; l++)
            samples[i].values[l] = test_allocate(mlp->layers[l].out, sizeof(double));
    }
    return samples;
}

static const double *direction_of(const struct reference_mlp *mlp, const struct reference_mlp_sample *sample) {
    return sample->encodings + 3 + 6 * mlp->frequencies;
}

static void operands(const struct reference_mlp *mlp, const struct reference_mlp_sample *sample, uint32_t l,
                     const double **first, const double **second) {
    uint32_t last = mlp->depth - 1;
    *second = l < mlp->depth ? sample->encodings : direction_of(mlp, sample);
    if (l == 0) *first = sample->encodings;
    else *first = sample->values[l > mlp->depth && l < mlp->depth + 2 ? last : l - 1];
}

void reference_mlp_forward(const struct reference_mlp *mlp, const double *params, const double *shift,
                           struct reference_mlp_sample *sample) {
    double centred[3];
    for (int i = 0; i < 3; i++) centred[i] = 2.0 * sample->position[i] - 1.0;
    encode(centred, mlp->frequencies, sample->encodings);
    encode(sample->direction, DIRECTION_FREQUENCIES, sample->encodings + 3 + 6 * mlp->frequencies);
    for (uint32_t l = 0; l < mlp->count; l++) {
        const struct reference_layer *layer = &mlp->layers[l];
        const double *first, *second;
        operands(mlp, sample, l, &first, &second);
        for (uint32_t out = 0; out < layer->out; out++) {
            double sum = params[layer->bias_at + out] + (shift && l == mlp->depth + 2 ? shift[out] : 0.0);
            for (uint32_t in = 0; in < layer->in; in++)
                sum += params[reference_mlp_index(layer, false, out, in)] * first[in];
            for (uint32_t in = 0; in < layer->second_in; in++)
                sum += params[reference_mlp_index(layer, true, out, in)] * second[in];
            sample->values[l][out] = layer->relu && sum < 0.0 ? 0.0 : sum;
        }
    }
    sample->density = fmin(exp(sample->values[mlp->depth][0]), reference_density_max);
    for (int i = 0; i < 3; i++) sample->rgb[i] = 1.0 / (1.0 + exp(-sample->values[mlp->depth + 3][i]));
}

// Goes back through layer l. d_in: gradient by the first input, NULL for an encoding; accumulates.
static void layer_back(const struct reference_mlp *mlp, const double *params, const struct reference_mlp_sample *sample,
                       uint32_t l, const double *d_out, double *d_in, double *d_params) {
    const struct reference_layer *layer = &mlp->layers[l];
    const double *first, *second;
    operands(mlp, sample, l, &first, &second);
    for (uint32_t out = 0; out < layer->out; out++) {
        double d = layer->relu && !(sample->values[l][out] > 0.0) ? 0.0 : d_out[out];
        d_params[layer->bias_at + out] += d;
        for (uint32_t in = 0; in < layer->in; in++) {
            d_params[reference_mlp_index(layer, false, out, in)] += d * first[in];
            if (d_in) d_in[in] += d * params[reference_mlp_index(layer, false, out, in)];
        }
        for (uint32_t in = 0; in < layer->second_in; in++)
            d_params[reference_mlp_index(layer, true, out, in)] += d * second[in];
    }
}

void reference_mlp_backward(const struct reference_mlp *mlp, const double *params,
                            const struct reference_mlp_sample *sample, const double d_rgb[3], double d_raw,
                            double *d_params) {
    double d_logit[3], cut = sample->density >= reference_density_max ? 0.0 : d_raw;
    double *d_values[REFERENCE_LAYERS_MAX];
    for (int i = 0; i < 3; i++) d_logit[i] = d_rgb[i] * sample->rgb[i] * (1.0 - sample->rgb[i]);
    for (uint32_t l = 0; l < mlp->count; l++) d_values[l] = vw_allocate(mlp->layers[l].out, sizeof(double));
    uint32_t depth = mlp->depth;
    layer_back(mlp, params, sample, depth + 3, d_logit, d_values[depth + 2], d_params);
    layer_back(mlp, params, sample, depth + 2, d_values[depth + 2], d_values[depth + 1], d_params);
    layer_back(mlp, params, sample, depth + 1, d_values[depth + 1], d_values[depth - 1], d_params);
    layer_back(mlp, params, sample, depth, &cut, d_values[depth - 1], d_params);
    for (uint32_t l = depth; l-- > 0;)
        layer_back(mlp, params, sample, l, d_values[l], l ? d_values[l - 1] : NULL, d_params);
    for (uint32_t l = 0; l < mlp->count; l++) free(d_values[l]);
}
