#include "reference/reference.h"

#include <math.h>
#include <string.h>

enum { INPUTS = 4 * VISIBILITY_INPUT4, WIDTH = 4 * VISIBILITY4, PLACES = 4 * VISIBILITY_PLACE4 };

double reference_size_weight(const struct vw_specialization *s, uint64_t step) {
    double of_squares = fmax(6e-3, 5e-2 * exp(-1e-3 * (double)step)), slope;
    return s->loss == LOSS_L2 ? of_squares : reference_loss(s, sqrt(2.0 * of_squares), &slope) / 2.0;
}

// Returns the index of a weight of a matrix of 4x4 blocks.
static uint32_t weight_at(uint32_t first_column, uint32_t in_count, uint32_t out, uint32_t in) {
    return 4 * first_column + 16 * (out / 4 * (in_count / 4) + in / 4) + 4 * (in % 4) + out % 4;
}

struct pass_through { // the values of one pixel
    double inputs[INPUTS], hidden1[WIDTH], hidden2[WIDTH], visible;
};

static void go_forward(const double *network, const double *code, const double place[2], struct pass_through *it) {
    double logit = network[4 * (VISIBILITY_LOGIT + VISIBILITY4)];
    memset(it, 0, sizeof *it);
    for (uint32_t axis = 0; axis < 2; axis++) {
        it->inputs[axis] = place[axis];
        for (uint32_t k = 0; k < VISIBILITY_FREQUENCIES; k++) {
            it->inputs[4 + 4 * k + axis] = sin(ldexp(M_PI * place[axis], (int)k));
            it->inputs[4 + 4 * k + 2 + axis] = cos(ldexp(M_PI * place[axis], (int)k));
        }
    }
    it->inputs[2] = 1.0;
    memcpy(it->inputs + PLACES, code, (INPUTS - PLACES) * sizeof *code);
    for (uint32_t out = 0; out < WIDTH; out++) {
        for (uint32_t in = 0; in < INPUTS; in++)
            it->hidden1[out] += network[weight_at(0, INPUTS, out, in)] * it->inputs[in];
        it->hidden1[out] = fmax(it->hidden1[out], 0.0);
    }
    for (uint32_t out = 0; out < WIDTH; out++) {
        double sum = network[4 * VISIBILITY_BIAS2 + out];
        for (uint32_t in = 0; in < WIDTH; in++)
            sum += network[weight_at(VISIBILITY_LAYER2, WIDTH, out, in)] * it->hidden1[in];
        it->hidden2[out] = fmax(sum, 0.0);
        logit += network[4 * VISIBILITY_LOGIT + out] * it->hidden2[out];
    }
    it->visible = 1.0 / (1.0 + exp(-logit));
}

double reference_visibility(const double *network, const double *code, const double place[2]) {
    struct pass_through it;
    go_forward(network, code, place, &it);
    return it.visible;
}

void reference_visibility_gradient(const double *network, const double *code, const double place[2], double d_visible,
                                   double *d_network, double *d_code) {
    struct pass_through it;
    double d_sum1[WIDTH] = {0}, d_sum2[WIDTH];
    go_forward(network, code, place, &it);
    double d_logit = d_visible * it.visible * (1.0 - it.visible);
    d_network[4 * (VISIBILITY_LOGIT + VISIBILITY4)] += d_logit;
    for (uint32_t out = 0; out < WIDTH; out++) {
        d_network[4 * VISIBILITY_LOGIT + out] += d_logit * it.hidden2[out];
        d_sum2[out] = it.hidden2[out] > 0.0 ? d_logit * network[4 * VISIBILITY_LOGIT + out] : 0.0;
        d_network[4 * VISIBILITY_BIAS2 + out] += d_sum2[out];
        for (uint32_t in = 0; in < WIDTH; in++) {
            uint32_t at = weight_at(VISIBILITY_LAYER2, WIDTH, out, in);
            d_network[at] += d_sum2[out] * it.hidden1[in];
            d_sum1[in] += d_sum2[out] * network[at];
        }
    }
    for (uint32_t out = 0; out < WIDTH; out++)
        for (uint32_t in = 0; in < INPUTS && it.hidden1[out] > 0.0; in++) {
            uint32_t at = weight_at(0, INPUTS, out, in);
            d_network[at] += d_sum1[out] * it.inputs[in];
            if (in >= PLACES) d_code[in - PLACES] += d_sum1[out] * network[at];
        }
}
