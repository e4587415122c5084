// The evaluation of methods on games whose values are known: additive ones, in which a photo adds what it is worth,
// with noise of a known size for every training.
#include "support/cmocka_test.h"

#include "base/random.h"
#include "lab/evaluation/evaluation.h"
#include "lab/evaluation/leave_one_out.h"
#include "lab/evaluation/subset_trainings.h"
#include "lab/scorers.h"
#include "value/evaluation/worth_regression.h"
#include "viewworth/status.h"

enum { PHOTOS = 12, SEEDS = 2, FIRST_SEED = 40 };

// Photo i is image 3 i + 1, as validation views lie between.
static const double worths[PHOTOS] = {0.9, 0.4, -1.3, 0.7, 0.3, -1.0, 0.8, 0.5, -0.7, 0.6, 0.2, -0.5};
static const char *const ground_truths[PHOTOS] = {"clean", "clean", "blur",  "clean", "clean", "blur",
                                                  "clean", "clean", "noise", "clean", "clean", "noise"};
static uint32_t photos[PHOTOS];
static double scores_of[4][SEEDS * PHOTOS]; // worths, opposite, flat, a few wrong
static const struct vw_scorer scorers[] = {{.name = "dv_psnr", .scores = scores_of[3], .has_sign = true},
                                           {.name = "worths", .scores = scores_of[0]},
                                           {.name = "opposite", .scores = scores_of[1], .has_sign = true},
                                           {.name = "flat", .scores = scores_of[2]}};
static const struct vw_evaluation evaluation = {.photos = photos,
                                                .ground_truths = ground_truths,
                                                .photo_count = PHOTOS,
                                                .scorers = scorers,
                                                .scorer_count = 4,
                                                .seed_count = SEEDS};

struct game {
    double noise_db;           // standard deviation of a training's outcome
    uint32_t retrainings, odd; // that were asked for; with other than ascending, different photos
    bool fails, lacks_tests;
};

static double noise_of(const struct vw_retrain_params *retraining) {
    uint32_t words[4], key = 0;
    for (uint32_t i = 0; i < retraining->view_count; i++) key = key * 31 + retraining->views[i];
    vw_random_words(retraining->seed, VW_RANDOM_JITTER, 7, key, 0, words);
    double sum = -2; // sum of four uniform numbers, shifted to mean 0: variance 1/3
    for (int i = 0; i < 4; i++) sum += vw_random_unit(words[i]);
    return sum * sqrt(3);
}

static enum vw_status play_one(struct game *game, const struct vw_retrain_params *retraining,
                               struct vw_retrain_result *outcome) {
    double psnr_db = 20;
    game->retrainings++;
    if (game->fails) return vw_fail(VW_ERROR_DEVICE, "the game is over");
    for (uint32_t i = 0; i < retraining->view_count; i++) {
        game->odd += (i && retraining->views[i] <= retraining->views[i - 1]) || retraining->views[i] % 3 != 1;
        psnr_db += worths[retraining->views[i] / 3];
    }
    psnr_db += game->noise_db * noise_of(retraining);
    *outcome = (struct vw_retrain_result){.val_psnr = psnr_db,
                                          .test_psnr = game->lacks_tests ? NAN : psnr_db + 1,
                                          .val_l1 = NAN,
                                          .test_l1 = NAN,
                                          .seconds = 1};
    return VW_OK;
}

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *outcomes) {
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) status = play_one(context, &retrainings[i], &outcomes[i]);
    return status;
}

static int set_up(void **state) {
    (void)state;
    for (uint32_t i = 0; i < PHOTOS; i++) photos[i] = 3 * i + 1;
    for (uint32_t i = 0; i < SEEDS * PHOTOS; i++) {
        uint32_t photo = i % PHOTOS;
        scores_of[0][i] = 2 * worths[photo] + 5; // subsets are of one size: shift and scale of scores change no order
        scores_of[1][i] = -worths[photo];
        scores_of[2][i] = 3;
        scores_of[3][i] = photo % 4 ? worths[photo] : -worths[photo];
    }
    return 0;
}

static void check_near(double value, double expected, double tolerance, const char *what) {
    if (!(fabs(value - expected) <= tolerance)) fail_msg("%s is %.17g, not %.17g", what, value, expected);
}

