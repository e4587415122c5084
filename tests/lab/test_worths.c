// Worths of photos by regression over subsets, the signs of scores, and the reliability of outcomes, on games whose
// values are known.
#include "support/metrics.h"

#include "lab/evaluation/subset_trainings.h"
#include "support/draws.h"
#include "value/evaluation/worth_regression.h"

enum { PHOTOS = 10, FIRST_SEED = 7 };

// Photo 9 has no worth.
static const double true_worths[PHOTOS] = {0.5, 0.3, -0.4, 0.6, 0.2, -0.7, 0.4, 0.1, 0.8, 0};
static const uint32_t photos[PHOTOS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

struct game {
    double noise_db, each_db; // standard deviation of a training's outcome; what every photo adds beside its worth
};

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *outcomes) {
    const struct game *game = context;
    for (uint32_t i = 0; i < count; i++) {
        double psnr_db = 12 + game->each_db * retrainings[i].view_count;
        uint32_t key = 0;
        for (uint32_t j = 0; j < retrainings[i].view_count; j++) {
            psnr_db += true_worths[retrainings[i].views[j]];
            key = key * 31 + retrainings[i].views[j] + 1;
        }
        psnr_db += game->noise_db * test_normal(retrainings[i].seed, 3, key);
        outcomes[i] = (struct vw_retrain_result){.val_psnr = psnr_db, .test_psnr = NAN};
    }
    return VW_OK;
}

// The subsets that a test plays, and what is found from them; released after it.
static struct vw_subsets subsets;
static struct vw_worths worths;

static int begin(void **state) {
    (void)state;
    subsets = (struct vw_subsets){0};
    worths = (struct vw_worths){0};
    metrics = (struct vw_metrics){0};
    return 0;
}

static int end(void **state) {
    vw_subsets_free(&subsets);
    vw_worths_free(&worths);
    free(metrics.rows);
    return begin(state);
}

#define GAME_TEST(name) TEST_WITHIN(name, begin, end)

static void play_game(struct game game, uint32_t halves, uint32_t random_sizes, uint32_t seeds, uint64_t first_seed) {
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, halves, random_sizes, seeds, 0}, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, first_seed, play, &game));
}

static void play_subsets(double noise_db, uint32_t halves, uint32_t random_sizes, uint32_t seeds) {
    play_game((struct game){.noise_db = noise_db}, halves, random_sizes, seeds, FIRST_SEED);
}

static struct vw_worths fit(enum vw_outcome outcome) {
    struct vw_worths fitted;
    ASSERT_OK(
        vw_worths_fit(&(struct vw_worth_params){.subsets = &subsets, .outcome = outcome, .predict = true}, &fitted));
    return fitted;
}

GAME_TEST(an_additive_game_is_recovered) {
    play_subsets(0, 30, 30, 1);
    worths = fit(VW_OUTCOME_VAL_PSNR);
    for (uint32_t i = 0; i < PHOTOS; i++) assert_near(worths.values[i], true_worths[i], 1e-5);
    assert_near(worths.r2, 1, 1e-9);
    for (uint32_t i = 0; i < subsets.count; i++) assert_near(worths.predicted[i], subsets.results[i].val_psnr, 1e-4);
    assert_int_equal(worths.count, 60);
}

// Every photo adds 10 dB beside its worth. Few and noisy trainings do not tell the photos apart: their worths are
// shrunk to their mean, 10.18, and not to 0.
GAME_TEST(shrinking_keeps_the_level) {
    double mean = 0, spread = 0;
    play_game((struct game){.noise_db = 2, .each_db = 10}, 6, 6, 4, FIRST_SEED);
    worths = fit(VW_OUTCOME_VAL_PSNR);
    for (uint32_t i = 0; i < PHOTOS; i++) mean += worths.values[i] / PHOTOS;
    for (uint32_t i = 0; i < PHOTOS; i++) spread += pow(worths.values[i] - mean, 2) / PHOTOS;
    assert_near(mean, 10.18, 1);
    if (sqrt(spread) > 1) fail_msg("worths are not shrunk: their standard deviation is %g", sqrt(spread));
}

GAME_TEST(too_few_subsets_have_no_worths) {
    play_subsets(0, 5, 2, 1);
    worths = fit(VW_OUTCOME_VAL_PSNR);
    assert_true(isnan(worths.values[0]) && isnan(worths.ci_low[0]) && worths.count == 0);
    vw_worths_free(&worths);
    worths = fit(VW_OUTCOME_TEST_PSNR); // without test photos
    assert_true(isnan(worths.values[0]) && isnan(worths.r2));
}

