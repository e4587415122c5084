#include "reference.h"

#include <math.h>
#include <string.h>

const double reference_density_max = 3e6;

void reference_matrices(const struct vw_specialization *s, struct reference_weights *weights,
                        struct reference_matrix matrices[REFERENCE_MATRICES]) {
    uint32_t width = 4 * s->width4, encoding = 2 * s->levels * s->feature_pairs;
    matrices[0] = (struct reference_matrix){"density1", weights->density1, width, encoding};
    matrices[1] = (struct reference_matrix){"density2", weights->density2, REFERENCE_GEO, width};
    matrices[2] = (struct reference_matrix){"colour1", weights->colour1, width, REFERENCE_COLOUR_IN};
    matrices[3] = (struct reference_matrix){"colour2", weights->colour2, REFERENCE_RGB, width};
}

uint32_t reference_block_index(const struct vw_specialization *s, uint32_t matrix, uint32_t out, uint32_t in) {
    struct reference_weights unused;
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, &unused, matrices);
    uint32_t first = 0;
    for (uint32_t i = 0; i < matrix; i++)
        first += matrices[i].out * matrices[i].in; // all but the last are whole blocks
    uint32_t block = out / 4 * (matrices[matrix].in / 4) + in / 4;
    return first + 16 * block + 4 * (in % 4) + out % 4;
}

void reference_weights_from_blocks(const struct vw_specialization *s, const float *blocks,
                                   struct reference_weights *weights) {
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, weights, matrices);
    for (uint32_t m = 0; m < REFERENCE_MATRICES; m++)
        for (uint32_t out = 0; out < matrices[m].out; out++)
            for (uint32_t in = 0; in < matrices[m].in; in++)
                matrices[m].values[out * matrices[m].in + in] = blocks[reference_block_index(s, m, out, in)];
}

static void multiply(const struct reference_matrix *matrix, const double *in, double *out) {
    for (uint32_t i = 0; i < matrix->out; i++) {
        out[i] = 0.0;
        for (uint32_t j = 0; j < matrix->in; j++) out[i] += matrix->values[i * matrix->in + j] * in[j];
    }
}

static void multiply_transposed(const struct reference_matrix *matrix, const double *d_out, double *d_in) {
    for (uint32_t j = 0; j < matrix->in; j++) {
        d_in[j] = 0.0;
        for (uint32_t i = 0; i < matrix->out; i++) d_in[j] += matrix->values[i * matrix->in + j] * d_out[i];
    }
}

static void add_outer_product(const struct reference_matrix *matrix, const double *d_out, const double *in) {
    for (uint32_t i = 0; i < matrix->out; i++)
        for (uint32_t j = 0; j < matrix->in; j++) matrix->values[i * matrix->in + j] += d_out[i] * in[j];
}

static void rectify(uint32_t count, const double *before, double *after, bool *active) {
    for (uint32_t i = 0; i < count; i++) {
        active[i] = before[i] > 0.0;
        after[i] = before[i] < 0.0 ? 0.0 : before[i]; // NaN stays
    }
}

void reference_networks_forward(const struct vw_specialization *s, const struct reference_weights *weights,
                                struct reference_sample *sample) {
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, (struct reference_weights *)weights, matrices); // only read here
    double harmonics[9], logit[REFERENCE_RGB];
    multiply(&matrices[0], sample->encoding, sample->before1);
    rectify(4 * s->width4, sample->before1, sample->hidden1, sample->active1);
    multiply(&matrices[1], sample->hidden1, sample->geo);
    sample->density = exp(sample->geo[0]);
    sample->saturated = sample->density > reference_density_max;
    if (sample->saturated) sample->density = reference_density_max;

    reference_spherical_harmonics(sample->direction, harmonics);
    sample->colour_in[0] = harmonics[0];
    memcpy(sample->colour_in + 1, sample->geo + 1, (REFERENCE_GEO - 1) * sizeof(double));
    memcpy(sample->colour_in + REFERENCE_GEO, harmonics + 1, 8 * sizeof(double));
    multiply(&matrices[2], sample->colour_in, sample->before2);
    rectify(4 * s->width4, sample->before2, sample->hidden2, sample->active2);
    multiply(&matrices[3], sample->hidden2, logit);
    for (int i = 0; i < REFERENCE_RGB; i++) sample->rgb[i] = 1.0 / (1.0 + exp(-logit[i]));
}

void reference_networks_backward(const struct vw_specialization *s, const struct reference_weights *weights,
                                 const struct reference_sample *sample, const double d_rgb[3], double d_raw,
                                 struct reference_d_sample *d_sample) {
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, (struct reference_weights *)weights, matrices); // only read here
    uint32_t width = 4 * s->width4;
    double d_colour_in[REFERENCE_COLOUR_IN];
    for (int i = 0; i < REFERENCE_RGB; i++) d_sample->logit[i] = d_rgb[i] * sample->rgb[i] * (1.0 - sample->rgb[i]);
    multiply_transposed(&matrices[3], d_sample->logit, d_sample->hidden2);
    for (uint32_t i = 0; i < width; i++) d_sample->hidden2[i] *= sample->active2[i];
    multiply_transposed(&matrices[2], d_sample->hidden2, d_colour_in);
    memcpy(d_sample->geo, d_colour_in, sizeof d_sample->geo);
    d_sample->geo[0] = sample->saturated ? 0.0 : d_raw; // input 0 of the colour network is a constant
    multiply_transposed(&matrices[1], d_sample->geo, d_sample->hidden1);
    for (uint32_t i = 0; i < width; i++) d_sample->hidden1[i] *= sample->active1[i];
    multiply_transposed(&matrices[0], d_sample->hidden1, d_sample->encoding);
}

void reference_weights_gradient(const struct vw_specialization *s, const struct reference_sample *sample,
                                const struct reference_d_sample *d_sample, struct reference_weights *d_weights) {
    struct reference_matrix matrices[REFERENCE_MATRICES];
    reference_matrices(s, d_weights, matrices);
    add_outer_product(&matrices[0], d_sample->hidden1, sample->encoding);
    add_outer_product(&matrices[1], d_sample->geo, sample->hidden1);
    add_outer_product(&matrices[2], d_sample->hidden2, sample->colour_in);
    add_outer_product(&matrices[3], d_sample->logit, sample->hidden2);
}