static const struct vw_metric *find(const struct vw_metrics *metrics, const char *group, const char *name,
                                    const char *method) {
    const struct vw_metric *row = vw_metrics_find(metrics, group, name, method);
    if (!row) fail_msg("no row %s/%s of %s", group, name, method);
    return row;
}

static void play_subsets(struct game *game, uint32_t halves, struct vw_subsets *subsets) {
    const struct vw_subsets_params params = {.photo_count = PHOTOS, .halves = halves, .seed_count = SEEDS};
    ASSERT_OK(vw_subsets_draw(&params, subsets));
    ASSERT_OK(vw_subsets_retrain(subsets, photos, FIRST_SEED, play, game));
    assert_int_equal(game->odd, 0);
}

// ---- Subsets --------------------------------------------------------------------------------------------------------

TEST_WITHIN(halves_are_different_and_balanced, set_up, NULL) {
    struct vw_subsets subsets;
    uint32_t times[PHOTOS] = {0};
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 200, 0, SEEDS, 0}, &subsets));
    assert_int_equal(subsets.count, 200);
    for (uint32_t i = 0; i < subsets.count; i++) {
        const uint32_t *places = subsets.places + subsets.offsets[i];
        assert_int_equal(vw_subset_size(&subsets, i), PHOTOS / 2);
        for (uint32_t j = 0; j < PHOTOS / 2; j++) {
            assert_true(places[j] < PHOTOS && (!j || places[j] > places[j - 1]));
            times[places[j]]++;
        }
        for (uint32_t other = 0; other < i; other++)
            assert_memory_not_equal(places, subsets.places + subsets.offsets[other], PHOTOS / 2 * sizeof *places);
    }
    // 200 draws with probability 1/2: standard deviation 7.1, of which five are allowed.
    for (uint32_t i = 0; i < PHOTOS; i++) assert_true(times[i] > 64 && times[i] < 136);
    vw_subsets_free(&subsets);
}

TEST_WITHIN(there_are_no_more_halves_than_exist, set_up, NULL) {
    struct vw_subsets subsets;
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){4, 50, 0, SEEDS, 0}, &subsets));
    assert_int_equal(subsets.count, 6); // 4 over 2
    vw_subsets_free(&subsets);
}

// 12 photos: sizes 5 to 12, each as often as the others (400 / 8 = 50, standard deviation 6.6), but that the one subset
// of all photos, the 12 of eleven and the 66 of ten are soon drawn.
TEST_WITHIN(random_sizes_are_uniform, set_up, NULL) {
    struct vw_subsets subsets;
    uint32_t of_size[PHOTOS + 1] = {0};
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 20, 250, SEEDS, 0}, &subsets));
    assert_int_equal(subsets.halves.end, 20);
    assert_true(subsets.sizes.begin == 20 && subsets.sizes.end == 270 && subsets.count == 270);
    for (uint32_t i = subsets.sizes.begin; i < subsets.sizes.end; i++) of_size[vw_subset_size(&subsets, i)]++;
    for (uint32_t size = 0; size < 5; size++) assert_int_equal(of_size[size], 0);
    for (uint32_t size = 5; size < 10; size++)
        if (of_size[size] < 20 || of_size[size] > 60) fail_msg("%u subsets of size %u", of_size[size], size);
    assert_true(of_size[11] > 5 && of_size[12] == 1);
    vw_subsets_free(&subsets);
}

TEST_WITHIN(all_subsets_are_listed_once, set_up, NULL) {
    struct vw_subsets subsets;
    bool listed[32] = {false};
    ASSERT_OK(vw_subsets_list_all(5, SEEDS, &subsets));
    assert_int_equal(subsets.count, 32);
    for (uint32_t i = 0; i < subsets.count; i++) {
        uint32_t mask = 0;
        for (uint32_t j = subsets.offsets[i]; j < subsets.offsets[i + 1]; j++) mask |= 1U << subsets.places[j];
        assert_false(listed[mask]);
        listed[mask] = true;
        uint32_t size = vw_subset_size(&subsets, i);
        assert_int_equal(i >= subsets.halves.begin && i < subsets.halves.end, size == 2);
        assert_int_equal(i >= subsets.sizes.begin && i < subsets.sizes.end, size >= 2); // 40 % of 5
    }
    vw_subsets_free(&subsets);
    assert_int_equal(vw_subsets_list_all(VW_SUBSETS_ALL_PHOTOS_MAX + 1, SEEDS, &subsets), VW_ERROR_USAGE);
    vw_subsets_free(&subsets);
}