// ---- Signs ----------------------------------------------------------------------------------------------------------

// Photos 2 and 5 harm, photo 9 is worth nothing, which its interval admits; the other seven help.
GAME_TEST(sign_accuracy_counts_photos_of_known_worth) {
    static const char *const kinds[PHOTOS] = {"clean", "clean", "noise", "clean", "clean",
                                              "noise", "clean", "clean", "clean", "clean"};
    // Finds one of the two, calls another one harmful, and also the one of no worth.
    static const double some[PHOTOS] = {1, 1, -1, 1, -1, 1, 1, 1, 1, -1}, none[PHOTOS] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    const struct vw_scorer scorers[] = {{.name = "worths", .scores = true_worths, .has_sign = true},
                                        {.name = "some", .scores = some, .has_sign = true},
                                        {.name = "none", .scores = none, .has_sign = true},
                                        {.name = "ranks", .scores = none}};
    const struct vw_evaluation evaluation = {photos, kinds, PHOTOS, scorers, 4, 1};
    play_subsets(0.02, 40, 40, 1);
    worths = fit(VW_OUTCOME_VAL_PSNR);
    assert_true(worths.ci_low[9] <= 0 && worths.ci_high[9] >= 0);
    ASSERT_OK(vw_evaluate_signs(&evaluation, &worths, "val_psnr", &metrics));
    assert_metric("sign_accuracy", "val_psnr", "worths", 1, 0);
    assert_int_equal(find_metric("sign_accuracy", "val_psnr", "worths")->count, 9);
    assert_metric("sign_accuracy", "val_psnr", "some", 7.0 / 9, 1e-15);
    assert_metric("harmful_precision", "val_psnr", "some", 1.0 / 3, 1e-15);
    assert_metric("harmful_recall", "val_psnr", "some", 0.5, 1e-15);
    assert_metric("helpful_recall", "val_psnr", "some", 6.0 / 7, 1e-15);
    assert_true(isnan(find_metric("harmful_precision", "val_psnr", "none")->value)); // it calls none harmful
    assert_metric("harmful_recall", "val_psnr", "none", 0, 0);
    assert_null(vw_metrics_find(&metrics, "sign_accuracy", "val_psnr", "ranks"));
}

// ---- Cross-fitting --------------------------------------------------------------------------------------------------

GAME_TEST(predictions_have_an_lds) {
    struct vw_worths by_truth[VW_TRUTH_COUNT];
    static const char *const kinds[PHOTOS] = {"clean", "clean", "clean", "clean", "clean",
                                              "clean", "clean", "clean", "clean", "clean"};
    const struct vw_evaluation evaluation = {.photos = photos, .ground_truths = kinds, .photo_count = PHOTOS};
    play_subsets(0, 40, 40, 2);
    for (uint32_t i = 0; i < VW_TRUTH_COUNT; i++) by_truth[i] = fit(vw_truths[i]);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, by_truth, &metrics));
    assert_metric("lds", "val_psnr", vw_subset_worth_name, 1, 0.01);
    assert_metric("lds_sizes", "val_psnr", vw_subset_worth_name, 1, 0.01);
    for (uint32_t i = 0; i < VW_TRUTH_COUNT; i++) vw_worths_free(&by_truth[i]);
}

// ---- Reliability ----------------------------------------------------------------------------------------------------

// Outcomes of which half the variance is noise: two agree by 1/2 (0.483 as Spearman's, 6/pi asin(1/4)), and the mean of
// four has a reliability of 4 * 0.483 / (1 + 3 * 0.483) = 0.789.
TEST(the_ceiling_follows_from_all_pairs_of_seeds) {
    enum { COUNT = 3000, SEEDS = 4 };
    double *values = calloc((size_t)COUNT * SEEDS, sizeof *values);
    struct vw_reliability reliability;
    assert_non_null(values);
    for (uint32_t seed = 0; seed < SEEDS; seed++)
        for (uint32_t i = 0; i < COUNT; i++)
            values[seed * COUNT + i] = test_normal(1, 3, i) + test_normal(2 + seed, 3, i);
    ASSERT_OK(vw_reliability_find(values, SEEDS, COUNT, &reliability));
    assert_near(reliability.agreement, 0.483, 0.04);
    assert_near(reliability.ceiling, sqrt(0.789), 0.02);
    ASSERT_OK(vw_reliability_find(values, 1, COUNT, &reliability));
    assert_true(isnan(reliability.agreement) && isnan(reliability.ceiling));
    free(values);
}
