#include "lab/methods/value_network.h"

#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"

enum { HIDDEN = 16 };
// The paper's code has these; a logit of its own moves with no other photo's, and so may move further.
static const double RATE = 0.01, FREE_RATE = 0.05, BETA1 = 0.9, BETA2 = 0.999, EPSILON = 1e-8;

// Returns the offset of a hidden unit's weights; its bias follows them.
static size_t unit_at(const struct vw_value_network *network, uint32_t unit) {
    return (size_t)unit * (network->feature_count + 1);
}

static void standardise(const struct vw_feature_table *features, uint32_t photo_count, double *inputs) {
    for (uint32_t f = 0; f < features->count; f++) {
        double mean = 0, variance = 0;
        for (uint32_t i = 0; i < photo_count; i++)
            mean += features->values[(size_t)i * features->count + f] / photo_count;
        for (uint32_t i = 0; i < photo_count; i++)
            variance += pow(features->values[(size_t)i * features->count + f] - mean, 2) / photo_count;
        for (uint32_t i = 0; i < photo_count; i++) // a feature that is the same for all tells nothing
            inputs[(size_t)i * features->count + f] =
                variance > 0 ? (features->values[(size_t)i * features->count + f] - mean) / sqrt(variance) : 0;
    }
}

// Draws the weights uniformly with variance 1 / inputs (LeCun et al. 1998); the logit's weights are 0.
static void initialise(struct vw_value_network *network, uint64_t seed) {
    double most = sqrt(3.0 / (network->feature_count + 1));
    for (uint32_t i = 0; i < unit_at(network, HIDDEN); i++) {
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_INITIALISATION, 0, i, 0, words);
        network->params[i] = most * (2 * (double)vw_random_unit(words[0]) - 1);
    }
}

enum vw_status vw_value_network_create(const struct vw_feature_table *features, uint32_t photo_count, uint64_t seed,
                                       struct vw_value_network *network) {
    uint32_t feature_count = features ? features->count : 0;
    *network = (struct vw_value_network){.photo_count = photo_count, .feature_count = feature_count};
    network->param_count = feature_count ? (uint32_t)unit_at(network, HIDDEN) + HIDDEN + 1 : photo_count;
    network->inputs = vw_allocate((size_t)photo_count * feature_count, sizeof *network->inputs);
    network->params = vw_allocate(network->param_count, 4 * sizeof *network->params);
    network->hidden = vw_allocate(photo_count, HIDDEN * sizeof *network->hidden);
    if (!network->inputs || !network->params || !network->hidden) return VW_ERROR_MEMORY;
    network->first_moments = network->params + network->param_count;
    network->second_moments = network->first_moments + network->param_count;
    network->d_params = network->second_moments + network->param_count;
    if (!feature_count) return VW_OK;
    standardise(features, photo_count, network->inputs);
    initialise(network, seed);
    return VW_OK;
}

static double logit_of(struct vw_value_network *network, uint32_t photo) {
    const double *inputs = network->inputs + (size_t)photo * network->feature_count;
    const double *out = network->params + unit_at(network, HIDDEN);
    double logit = out[HIDDEN];
    for (uint32_t unit = 0; unit < HIDDEN; unit++) {
        const double *weights = network->params + unit_at(network, unit);
        double sum = weights[network->feature_count];
        for (uint32_t f = 0; f < network->feature_count; f++) sum += weights[f] * inputs[f];
        network->hidden[(size_t)photo * HIDDEN + unit] = tanh(sum);
        logit += out[unit] * tanh(sum);
    }
    return logit;
}

void vw_value_network_apply(struct vw_value_network *network, double *probabilities) {
    for (uint32_t i = 0; i < network->photo_count; i++)
        probabilities[i] = 1 / (1 + exp(-(network->feature_count ? logit_of(network, i) : network->params[i])));
}

static void add_gradient(struct vw_value_network *network, uint32_t photo, double d_logit) {
    const double *inputs = network->inputs + (size_t)photo * network->feature_count;
    const double *out = network->params + unit_at(network, HIDDEN);
    double *d_out = network->d_params + unit_at(network, HIDDEN);
    d_out[HIDDEN] += d_logit;
    for (uint32_t unit = 0; unit < HIDDEN; unit++) {
        double hidden = network->hidden[(size_t)photo * HIDDEN + unit];
        double d_sum = d_logit * out[unit] * (1 - hidden * hidden),
               *d_weights = network->d_params + unit_at(network, unit);
        d_out[unit] += d_logit * hidden;
        for (uint32_t f = 0; f < network->feature_count; f++) d_weights[f] += d_sum * inputs[f];
        d_weights[network->feature_count] += d_sum;
    }
}

void vw_value_network_step(struct vw_value_network *network, const double *d_logits) {
    double rate = network->feature_count ? RATE : FREE_RATE;
    for (uint32_t i = 0; i < network->param_count; i++) network->d_params[i] = 0;
    for (uint32_t i = 0; i < network->photo_count; i++)
        if (network->feature_count) add_gradient(network, i, d_logits[i]);
        else network->d_params[i] = d_logits[i];
    network->steps++;
    for (uint32_t i = 0; i < network->param_count; i++) {
        double d = network->d_params[i], *first = &network->first_moments[i], *second = &network->second_moments[i];
        *first = BETA1 * *first + (1 - BETA1) * d;
        *second = BETA2 * *second + (1 - BETA2) * d * d;
        network->params[i] -= rate * *first / (1 - pow(BETA1, network->steps)) /
                              (sqrt(*second / (1 - pow(BETA2, network->steps))) + EPSILON);
    }
}

void vw_value_network_free(struct vw_value_network *network) {
    free(network->inputs);
    free(network->params);
    free(network->hidden);
}
