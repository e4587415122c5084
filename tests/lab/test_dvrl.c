// DVRL: the gradient of its network, and what it selects where features tell which photos harm.
#include "support/cmocka_test.h"

#include "lab/methods/value_network.h"

enum { PHOTOS = 20, FEATURES = 3, EPOCHS = 30 };
static uint32_t photos[PHOTOS];
static double values[PHOTOS * FEATURES];
static const char *const names[FEATURES] = {"blur", "nothing", "size"};
static const struct vw_feature_table features = {FEATURES, names, values};

// Sets up features: the first tells which photos harm, in a unit of its own; the second is the same for all.
static int set_up(void **state) {
    (void)state;
    for (uint32_t i = 0; i < PHOTOS; i++) {
        photos[i] = i;
        values[i * FEATURES] = i % 5 == 2 ? 4e-6 : 1e-6 + i * 1e-8;
        values[i * FEATURES + 1] = 7;
        values[i * FEATURES + 2] = sin(i);
    }
    return 0;
}

struct game {
    double good_db, bad_db; // gains by a good and by a bad photo
    uint64_t seed;
    uint32_t odd;
};

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *results) {
    struct game *game = context;
    for (uint32_t i = 0; i < count; i++) {
        const struct vw_retrain_params *retraining = &retrainings[i];
        game->odd += retraining->seed != game->seed || retraining->epochs != EPOCHS / 10 || !retraining->view_count;
        results[i].val_psnr = 20;
        for (uint32_t v = 0; v < retraining->view_count; v++)
            results[i].val_psnr += retraining->views[v] % 5 == 2 ? game->bad_db : game->good_db;
    }
    return VW_OK;
}

static void score(struct game *game, const struct vw_feature_table *known, uint32_t budget, double *scores) {
    const struct vw_retraining_input input = {.photos = photos,
                                              .photo_count = PHOTOS,
                                              .retrain = play,
                                              .context = game,
                                              .first_seed = game->seed = 17,
                                              .key = 2,
                                              .budget = budget,
                                              .epochs = EPOCHS,
                                              .features = known};
    struct vw_retraining_cost cost;
    ASSERT_OK(vw_retraining_method_score(&vw_dvrl, &input, scores, &cost));
    assert_int_equal(game->odd, 0);
    assert_true(cost.run_equivalents <= budget);
}

// Checks that bad photos, one of five, have scores below one limit, and good ones above another.
static void check_apart(const double *scores, double bad_most, double good_least) {
    for (uint32_t i = 0; i < PHOTOS; i++) assert_true(i % 5 == 2 ? scores[i] < bad_most : scores[i] > good_least);
}

TEST(it_selects_by_features_and_without_them) {
    struct game game = {.good_db = 0.1, .bad_db = -0.4};
    double scores[PHOTOS];
    score(&game, NULL, 200, scores);
    check_apart(scores, 0.4, 0.4);
    score(&game, &features, 40, scores); // photos that look alike share what is learned
    check_apart(scores, 0.4, 0.5);
}

// A policy that selects all, or none, learns nothing more.
TEST(it_goes_on_exploring) {
    struct game all_help = {.good_db = 0.2, .bad_db = 0.2}, all_harm = {.good_db = -0.2, .bad_db = -0.2};
    double scores[PHOTOS], mean = 0;
    score(&all_help, &features, 2000, scores);
    for (uint32_t i = 0; i < PHOTOS; i++) mean += scores[i] / PHOTOS;
    if (!(mean > 0.8 && mean < 0.95)) fail_msg("where all photos help, the mean probability is %g", mean);
    score(&all_harm, &features, 2000, scores);
    mean = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) mean += scores[i] / PHOTOS;
    if (!(mean > 0.05 && mean < 0.2)) fail_msg("where all photos harm, it is %g", mean);
}

// Returns the sum of logits times weights, whose gradient the network gives.
static double objective(struct vw_value_network *network, const double *weights) {
    double probabilities[PHOTOS], sum = 0;
    vw_value_network_apply(network, probabilities);
    for (uint32_t i = 0; i < PHOTOS; i++) sum += weights[i] * log(probabilities[i] / (1 - probabilities[i]));
    return sum;
}

TEST(its_gradient_is_that_of_finite_differences) {
    struct vw_value_network network;
    double weights[PHOTOS], step = 1e-5;
    ASSERT_OK(vw_value_network_create(&features, PHOTOS, 3, &network));
    for (uint32_t i = 0; i < PHOTOS; i++) weights[i] = cos(3 * i) + 0.2;
    for (uint32_t i = 0; i < 20; i++) { // away from the beginning, where the logit's weights are 0
        objective(&network, weights);
        vw_value_network_step(&network, weights);
    }
    double numeric[256];
    assert_true(network.param_count < 256);
    for (uint32_t i = 0; i < network.param_count; i++) {
        double param = network.params[i];
        network.params[i] = param + step;
        double above = objective(&network, weights);
        network.params[i] = param - step;
        numeric[i] = (above - objective(&network, weights)) / (2 * step);
        network.params[i] = param;
    }
    objective(&network, weights);
    vw_value_network_step(&network, weights);
    for (uint32_t i = 0; i < network.param_count; i++) // the error of differences of this step is of 1e-10
        if (!(fabs(network.d_params[i] - numeric[i]) < 1e-6))
            fail_msg("the gradient by param %u is %g, not %g", i, network.d_params[i], numeric[i]);
    vw_value_network_free(&network);
}

TEST_GROUP(set_up, NULL)
