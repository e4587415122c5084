// The data value estimator of DVRL: a network from a photo's features to the probability that it is selected.
#ifndef VIEWWORTH_LAB_METHODS_VALUE_NETWORK_H
#define VIEWWORTH_LAB_METHODS_VALUE_NETWORK_H

#include "lab/methods/registry.h"

// One hidden layer of tanh, a sigmoid, and Adam. Without features a free logit per photo.
struct vw_value_network {
    uint32_t photo_count, feature_count, param_count;
    double *inputs; // owned; [photo][feature]: features of mean 0 and variance 1
    double *params; // owned; the hidden layer's weights and biases, then those of the logit; or the logits
    double *first_moments, *second_moments, *d_params; // part of `params`
    double *hidden;                                    // owned; [photo][hidden unit]
    uint32_t steps;                                    // steps of Adam so far
};

// Creates a network in which every photo has probability 1/2. `features`: NULL for none. Free it also after a failure.
enum vw_status vw_value_network_create(const struct vw_feature_table *features, uint32_t photo_count, uint64_t seed,
                                       struct vw_value_network *network);
void vw_value_network_apply(struct vw_value_network *network, double *probabilities);
// Makes one step of Adam down d_logits[photo], the gradient by the logits of the last application.
void vw_value_network_step(struct vw_value_network *network, const double *d_logits);
void vw_value_network_free(struct vw_value_network *network);

#endif