TEST_WITHIN(a_failing_training_ends_it, set_up, NULL) {
    struct game game = {.fails = true};
    struct vw_subsets subsets;
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 20, 0, SEEDS, 0}, &subsets));
    assert_int_equal(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &game), VW_ERROR_DEVICE);
    assert_int_equal(game.retrainings, 1);
    vw_subsets_free(&subsets);
}

// ---- Detection ------------------------------------------------------------------------------------------------------

// Eight clean photos, two of either kind. By hand, for the scores of "dv_psnr": clean -0.9 (photo 0), 0.4, 0.7, -0.3
// (photo 4), 0.8, 0.5, 0.6, 0.2; blur -1.3 and -1.0 lie below all; noise +0.7 (photo 8), above all but 0.8 and level
// with 0.7, and -0.5, above -0.9 alone.
TEST_WITHIN(auc_by_hand, set_up, NULL) {
    struct vw_metrics metrics = {0};
    ASSERT_OK(vw_evaluate_detection(&evaluation, &metrics));
    check_near(find(&metrics, "auc", "blur", "dv_psnr")->value, 1, 0, "AUC of blur");
    check_near(find(&metrics, "auc", "noise", "dv_psnr")->value, (1.5 + 7) / 16, 1e-15, "AUC of noise");
    check_near(find(&metrics, "auc", "corrupted", "dv_psnr")->value, (16 + 1.5 + 7) / 32, 1e-15, "AUC of all");
    check_near(find(&metrics, "auc", "corrupted", "worths")->value, 1, 0, "AUC of the worths");
    check_near(find(&metrics, "auc", "corrupted", "opposite")->value, 0, 0, "AUC of their opposites");
    check_near(find(&metrics, "auc", "corrupted", "flat")->value, 0.5, 0, "AUC of equal scores");
    const struct vw_metric *noise = find(&metrics, "auc", "noise", "dv_psnr");
    assert_true(noise->ci_low < 0.3 && noise->ci_high > 0.8); // two noisy photos, with 0.19 and 0.88
    assert_int_equal(find(&metrics, "auc", "noise", "flat")->count, 16);
    assert_int_equal(metrics.count, 12);
    free(metrics.rows);
}

TEST_WITHIN(seeds_agree_over_all_and_within_clean, set_up, NULL) {
    struct vw_metrics metrics = {0};
    for (uint32_t i = 0; i < PHOTOS; i++)
        scores_of[0][PHOTOS + i] = (vw_photo_is_clean(&evaluation, i) ? -1 : 1) * worths[i];
    ASSERT_OK(vw_evaluate_seeds(&evaluation, &metrics));
    check_near(find(&metrics, "seed_pearson", "all", "dv_psnr")->value, 1, 1e-12, "r of equal scores");
    check_near(find(&metrics, "seed_pearson", "clean", "worths")->value, -1, 1e-12, "r within clean");
    check_near(find(&metrics, "seed_spearman", "clean", "worths")->value, -1, 1e-12, "rho within clean");
    assert_int_equal(find(&metrics, "seed_spearman", "clean", "worths")->count, 8);
    assert_true(isnan(find(&metrics, "seed_pearson", "all", "flat")->value));
    free(metrics.rows);
}

// ---- Predicting -----------------------------------------------------------------------------------------------------

