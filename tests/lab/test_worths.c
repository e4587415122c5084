// Worths of photos by regression over subsets, the signs of scores, and the reliability of outcomes, on games whose
// values are known.
#include "support/cmocka_test.h"

#include "base/random.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/subset_trainings.h"
#include "value/evaluation/worth_regression.h"

enum { PHOTOS = 10, FIRST_SEED = 7 };

// Photo 9 has no worth.
static const double true_worths[PHOTOS] = {0.5, 0.3, -0.4, 0.6, 0.2, -0.7, 0.4, 0.1, 0.8, 0};
static const uint32_t photos[PHOTOS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};

static double noise_of(uint64_t seed, uint32_t key) {
    uint32_t words[4];
    vw_random_words(seed, VW_RANDOM_JITTER, 3, key, 0, words);
    double sum = -2; // sum of four uniform numbers, shifted to mean 0: variance 1/3
    for (int i = 0; i < 4; i++) sum += vw_random_unit(words[i]);
    return sum * sqrt(3);
}

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
        psnr_db += game->noise_db * noise_of(retrainings[i].seed, key);
        outcomes[i] = (struct vw_retrain_result){.val_psnr = psnr_db, .test_psnr = NAN};
    }
    return VW_OK;
}

static void play_subsets(double noise_db, uint32_t halves, uint32_t random_sizes, uint32_t seeds, uint64_t first_seed,
                         struct vw_subsets *subsets) {
    struct game game = {.noise_db = noise_db};
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, halves, random_sizes, seeds, 0}, subsets));
    ASSERT_OK(vw_subsets_retrain(subsets, photos, first_seed, play, &game));
}

static enum vw_status fit(const struct vw_subsets *subsets, enum vw_quality quality, struct vw_worths *worths) {
    return vw_worths_fit(&(struct vw_worth_params){.subsets = subsets, .quality = quality, .predict = true}, worths);
}

static void check_near(double value, double expected, double tolerance, const char *what) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%s is %.17g, not %.17g", what, value, expected);
}

TEST(an_additive_game_is_recovered) {
    struct vw_subsets subsets;
    struct vw_worths worths;
    play_subsets(0, 30, 30, 1, FIRST_SEED, &subsets);
    ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
    for (uint32_t i = 0; i < PHOTOS; i++) check_near(worths.values[i], true_worths[i], 1e-5, "a worth");
    check_near(worths.r2, 1, 1e-9, "R^2 of subsets left out");
    for (uint32_t i = 0; i < subsets.count; i++)
        check_near(worths.predicted[i], subsets.results[i].val_psnr, 1e-4, "a prediction");
    assert_int_equal(worths.count, 60);
    vw_worths_free(&worths);
    vw_subsets_free(&subsets);
}

// Every photo adds 10 dB beside its worth. Few and noisy trainings do not tell the photos apart: their worths are
// shrunk to their mean, 10.18, and not to 0.
TEST(shrinking_keeps_the_level) {
    struct game game = {.noise_db = 2, .each_db = 10};
    struct vw_subsets subsets;
    struct vw_worths worths;
    double mean = 0, spread = 0;
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 6, 6, 4, 0}, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &game));
    ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
    for (uint32_t i = 0; i < PHOTOS; i++) mean += worths.values[i] / PHOTOS;
    for (uint32_t i = 0; i < PHOTOS; i++) spread += pow(worths.values[i] - mean, 2) / PHOTOS;
    check_near(mean, 10.18, 1, "the mean of shrunk worths");
    if (sqrt(spread) > 1) fail_msg("worths are not shrunk: their standard deviation is %g", sqrt(spread));
    vw_worths_free(&worths);
    vw_subsets_free(&subsets);
}

// Intervals of 95 % contain the true worth in most cases of 20 games with 10 photos each.
TEST(intervals_hold_the_worths) {
    uint32_t held = 0, zero_known = 0;
    for (uint32_t game = 0; game < 20; game++) {
        struct vw_subsets subsets;
        struct vw_worths worths;
        play_subsets(0.6, 60, 60, 2, FIRST_SEED + 2 * game, &subsets);
        ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
        for (uint32_t i = 0; i < PHOTOS; i++)
            held += worths.ci_low[i] <= true_worths[i] && true_worths[i] <= worths.ci_high[i];
        zero_known += worths.ci_low[9] > 0 || worths.ci_high[9] < 0;
        vw_worths_free(&worths);
        vw_subsets_free(&subsets);
    }
    if (held < 176)
        fail_msg("%u of 200 intervals hold the true worth", held); // 190 expected, 3.1 as standard deviation
    if (zero_known > 4) fail_msg("%u of 20 games are sure of a photo without worth", zero_known);
}

TEST(too_few_subsets_have_no_worths) {
    struct vw_subsets subsets;
    struct vw_worths worths;
    play_subsets(0, 5, 2, 1, FIRST_SEED, &subsets);
    ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
    assert_true(isnan(worths.values[0]) && isnan(worths.ci_low[0]) && worths.count == 0);
    vw_worths_free(&worths);
    ASSERT_OK(fit(&subsets, VW_QUALITY_TEST_PSNR, &worths)); // without test photos
    assert_true(isnan(worths.values[0]) && isnan(worths.r2));
    vw_worths_free(&worths);
    vw_subsets_free(&subsets);
}

