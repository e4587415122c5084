#include "reference/reference.h"

#include <math.h>
#include <string.h>

enum {
    INPUTS_MOST = 4 * VISIBILITY_INPUT4,
    WIDTH = 4 * VISIBILITY4,
    PLACES = 4 * VISIBILITY_PLACE4,
    CODE = 4 * VISIBILITY_CODE4,
    FEATURES = 4 * FEATURE4
};
_Static_assert((int)FEATURES <= (int)INPUTS_MOST, "a network has more inputs than there is room for");

// The sizes of a network: its inputs, and the first columns of its parts.
struct sizes {
    uint32_t inputs, layer2, bias2, logit;
};
static const struct sizes of_visibility = {INPUTS_MOST, VISIBILITY_LAYER2, VISIBILITY_BIAS2, VISIBILITY_LOGIT},
                          of_uncertainty = {FEATURES, UNCERTAINTY_LAYER2, UNCERTAINTY_BIAS2, UNCERTAINTY_LOGIT};

static double early_square(uint64_t step) { return 5e-2 * exp(-1e-3 * (double)step); }

double reference_size_weight(const struct vw_specialization *s, uint64_t step) {
    double of_squares = fmax(6e-3, early_square(step)), slope;
    return s->loss == LOSS_L2 ? of_squares : reference_loss(s, sqrt(2.0 * of_squares), &slope) / 2.0;
}

// Returns the index of a weight of a matrix of 4x4 blocks.
static uint32_t weight_at(uint32_t first_column, uint32_t in_count, uint32_t out, uint32_t in) {
    return 4 * first_column + 16 * (out / 4 * (in_count / 4) + in / 4) + 4 * (in % 4) + out % 4;
}

struct pass_through { // the values of one pixel
    double inputs[INPUTS_MOST], hidden1[WIDTH], hidden2[WIDTH], weight;
};

static void go_forward(const struct sizes *sizes, const double *network, struct pass_through *it) {
    double logit = network[4 * (sizes->logit + VISIBILITY4)];
    for (uint32_t out = 0; out < WIDTH; out++) {
        double sum = 0.0;
        for (uint32_t in = 0; in < sizes->inputs; in++)
            sum += network[weight_at(0, sizes->inputs, out, in)] * it->inputs[in];
        it->hidden1[out] = fmax(sum, 0.0);
    }
    for (uint32_t out = 0; out < WIDTH; out++) {
        double sum = network[4 * sizes->bias2 + out];
        for (uint32_t in = 0; in < WIDTH; in++)
            sum += network[weight_at(sizes->layer2, WIDTH, out, in)] * it->hidden1[in];
        it->hidden2[out] = fmax(sum, 0.0);
        logit += network[4 * sizes->logit + out] * it->hidden2[out];
    }
    it->weight = 1.0 / (1.0 + exp(-logit));
}

// Accumulates the gradients by the network and by the inputs.
static void go_back(const struct sizes *sizes, const double *network, const struct pass_through *it, double d_weight,
                    double *d_network, double *d_inputs) {
    double d_sum1[WIDTH] = {0}, d_sum2[WIDTH], d_logit = d_weight * it->weight * (1.0 - it->weight);
    d_network[4 * (sizes->logit + VISIBILITY4)] += d_logit;
    for (uint32_t out = 0; out < WIDTH; out++) {
        d_network[4 * sizes->logit + out] += d_logit * it->hidden2[out];
        d_sum2[out] = it->hidden2[out] > 0.0 ? d_logit * network[4 * sizes->logit + out] : 0.0;
        d_network[4 * sizes->bias2 + out] += d_sum2[out];
        for (uint32_t in = 0; in < WIDTH; in++) {
            uint32_t at = weight_at(sizes->layer2, WIDTH, out, in);
            d_network[at] += d_sum2[out] * it->hidden1[in];
            d_sum1[in] += d_sum2[out] * network[at];
        }
    }
    for (uint32_t out = 0; out < WIDTH; out++)
        for (uint32_t in = 0; in < sizes->inputs && it->hidden1[out] > 0.0; in++) {
            uint32_t at = weight_at(0, sizes->inputs, out, in);
            d_network[at] += d_sum1[out] * it->inputs[in];
            d_inputs[in] += d_sum1[out] * network[at];
        }
}

// ---- visibility -----------------------------------------------------------------------------------------------------

static struct pass_through look_at(const double *network, const double *code, const double place[2]) {
    struct pass_through it = {0};
    for (uint32_t axis = 0; axis < 2; axis++) {
        it.inputs[axis] = place[axis];
        for (uint32_t k = 0; k < VISIBILITY_FREQUENCIES; k++) {
            it.inputs[4 + 4 * k + axis] = sin(ldexp(M_PI * place[axis], (int)k));
            it.inputs[4 + 4 * k + 2 + axis] = cos(ldexp(M_PI * place[axis], (int)k));
        }
    }
    it.inputs[2] = 1.0;
    memcpy(it.inputs + PLACES, code, CODE * sizeof *code);
    go_forward(&of_visibility, network, &it);
    return it;
}

double reference_visibility(const double *network, const double *code, const double place[2]) {
    return look_at(network, code, place).weight;
}

void reference_visibility_gradient(const double *network, const double *code, const double place[2], double d_visible,
                                   double *d_network, double *d_code) {
    struct pass_through it = look_at(network, code, place);
    double d_inputs[INPUTS_MOST] = {0};
    go_back(&of_visibility, network, &it, d_visible, d_network, d_inputs);
    for (uint32_t k = 0; k < CODE; k++) d_code[k] += d_inputs[PLACES + k];
}

// ---- uncertainty ----------------------------------------------------------------------------------------------------

double reference_certain_loss(const struct vw_specialization *s, uint64_t step) {
    double slope;
    return reference_loss(s, sqrt(fmax((double)s->beta_min * s->beta_min, early_square(step))), &slope);
}

double reference_certainty(const double *network, const double *features) {
    struct pass_through it;
    memcpy(it.inputs, features, FEATURES * sizeof *features);
    go_forward(&of_uncertainty, network, &it);
    return it.weight;
}

void reference_certainty_gradient(const double *network, const double *features, double d_certain, double *d_network) {
    struct pass_through it;
    double d_inputs[INPUTS_MOST] = {0};
    memcpy(it.inputs, features, FEATURES * sizeof *features);
    go_forward(&of_uncertainty, network, &it);
    go_back(&of_uncertainty, network, &it, d_certain, d_network, d_inputs);
}