TEST_WITHIN(true_worths_predict_an_additive_game, set_up, NULL) {
    struct game game = {0};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    play_subsets(&game, 200, &subsets);
    assert_int_equal(game.retrainings, 400);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    // Sums that are equal in theory may differ in their last bits, in either order: not quite 1.
    check_near(find(&metrics, "lds", "val_psnr", "worths")->value, 1, 1e-3, "LDS of the worths");
    check_near(find(&metrics, "lds", "test_psnr", "worths")->value, 1, 1e-3, "LDS of the worths on test photos");
    check_near(find(&metrics, "lds", "val_psnr", "opposite")->value, -1, 1e-3, "LDS of their opposites");
    check_near(find(&metrics, "lds", "val_psnr", "noise ceiling")->value, 1, 1e-12, "the ceiling without noise");
    assert_true(isnan(find(&metrics, "lds", "val_psnr", "flat")->value));
    // The correlation of two rankings of 12: standard deviation 1 / sqrt(11) = 0.30, and 2 of them on either side.
    const struct vw_metric *chance = find(&metrics, "lds", "val_psnr", "chance");
    check_near(chance->value, 0, 3 * 0.30 / sqrt(1000), "the mean of chance");
    assert_true(chance->ci_low < -0.45 && chance->ci_low > -0.7 && chance->ci_high > 0.45 && chance->ci_high < 0.7);
    double reference = find(&metrics, "lds", "val_psnr", "dv_psnr")->value;
    const struct vw_metric *gain = find(&metrics, "lds_gain", "val_psnr", "worths");
    assert_true(reference > 0.3 && reference < 0.95);
    check_near(gain->value, find(&metrics, "lds", "val_psnr", "worths")->value - reference, 1e-12, "the gain");
    assert_true(gain->ci_low > 0 && gain->ci_low < gain->value && gain->value < gain->ci_high);
    const struct vw_metric *none = find(&metrics, "lds_gain", "val_psnr", "dv_psnr");
    assert_true(none->value == 0 && none->ci_low == 0 && none->ci_high == 0); // paired: the same resamples
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// Variance of the sum of a random half: n/4 N/(N-1) var(worths) of 12; noise of the same size makes two trainings agree
// by 1/2, and their mean with the truth by sqrt(2/3). Spearman's correlation of normal variables is 6/pi asin(r/2):
// 0.483 for 1/2, and 0.802 for sqrt(2/3).
TEST_WITHIN(noise_lowers_the_ceiling_as_theory_says, set_up, NULL) {
    double mean = 0, variance = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) mean += worths[i] / PHOTOS;
    for (uint32_t i = 0; i < PHOTOS; i++) variance += pow(worths[i] - mean, 2) / PHOTOS;
    struct game game = {.noise_db = sqrt(variance * PHOTOS * PHOTOS / 4 / (PHOTOS - 1))};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    play_subsets(&game, 800, &subsets);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    // Standard error of a correlation of 0.5 over 800: 0.75 / sqrt(800) = 0.027, three of which are allowed here and
    // below.
    check_near(find(&metrics, "agreement_lds", "val_psnr", "outcomes")->value, 0.483, 0.08,
               "the agreement of two trainings");
    check_near(find(&metrics, "lds", "val_psnr", "noise ceiling")->value, sqrt(2 * 0.483 / 1.483), 0.05, "the ceiling");
    check_near(find(&metrics, "lds", "val_psnr", "worths")->value, 0.802, 0.05, "LDS of the worths");
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// The interval of 100 subsets holds what 800 others say, in nearly all of 20 games.
TEST_WITHIN(intervals_cover, set_up, NULL) {
    struct game game = {.noise_db = 1.5};
    struct vw_subsets many;
    struct vw_metrics ground_truth = {0};
    play_subsets(&game, 900, &many);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &many, NULL, &ground_truth));
    double expected = find(&ground_truth, "lds", "val_psnr", "dv_psnr")->value;
    uint32_t covered = 0, games = 9;
    for (uint32_t i = 0; i < games; i++) { // disjoint hundreds
        struct vw_subsets part = many;
        struct vw_metrics metrics = {0};
        part.halves = (struct vw_subset_range){i * 100, (i + 1) * 100};
        ASSERT_OK(vw_evaluate_subsets(&evaluation, &part, NULL, &metrics));
        const struct vw_metric *row = find(&metrics, "lds", "val_psnr", "dv_psnr");
        covered += row->ci_low <= expected && expected <= row->ci_high;
        assert_true(row->ci_high - row->ci_low > 0.1 &&
                    row->ci_high - row->ci_low < 0.6); // about 4 (1 - r^2) / sqrt(100)
        free(metrics.rows);
    }
    // Three or more of nine intervals of 95 % miss with probability 0.008.
    if (covered + 2 < games) fail_msg("only %u of %u intervals hold %g", covered, games, expected);
    vw_subsets_free(&many);
    free(ground_truth.rows);
}