// ---- Signs ----------------------------------------------------------------------------------------------------------

static const struct vw_metric *find(const struct vw_metrics *metrics, const char *group, const char *method) {
    const struct vw_metric *row = vw_metrics_find(metrics, group, "val_psnr", method);
    if (!row) fail_msg("no row %s/val_psnr of %s", group, method);
    return row;
}

// Photos 2 and 5 harm, photo 9 is worth nothing, which its interval admits; the other seven help.
TEST(signs_are_held_against_known_worths) {
    struct vw_subsets subsets;
    struct vw_worths worths;
    struct vw_metrics metrics = {0};
    static const char *const kinds[PHOTOS] = {"clean", "clean", "noise", "clean", "clean",
                                              "noise", "clean", "clean", "clean", "clean"};
    // Finds one of the two, calls another one harmful, and also the one of no worth.
    static const double some[PHOTOS] = {1, 1, -1, 1, -1, 1, 1, 1, 1, -1}, none[PHOTOS] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    const struct vw_scorer scorers[] = {{.name = "worths", .scores = true_worths, .has_sign = true},
                                        {.name = "some", .scores = some, .has_sign = true},
                                        {.name = "none", .scores = none, .has_sign = true},
                                        {.name = "ranks", .scores = none}};
    const struct vw_evaluation evaluation = {photos, kinds, PHOTOS, scorers, 4, 1};
    play_subsets(0.02, 40, 40, 1, FIRST_SEED, &subsets);
    ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
    assert_true(worths.ci_low[9] <= 0 && worths.ci_high[9] >= 0);
    ASSERT_OK(vw_evaluate_signs(&evaluation, &worths, "val_psnr", &metrics));
    check_near(find(&metrics, "sign_accuracy", "worths")->value, 1, 0, "accuracy of the worths");
    assert_int_equal(find(&metrics, "sign_accuracy", "worths")->count, 9);
    check_near(find(&metrics, "sign_accuracy", "some")->value, 7.0 / 9, 1e-15, "accuracy of some");
    check_near(find(&metrics, "harmful_precision", "some")->value, 1.0 / 3, 1e-15, "precision of some");
    check_near(find(&metrics, "harmful_recall", "some")->value, 0.5, 1e-15, "recall of some");
    check_near(find(&metrics, "helpful_recall", "some")->value, 6.0 / 7, 1e-15, "helpful ones of some");
    assert_true(isnan(find(&metrics, "harmful_precision", "none")->value)); // it calls none harmful
    check_near(find(&metrics, "harmful_recall", "none")->value, 0, 0, "recall of none");
    assert_null(vw_metrics_find(&metrics, "sign_accuracy", "val_psnr", "ranks"));
    vw_worths_free(&worths);
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// ---- Cross-fitting --------------------------------------------------------------------------------------------------

// Outcomes that are noise alone cannot be predicted; a fit that saw what it predicts would seem to.
TEST(noise_is_not_predicted) {
    struct vw_subsets subsets;
    struct vw_worths worths;
    play_subsets(50, 16, 16, 1, FIRST_SEED, &subsets);
    ASSERT_OK(fit(&subsets, VW_QUALITY_VAL_PSNR, &worths));
    if (worths.pearson > 0.3) fail_msg("noise is predicted by r = %g", worths.pearson); // one error: 0.18
    vw_worths_free(&worths);
    vw_subsets_free(&subsets);
}

TEST(predictions_have_an_lds) {
    struct vw_subsets subsets;
    struct vw_worths worths[VW_TRUTH_COUNT];
    struct vw_metrics metrics = {0};
    static const char *const kinds[PHOTOS] = {"clean", "clean", "clean", "clean", "clean",
                                              "clean", "clean", "clean", "clean", "clean"};
    const struct vw_evaluation evaluation = {.photos = photos, .ground_truths = kinds, .photo_count = PHOTOS};
    play_subsets(0, 40, 40, 2, FIRST_SEED, &subsets);
    for (uint32_t i = 0; i < VW_TRUTH_COUNT; i++) ASSERT_OK(fit(&subsets, vw_truths[i], &worths[i]));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, worths, &metrics));
    check_near(find(&metrics, "lds", vw_subset_worth_name)->value, 1, 0.01, "LDS on halves");
    check_near(find(&metrics, "lds_sizes", vw_subset_worth_name)->value, 1, 0.01, "LDS on random sizes");
    for (uint32_t i = 0; i < VW_TRUTH_COUNT; i++) vw_worths_free(&worths[i]);
    vw_subsets_free(&subsets);
    free(metrics.rows);
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
        for (uint32_t i = 0; i < COUNT; i++) values[seed * COUNT + i] = noise_of(1, i) + noise_of(2 + seed, i);
    ASSERT_OK(vw_reliability_find(values, SEEDS, COUNT, &reliability));
    check_near(reliability.agreement, 0.483, 0.04, "the agreement");
    check_near(reliability.ceiling, sqrt(0.789), 0.02, "the ceiling");
    ASSERT_OK(vw_reliability_find(values, 1, COUNT, &reliability));
    assert_true(isnan(reliability.agreement) && isnan(reliability.ceiling));
    free(values);
}
