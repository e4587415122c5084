// DVRL (Yoon, Arik and Pfister, ICML 2020): a network learns, by reinforcement, which photos to select so that a short
// training on them does best. All begin from the same initial state.
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/random.h"
#include "lab/methods/trained_sets.h"
#include "lab/methods/value_network.h"

// Selections are drawn SELECTIONS at a time, which one step of the network follows, and trained on for 1 / SHORTER of
// the epochs.
enum { DRAW = 0x64, SELECTIONS = 8, SHORTER = 10 };
static const double WINDOW = 20; // selections in the moving baseline
// Keeps the mean probability within 1 - THRESHOLD and THRESHOLD.
static const double EXPLORATION = 1e3, THRESHOLD = 0.9;

struct policy {
    const struct vw_retraining_input *input;
    struct vw_value_network network;
    struct vw_trained_sets selections; // SELECTIONS of them
    double *probabilities;             // owned; [photo]
    double *d_logits;                  // owned; [photo]
    double baseline;                   // dB; NaN: none yet
};

static uint32_t short_epochs(uint32_t whole) { return whole < SHORTER ? 1 : whole / SHORTER; }

// Returns the budget of one step of the network.
static uint32_t least_budget(const struct vw_retraining_input *input) {
    return (SELECTIONS * short_epochs(input->epochs) + input->epochs - 1) / input->epochs;
}

// Draws each photo with its probability; with 1/2 if that selects none.
static void draw_selection(struct policy *policy, uint32_t set, uint32_t number) {
    const struct vw_retraining_input *input = policy->input;
    bool *has = policy->selections.has + (size_t)set * input->photo_count, some = false;
    for (uint32_t attempt = 0; !some; attempt++)
        for (uint32_t i = 0; i < input->photo_count; i++) {
            uint32_t words[4];
            vw_random_words(input->key, VW_RANDOM_ORDER, ((uint64_t)attempt << 32) + number, i, DRAW, words);
            has[i] = (double)vw_random_unit(words[0]) < (attempt ? 0.5 : policy->probabilities[i]);
            some |= has[i];
        }
    policy->selections.retrainings[set] =
        (struct vw_retrain_params){.seed = input->first_seed, .epochs = short_epochs(input->epochs)};
}

static double mean_of(const double *values, uint32_t count) {
    double mean;
    vw_mean_of_rows(values, count, 1, &mean);
    return mean;
}

// Follows REINFORCE: down the gradient of -(reward - baseline) log P(selection), and of a term that keeps it exploring.
static void follow(struct policy *policy, const double *rewards) {
    uint32_t photos = policy->input->photo_count;
    double mean = mean_of(policy->probabilities, photos);
    double outside = mean > THRESHOLD ? EXPLORATION : mean < 1 - THRESHOLD ? -EXPLORATION : 0;
    for (uint32_t i = 0; i < photos; i++) {
        double p = policy->probabilities[i];
        policy->d_logits[i] = outside * p * (1 - p) / photos;
        for (uint32_t set = 0; set < SELECTIONS; set++)
            policy->d_logits[i] -= (rewards[set] - policy->baseline) / SELECTIONS *
                                   ((double)policy->selections.has[(size_t)set * photos + i] - p);
    }
    vw_value_network_step(&policy->network, policy->d_logits);
}

// Draws selections first ... first + SELECTIONS - 1 and learns from what they reach. One without a value leaves them
// be.
static enum vw_status learn(struct policy *policy, uint32_t first) {
    double rewards[SELECTIONS], mean = 0;
    vw_value_network_apply(&policy->network, policy->probabilities);
    for (uint32_t set = 0; set < SELECTIONS; set++) draw_selection(policy, set, first + set);
    enum vw_status status = vw_trained_sets_train(policy->input, &policy->selections);
    for (uint32_t set = 0; !status && set < SELECTIONS; set++) {
        rewards[set] = policy->selections.results[set].val_psnr;
        mean += rewards[set] / SELECTIONS;
    }
    if (status || !isfinite(mean)) return status;
    if (isnan(policy->baseline)) policy->baseline = mean;
    follow(policy, rewards);
    policy->baseline += SELECTIONS / WINDOW * (mean - policy->baseline);
    return VW_OK;
}

static enum vw_status score(const struct vw_retraining_input *input, double *scores) {
    uint32_t photos = input->photo_count, selections = input->budget * input->epochs / short_epochs(input->epochs);
    struct policy policy = {.input = input,
                            .probabilities = vw_allocate(photos, sizeof *policy.probabilities),
                            .d_logits = vw_allocate(photos, sizeof *policy.d_logits),
                            .baseline = NAN};
    enum vw_status status = policy.probabilities && policy.d_logits ? VW_OK : VW_ERROR_MEMORY;
    if (!status) status = vw_trained_sets_allocate(input, SELECTIONS, &policy.selections);
    if (!status) status = vw_value_network_create(input->features, photos, input->key, &policy.network);
    for (uint32_t first = 0; !status && first + SELECTIONS <= selections; first += SELECTIONS)
        status = learn(&policy, first);
    if (!status) vw_value_network_apply(&policy.network, scores);
    vw_value_network_free(&policy.network);
    vw_trained_sets_free(&policy.selections);
    free(policy.probabilities);
    free(policy.d_logits);
    return status;
}

const struct vw_retraining_method vw_dvrl = {
    .name = "dvrl",
    .meaning = "probability that a policy selects the photo, learned from short trainings on its selections",
    .estimates = VW_EXACT_COUNT,
    .least_budget = least_budget,
    .epochs = short_epochs,
    .score = score,
};