TEST_WITHIN(trainings_without_value_are_left_out, set_up, NULL) {
    struct game game = {.lacks_tests = true};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    play_subsets(&game, 40, &subsets);
    subsets.results[SEEDS * 7 + 1].val_psnr = NAN;
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    assert_int_equal(find(&metrics, "lds", "val_psnr", "worths")->count, 39);
    assert_null(vw_metrics_find(&metrics, "lds", "test_psnr", "worths"));
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// A photo has no score if, say, its training of leave-one-out did not end in a finite value.
TEST_WITHIN(a_photo_without_score_leaves_a_method_without_metric, set_up, NULL) {
    struct game game = {0};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    struct vw_left_out left_out;
    play_subsets(&game, 40, &subsets);
    ASSERT_OK(vw_leave_one_out(&evaluation, SEEDS, FIRST_SEED, play, &game, &left_out));
    scores_of[1][3] = NAN;
    ASSERT_OK(vw_evaluate_detection(&evaluation, &metrics));
    ASSERT_OK(vw_evaluate_seeds(&evaluation, &metrics));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    assert_true(isnan(find(&metrics, "auc", "blur", "opposite")->value));
    assert_int_equal(find(&metrics, "seed_pearson", "all", "opposite")->count, PHOTOS - 1); // over the others
    const struct vw_metric *lds = find(&metrics, "lds", "val_psnr", "opposite");
    assert_true(isnan(lds->value) && isnan(lds->ci_low) && isnan(lds->ci_high));
    assert_true(isnan(find(&metrics, "leave_one_out", "val_psnr", "opposite")->value));
    assert_true(isfinite(find(&metrics, "lds", "val_psnr", "worths")->value));
    vw_left_out_free(&left_out);
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// Clean photos are worth 0.55 on average, blurred ones -1.15, noisy ones -0.6.
TEST_WITHIN(harm_is_what_a_kind_is_worth_less, set_up, NULL) {
    struct game game = {.noise_db = 0.05};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    struct vw_worths fitted;
    play_subsets(&game, 200, &subsets);
    ASSERT_OK(vw_worths_fit(
        &(struct vw_worth_params){.subsets = &subsets, .quality = VW_QUALITY_VAL_PSNR, .resample = true}, &fitted));
    ASSERT_OK(vw_evaluate_harm(&evaluation, &fitted, &metrics));
    const struct vw_metric *blur = find(&metrics, "harm", "blur", "retrainings"),
                           *noise = find(&metrics, "harm", "noise", "retrainings");
    check_near(blur->value, 1.70, 0.03,
               "harm of blur"); // a worth has a standard error of 0.05 / sqrt(200 / 4) / sqrt 2
    check_near(noise->value, 1.15, 0.03, "harm of noise");
    assert_true(blur->ci_low < blur->value && blur->value < blur->ci_high && blur->ci_low > 0 && blur->count == 2);
    ASSERT_OK(vw_evaluate_harmful(&evaluation, &metrics));
    assert_int_equal(find(&metrics, "auc", "harmful", "worths")->count, 32);
    vw_worths_free(&fitted);
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

TEST_WITHIN(only_kinds_that_do_harm_count_as_harmful, set_up, NULL) {
    struct vw_metrics metrics = {0};
    const struct vw_metric sure = {.method = "retrainings", .value = 1, .ci_low = 0.5, .ci_high = 1.5},
                           unsure = {.method = "retrainings", .value = 0.2, .ci_low = -0.1, .ci_high = 0.5};
    ASSERT_OK(vw_metrics_add(&metrics, "harm", "noise", sure));
    ASSERT_OK(vw_metrics_add(&metrics, "harm", "blur", unsure));
    ASSERT_OK(vw_evaluate_harmful(&evaluation, &metrics));
    const struct vw_metric *row = find(&metrics, "auc", "harmful", "dv_psnr");
    check_near(row->value, (1.5 + 7) / 16, 1e-15, "AUC of the harmful kind");
    assert_int_equal(row->count, 16);
    free(metrics.rows);
}

// ---- Curves ---------------------------------------------------------------------------------------------------------

static struct vw_curve_params curve_of(struct game *game) {
    return (struct vw_curve_params){&evaluation, FIRST_SEED, SEEDS, play, game, false};
}

TEST_WITHIN(curves_of_true_worths_are_best, set_up, NULL) {
    struct game game = {0};
    struct vw_metrics metrics = {0};
    const struct vw_curve_params curve = curve_of(&game);
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    for (uint32_t i = 0; i < evaluation.scorer_count; i++) ASSERT_OK(vw_evaluate_curve(&curve, &scorers[i], &metrics));
    assert_int_equal(game.odd, 0);
    // 20 % of 12 are 2: the worst, -1.3 and -1.0; the best, 0.9 and 0.8. 30 % are 4: all corrupted ones.
    check_near(find(&metrics, "removal_low", "20", "worths")->value, 2.3, 1e-12, "removing the two worst");
    check_near(find(&metrics, "removal_high", "20", "worths")->value, -1.7, 1e-12, "removing the two best");
    check_near(find(&metrics, "removal_low", "30", "worths")->value, 3.5, 1e-12, "removing the four worst");
    check_near(find(&metrics, "removal_low", "20", "opposite")->value, -1.7, 1e-12, "removing the wrong ones");
    check_near(find(&metrics, "addition_high", "10", "worths")->value, 0.9 - 0.9, 1e-12,
               "the best alone, for all of 0.9");
    check_near(find(&metrics, "addition_low", "10", "worths")->value, -1.3 - 0.9, 1e-12, "the worst alone");
    check_near(find(&metrics, "addition_high", "50", "worths")->value,
               find(&metrics, "removal_low", "50", "worths")->value, 1e-12, "half is half");
    static const char *const shares[] = {"10", "20", "30", "50"};
    for (int i = 0; i < 4; i++) {
        double best = find(&metrics, "removal_low", shares[i], "worths")->value;
        static const char *const others[] = {"dv_psnr", "opposite", "flat", "random"};
        for (int j = 0; j < 4; j++) assert_true(best >= find(&metrics, "removal_low", shares[i], others[j])->value);
    }
    assert_int_equal(find(&metrics, "removal_low", "20", "worths")->count, 2);
    assert_int_equal(find(&metrics, "removal_low", "20", "random")->count, 6);
    assert_null(vw_metrics_find(&metrics, "removal_high", "20", "random"));
    free(metrics.rows);
}

// The noise of a training is 0.1 dB, so that of a mean of differences of 30 pairs is 0.1 sqrt(2 / 30) = 0.026, and half
// an interval 2.05 times that. Random orders differ by far more.
TEST_WITHIN(curves_have_intervals_over_seeds, set_up, NULL) {
    struct game game = {.noise_db = 0.1};
    struct vw_metrics metrics = {0};
    struct vw_curve_params curve = curve_of(&game);
    curve.seed_count = 30;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    const struct vw_metric *row = find(&metrics, "removal_low", "20", "worths"),
                           *random = find(&metrics, "removal_low", "20", "random");
    check_near(row->value, 2.3, 0.08, "removing the two worst");
    check_near(row->ci_high - row->value, 2.05 * 0.026, 0.02, "half the interval");
    check_near(row->ci_high - row->value, row->value - row->ci_low, 1e-12, "the other half");
    assert_true(random->ci_high - random->value > 0.5);
    metrics.count = 0;
    curve.seed_count = 1;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_true(isnan(find(&metrics, "removal_low", "20", "worths")->ci_low)); // one seed shows no spread
    free(metrics.rows);
}

// A curve is of test photos where there are some; and asks for no more trainings than it says.
TEST_WITHIN(curves_without_tests_are_of_validation, set_up, NULL) {
    struct game game = {.lacks_tests = true};
    struct vw_metrics metrics = {0};
    const struct vw_curve_params curve = curve_of(&game);
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    check_near(find(&metrics, "removal_low", "20", "worths")->value, 2.3, 1e-12, "removing the two worst");
    assert_true(game.retrainings <= vw_curve_trainings(SEEDS, false));
    free(metrics.rows);
}

TEST_WITHIN(gains_are_one_point_of_the_curve, set_up, NULL) {
    struct game game = {0};
    struct vw_metrics metrics = {0};
    struct vw_curve_params curve = curve_of(&game);
    curve.gain_only = true;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_int_equal(metrics.count, 1);
    check_near(find(&metrics, "removal_low", "20", "worths")->value, 2.3, 1e-12, "removing the two worst");
    assert_int_equal(game.retrainings, vw_curve_trainings(SEEDS, true));
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    assert_int_equal(metrics.count, 2);
    free(metrics.rows);
}

TEST_WITHIN(scores_without_order_have_no_curve, set_up, NULL) {
    struct game game = {0};
    struct vw_metrics metrics = {0};
    scores_of[0][3] = NAN;
    const struct vw_curve_params curve = curve_of(&game);
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_int_equal(metrics.count, 0);
    assert_int_equal(game.retrainings, 0);
}

TEST_WITHIN(leave_one_out_finds_the_worths, set_up, NULL) {
    struct game game = {0};
    struct vw_metrics metrics = {0};
    struct vw_left_out left_out;
    ASSERT_OK(vw_leave_one_out(&evaluation, 3, FIRST_SEED, play, &game, &left_out));
    assert_int_equal(game.retrainings, 3 * (PHOTOS + 1));
    assert_int_equal(game.odd, 0);
    for (uint32_t i = 0; i < 3 * PHOTOS; i++) {
        check_near(left_out.worths[0][i], worths[i % PHOTOS], 1e-12, "a photo left out");
        check_near(left_out.worths[1][i], worths[i % PHOTOS], 1e-12, "a photo left out, by test photos");
    }
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    const struct vw_metric *row = find(&metrics, "leave_one_out", "val_psnr", "worths");
    check_near(row->value, 1, 1e-12, "rho of the worths");
    check_near(row->ci_low, 1, 1e-12, "which no resample changes");
    check_near(find(&metrics, "leave_one_out", "test_psnr", "opposite")->value, -1, 1e-12, "rho of their opposites");
    row = find(&metrics, "leave_one_out", "val_psnr", "dv_psnr");
    assert_true(row->ci_low < row->value && row->value < row->ci_high && row->ci_low > -1);
    check_near(find(&metrics, "leave_one_out", "val_psnr", "noise ceiling")->value, 1, 1e-12, "the ceiling");
    check_near(find(&metrics, "leave_one_out", "val_psnr", "chance")->value, 0, 0.05, "chance");
    vw_left_out_free(&left_out);
    free(metrics.rows);
}

// Two seeds whose noise is opposite: each predicts half of the truth, their mean all of it.
TEST_WITHIN(the_mean_of_seeds_predicts_more, set_up, NULL) {
    struct game game = {0};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    struct vw_left_out left_out;
    for (uint32_t i = 0; i < PHOTOS; i++) {
        double noise = i % 2 ? 1.5 : -1.5;
        scores_of[0][i] = worths[i] + noise;
        scores_of[0][PHOTOS + i] = worths[i] - noise;
    }
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 60, 60, SEEDS, 0}, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &game));
    ASSERT_OK(vw_leave_one_out(&evaluation, SEEDS, FIRST_SEED, play, &game, &left_out));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    static const char *const groups[][2] = {{"lds", "lds_mean"}, {"leave_one_out", "leave_one_out_mean"}};
    for (int i = 0; i < 2; i++) {
        check_near(find(&metrics, groups[i][1], "val_psnr", "worths")->value, 1, 1e-3, groups[i][1]);
        assert_true(find(&metrics, groups[i][0], "val_psnr", "worths")->value < 0.8);
    }
    vw_left_out_free(&left_out);
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

// Plays a game whose outcome is the mean of the members' worths, as at equal steps; only the mean form predicts over
// sizes.
static enum vw_status play_mean(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                                struct vw_retrain_result *outcomes) {
    enum vw_status status = play(context, retrainings, count, outcomes);
    for (uint32_t i = 0; i < count && !status; i++)
        outcomes[i].val_psnr = 20 + (outcomes[i].val_psnr - 20) / retrainings[i].view_count;
    return status;
}

TEST_WITHIN(sizes_are_predicted_by_means, set_up, NULL) {
    struct game game = {0};
    struct vw_subsets subsets;
    struct vw_metrics metrics = {0};
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 60, 120, SEEDS, 0}, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play_mean, &game));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    check_near(find(&metrics, "lds", "val_psnr", "worths")->value, 1, 1e-3, "LDS on halves");
    check_near(find(&metrics, "lds_sizes", "val_psnr", "worths")->value, 1, 1e-3, "LDS on random sizes");
    assert_int_equal(find(&metrics, "lds_sizes", "val_psnr", "worths")->count, 120);
    vw_subsets_free(&subsets);
    free(metrics.rows);
}

TEST(a_scorer_is_known_by_its_name) {
    assert_true(vw_scorer_exists("dv_psnr") && vw_scorer_exists("worth_24") && vw_scorer_exists("leave_one_out"));
    assert_false(vw_scorer_exists("worth_") || vw_scorer_exists("worth_2x") || vw_scorer_exists("credit"));
}
