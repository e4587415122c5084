// The evaluation of methods on games whose values are known: additive ones, in which a photo adds what it is worth,
// with noise of a known size for every training.
#include "support/metrics.h"

#include "lab/evaluation/leave_one_out.h"
#include "lab/evaluation/subset_trainings.h"
#include "lab/scorers.h"
#include "support/draws.h"
#include "value/evaluation/worth_regression.h"

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

static struct game game;
static struct vw_subsets subsets;
static struct vw_left_out left_out;

static double noise_of(const struct vw_retrain_params *retraining) {
    uint32_t key = 0;
    for (uint32_t i = 0; i < retraining->view_count; i++) key = key * 31 + retraining->views[i];
    return test_normal(retraining->seed, 7, key);
}

static enum vw_status play_one(const struct vw_retrain_params *retraining, struct vw_retrain_result *outcome) {
    double psnr_db = 20;
    game.retrainings++;
    if (game.fails) return vw_fail(VW_ERROR_DEVICE, "the game is over");
    for (uint32_t i = 0; i < retraining->view_count; i++) {
        game.odd += (i && retraining->views[i] <= retraining->views[i - 1]) || retraining->views[i] % 3 != 1;
        psnr_db += worths[retraining->views[i] / 3];
    }
    psnr_db += game.noise_db * noise_of(retraining);
    *outcome = (struct vw_retrain_result){.val_psnr = psnr_db,
                                          .test_psnr = game.lacks_tests ? NAN : psnr_db + 1,
                                          .val_l1 = NAN,
                                          .test_l1 = NAN,
                                          .seconds = 1};
    return VW_OK;
}

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *outcomes) {
    enum vw_status status = VW_OK;
    (void)context;
    for (uint32_t i = 0; i < count && !status; i++) status = play_one(&retrainings[i], &outcomes[i]);
    return status;
}

static int set_up(void **state) {
    (void)state;
    game = (struct game){0};
    subsets = (struct vw_subsets){0};
    left_out = (struct vw_left_out){0};
    metrics = (struct vw_metrics){0};
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

static int tear_down(void **state) {
    (void)state;
    vw_subsets_free(&subsets);
    vw_left_out_free(&left_out);
    free(metrics.rows);
    return 0;
}

// A test between both, which begins with nothing played and no metrics.
#define GAME_TEST(name) TEST_WITHIN(name, set_up, tear_down)

static void draw_subsets(uint32_t halves, uint32_t random_sizes) {
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, halves, random_sizes, SEEDS, 0}, &subsets));
}

static void play_subsets(uint32_t halves, uint32_t random_sizes) {
    draw_subsets(halves, random_sizes);
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &game));
    assert_int_equal(game.odd, 0);
}

// ---- Subsets --------------------------------------------------------------------------------------------------------

GAME_TEST(halves_are_different_and_balanced) {
    uint32_t times[PHOTOS] = {0};
    draw_subsets(200, 0);
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
}

GAME_TEST(there_are_no_more_halves_than_exist) {
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){4, 50, 0, SEEDS, 0}, &subsets));
    assert_int_equal(subsets.count, 6); // 4 over 2
}

// 12 photos: sizes 5 to 12, each as often as the others (400 / 8 = 50, standard deviation 6.6), but that the one subset
// of all photos, the 12 of eleven and the 66 of ten are soon drawn.
GAME_TEST(random_sizes_are_uniform) {
    uint32_t of_size[PHOTOS + 1] = {0};
    draw_subsets(20, 250);
    assert_int_equal(subsets.halves.end, 20);
    assert_true(subsets.sizes.begin == 20 && subsets.sizes.end == 270 && subsets.count == 270);
    for (uint32_t i = subsets.sizes.begin; i < subsets.sizes.end; i++) of_size[vw_subset_size(&subsets, i)]++;
    for (uint32_t size = 0; size < 5; size++) assert_int_equal(of_size[size], 0);
    for (uint32_t size = 5; size < 10; size++)
        if (of_size[size] < 20 || of_size[size] > 60) fail_msg("%u subsets of size %u", of_size[size], size);
    assert_true(of_size[11] > 5 && of_size[12] == 1);
}

GAME_TEST(all_subsets_are_listed_once) {
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
}

GAME_TEST(a_failing_training_ends_it) {
    game.fails = true;
    draw_subsets(20, 0);
    assert_int_equal(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &game), VW_ERROR_DEVICE);
    assert_int_equal(game.retrainings, 1);
}

// ---- Detection ------------------------------------------------------------------------------------------------------

// Eight clean photos, two of either kind. By hand, for the scores of "dv_psnr": clean -0.9 (photo 0), 0.4, 0.7, -0.3
// (photo 4), 0.8, 0.5, 0.6, 0.2; blur -1.3 and -1.0 lie below all; noise +0.7 (photo 8), above all but 0.8 and level
// with 0.7, and -0.5, above -0.9 alone.
GAME_TEST(auc_by_hand) {
    ASSERT_OK(vw_evaluate_detection(&evaluation, &metrics));
    assert_metric("auc", "blur", "dv_psnr", 1, 0);
    assert_metric("auc", "noise", "dv_psnr", (1.5 + 7) / 16, 1e-15);
    assert_metric("auc", "corrupted", "dv_psnr", (16 + 1.5 + 7) / 32, 1e-15);
    assert_metric("auc", "corrupted", "worths", 1, 0);
    assert_metric("auc", "corrupted", "opposite", 0, 0);
    assert_metric("auc", "corrupted", "flat", 0.5, 0);
    const struct vw_metric *noise = find_metric("auc", "noise", "dv_psnr");
    assert_true(noise->ci_low < 0.3 && noise->ci_high > 0.8); // two noisy photos, with 0.19 and 0.88
    assert_int_equal(find_metric("auc", "noise", "flat")->count, 16);
    assert_int_equal(metrics.count, 12);
}

GAME_TEST(seeds_agree_over_all_and_within_clean) {
    for (uint32_t i = 0; i < PHOTOS; i++)
        scores_of[0][PHOTOS + i] = (vw_photo_is_clean(&evaluation, i) ? -1 : 1) * worths[i];
    ASSERT_OK(vw_evaluate_seeds(&evaluation, &metrics));
    assert_metric("seed_pearson", "all", "dv_psnr", 1, 1e-12);
    assert_metric("seed_pearson", "clean", "worths", -1, 1e-12);
    assert_metric("seed_spearman", "clean", "worths", -1, 1e-12);
    assert_int_equal(find_metric("seed_spearman", "clean", "worths")->count, 8);
    assert_true(isnan(find_metric("seed_pearson", "all", "flat")->value));
}

// ---- Predicting -----------------------------------------------------------------------------------------------------

GAME_TEST(true_worths_predict_an_additive_game) {
    play_subsets(200, 0);
    assert_int_equal(game.retrainings, 400);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    // Sums that are equal in theory may differ in their last bits, in either order: not quite 1.
    assert_metric("lds", "val_psnr", "worths", 1, 1e-3);
    assert_metric("lds", "test_psnr", "worths", 1, 1e-3);
    assert_metric("lds", "val_psnr", "opposite", -1, 1e-3);
    assert_metric("lds", "val_psnr", "noise ceiling", 1, 1e-12);
    assert_true(isnan(find_metric("lds", "val_psnr", "flat")->value));
    // The correlation of two rankings of 12: standard deviation 1 / sqrt(11) = 0.30, and 2 of them on either side.
    const struct vw_metric *chance = find_metric("lds", "val_psnr", "chance");
    assert_near(chance->value, 0, 3 * 0.30 / sqrt(1000));
    assert_true(chance->ci_low < -0.45 && chance->ci_low > -0.7 && chance->ci_high > 0.45 && chance->ci_high < 0.7);
    double reference = find_metric("lds", "val_psnr", "dv_psnr")->value;
    const struct vw_metric *gain = find_metric("lds_gain", "val_psnr", "worths");
    assert_true(reference > 0.3 && reference < 0.95);
    assert_near(gain->value, find_metric("lds", "val_psnr", "worths")->value - reference, 1e-12);
    assert_true(gain->ci_low > 0 && gain->ci_low < gain->value && gain->value < gain->ci_high);
    const struct vw_metric *none = find_metric("lds_gain", "val_psnr", "dv_psnr");
    assert_true(none->value == 0 && none->ci_low == 0 && none->ci_high == 0); // paired: the same resamples
}

// Variance of the sum of a random half: n/4 N/(N-1) var(worths) of 12; noise of the same size makes two trainings agree
// by 1/2, and their mean with the truth by sqrt(2/3). Spearman's correlation of normal variables is 6/pi asin(r/2):
// 0.483 for 1/2, and 0.802 for sqrt(2/3).
GAME_TEST(noise_lowers_the_ceiling_as_theory_says) {
    double mean = 0, variance = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) mean += worths[i] / PHOTOS;
    for (uint32_t i = 0; i < PHOTOS; i++) variance += pow(worths[i] - mean, 2) / PHOTOS;
    game.noise_db = sqrt(variance * PHOTOS * PHOTOS / 4 / (PHOTOS - 1));
    play_subsets(800, 0);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    // Standard error of a correlation of 0.5 over 800: 0.75 / sqrt(800) = 0.027, three of which are allowed here and
    // below.
    assert_metric("agreement_lds", "val_psnr", "outcomes", 0.483, 0.08);
    assert_metric("lds", "val_psnr", "noise ceiling", sqrt(2 * 0.483 / 1.483), 0.05);
    assert_metric("lds", "val_psnr", "worths", 0.802, 0.05);
}

// The interval of 100 subsets holds what 800 others say, in nearly all of 20 games.
GAME_TEST(intervals_cover) {
    game.noise_db = 1.5;
    play_subsets(900, 0);
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    double expected = find_metric("lds", "val_psnr", "dv_psnr")->value;
    uint32_t covered = 0, games = 9;
    for (uint32_t i = 0; i < games; i++) { // disjoint hundreds
        struct vw_subsets part = subsets;
        part.halves = (struct vw_subset_range){i * 100, (i + 1) * 100};
        metrics.count = 0;
        ASSERT_OK(vw_evaluate_subsets(&evaluation, &part, NULL, &metrics));
        const struct vw_metric *row = find_metric("lds", "val_psnr", "dv_psnr");
        covered += row->ci_low <= expected && expected <= row->ci_high;
        assert_true(row->ci_high - row->ci_low > 0.1 &&
                    row->ci_high - row->ci_low < 0.6); // about 4 (1 - r^2) / sqrt(100)
    }
    // Three or more of nine intervals of 95 % miss with probability 0.008.
    if (covered + 2 < games) fail_msg("only %u of %u intervals hold %g", covered, games, expected);
}

GAME_TEST(trainings_without_value_are_left_out) {
    game.lacks_tests = true;
    play_subsets(40, 0);
    subsets.results[SEEDS * 7 + 1].val_psnr = NAN;
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    assert_int_equal(find_metric("lds", "val_psnr", "worths")->count, 39);
    assert_null(vw_metrics_find(&metrics, "lds", "test_psnr", "worths"));
}

// A photo has no score if, say, its training of leave-one-out did not end in a finite value.
GAME_TEST(a_photo_without_score_leaves_a_method_without_metric) {
    play_subsets(40, 0);
    ASSERT_OK(vw_leave_one_out(&evaluation, SEEDS, FIRST_SEED, play, &game, &left_out));
    scores_of[1][3] = NAN;
    ASSERT_OK(vw_evaluate_detection(&evaluation, &metrics));
    ASSERT_OK(vw_evaluate_seeds(&evaluation, &metrics));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    assert_true(isnan(find_metric("auc", "blur", "opposite")->value));
    assert_int_equal(find_metric("seed_pearson", "all", "opposite")->count, PHOTOS - 1); // over the others
    const struct vw_metric *lds = find_metric("lds", "val_psnr", "opposite");
    assert_true(isnan(lds->value) && isnan(lds->ci_low) && isnan(lds->ci_high));
    assert_true(isnan(find_metric("leave_one_out", "val_psnr", "opposite")->value));
    assert_true(isfinite(find_metric("lds", "val_psnr", "worths")->value));
}

// Clean photos are worth 0.55 on average, blurred ones -1.15, noisy ones -0.6.
GAME_TEST(harm_is_what_a_kind_is_worth_less) {
    game.noise_db = 0.05;
    AUTO(vw_worths_free) struct vw_worths fitted;
    play_subsets(200, 0);
    ASSERT_OK(vw_worths_fit(
        &(struct vw_worth_params){.subsets = &subsets, .outcome = VW_OUTCOME_VAL_PSNR, .resample = true}, &fitted));
    ASSERT_OK(vw_evaluate_harm(&evaluation, &fitted, &metrics));
    const struct vw_metric *blur = find_metric("harm", "blur", "retrainings"),
                           *noise = find_metric("harm", "noise", "retrainings");
    assert_near(blur->value, 1.70, 0.03); // a worth has a standard error of 0.05 / sqrt(200 / 4) / sqrt 2
    assert_near(noise->value, 1.15, 0.03);
    assert_true(blur->ci_low < blur->value && blur->value < blur->ci_high && blur->ci_low > 0 && blur->count == 2);
    ASSERT_OK(vw_evaluate_harmful(&evaluation, &metrics));
    assert_int_equal(find_metric("auc", "harmful", "worths")->count, 32);
}

GAME_TEST(only_kinds_that_do_harm_count_as_harmful) {
    const struct vw_metric sure = {.method = "retrainings", .value = 1, .ci_low = 0.5, .ci_high = 1.5},
                           unsure = {.method = "retrainings", .value = 0.2, .ci_low = -0.1, .ci_high = 0.5};
    ASSERT_OK(vw_metrics_add(&metrics, "harm", "noise", sure));
    ASSERT_OK(vw_metrics_add(&metrics, "harm", "blur", unsure));
    ASSERT_OK(vw_evaluate_harmful(&evaluation, &metrics));
    assert_metric("auc", "harmful", "dv_psnr", (1.5 + 7) / 16, 1e-15);
    assert_int_equal(find_metric("auc", "harmful", "dv_psnr")->count, 16);
}

// ---- Curves ---------------------------------------------------------------------------------------------------------

static struct vw_curve_params curve_of(void) {
    return (struct vw_curve_params){&evaluation, FIRST_SEED, SEEDS, play, &game, false};
}

GAME_TEST(curves_of_true_worths_are_best) {
    const struct vw_curve_params curve = curve_of();
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    for (uint32_t i = 0; i < evaluation.scorer_count; i++) ASSERT_OK(vw_evaluate_curve(&curve, &scorers[i], &metrics));
    assert_int_equal(game.odd, 0);
    // 20 % of 12 are 2: the worst, -1.3 and -1.0; the best, 0.9 and 0.8. 30 % are 4: all corrupted ones.
    assert_metric("removal_low", "20", "worths", 2.3, 1e-12);
    assert_metric("removal_high", "20", "worths", -1.7, 1e-12);
    assert_metric("removal_low", "30", "worths", 3.5, 1e-12);
    assert_metric("removal_low", "20", "opposite", -1.7, 1e-12);
    assert_metric("addition_high", "10", "worths", 0.9 - 0.9, 1e-12);
    assert_metric("addition_low", "10", "worths", -1.3 - 0.9, 1e-12);
    assert_metric("addition_high", "50", "worths", find_metric("removal_low", "50", "worths")->value, 1e-12);
    static const char *const shares[] = {"10", "20", "30", "50"};
    for (int i = 0; i < 4; i++) {
        double best = find_metric("removal_low", shares[i], "worths")->value;
        static const char *const others[] = {"dv_psnr", "opposite", "flat", "random"};
        for (int j = 0; j < 4; j++) assert_true(best >= find_metric("removal_low", shares[i], others[j])->value);
    }
    assert_int_equal(find_metric("removal_low", "20", "worths")->count, 2);
    assert_int_equal(find_metric("removal_low", "20", "random")->count, 6);
    assert_null(vw_metrics_find(&metrics, "removal_high", "20", "random"));
}

// The noise of a training is 0.1 dB, so that of a mean of differences of 30 pairs is 0.1 sqrt(2 / 30) = 0.026, and half
// an interval 2.05 times that. Random orders differ by far more.
GAME_TEST(curves_have_intervals_over_seeds) {
    game.noise_db = 0.1;
    struct vw_curve_params curve = curve_of();
    curve.seed_count = 30;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    const struct vw_metric *row = find_metric("removal_low", "20", "worths"),
                           *random = find_metric("removal_low", "20", "random");
    assert_near(row->value, 2.3, 0.08);
    assert_near(row->ci_high - row->value, 2.05 * 0.026, 0.02);
    assert_near(row->ci_high - row->value, row->value - row->ci_low, 1e-12);
    assert_true(random->ci_high - random->value > 0.5);
    metrics.count = 0;
    curve.seed_count = 1;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_true(isnan(find_metric("removal_low", "20", "worths")->ci_low)); // one seed shows no spread
}

// A curve is of test photos where there are some; and asks for no more trainings than it says.
GAME_TEST(curves_without_tests_are_of_validation) {
    game.lacks_tests = true;
    const struct vw_curve_params curve = curve_of();
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_metric("removal_low", "20", "worths", 2.3, 1e-12);
    assert_true(game.retrainings <= vw_curve_trainings(SEEDS, false));
}

GAME_TEST(gains_are_one_point_of_the_curve) {
    struct vw_curve_params curve = curve_of();
    curve.gain_only = true;
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_int_equal(metrics.count, 1);
    assert_metric("removal_low", "20", "worths", 2.3, 1e-12);
    assert_int_equal(game.retrainings, vw_curve_trainings(SEEDS, true));
    ASSERT_OK(vw_evaluate_random_curve(&curve, &metrics));
    assert_int_equal(metrics.count, 2);
}

GAME_TEST(scores_without_order_have_no_curve) {
    scores_of[0][3] = NAN;
    const struct vw_curve_params curve = curve_of();
    ASSERT_OK(vw_evaluate_curve(&curve, &scorers[1], &metrics));
    assert_int_equal(metrics.count, 0);
    assert_int_equal(game.retrainings, 0);
}

GAME_TEST(leave_one_out_finds_the_worths) {
    ASSERT_OK(vw_leave_one_out(&evaluation, 3, FIRST_SEED, play, &game, &left_out));
    assert_int_equal(game.retrainings, 3 * (PHOTOS + 1));
    assert_int_equal(game.odd, 0);
    for (uint32_t i = 0; i < 3 * PHOTOS; i++) {
        assert_near(left_out.worths[0][i], worths[i % PHOTOS], 1e-12);
        assert_near(left_out.worths[1][i], worths[i % PHOTOS], 1e-12);
    }
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    const struct vw_metric *row = find_metric("leave_one_out", "val_psnr", "worths");
    assert_near(row->value, 1, 1e-12);
    assert_near(row->ci_low, 1, 1e-12);
    assert_metric("leave_one_out", "test_psnr", "opposite", -1, 1e-12);
    row = find_metric("leave_one_out", "val_psnr", "dv_psnr");
    assert_true(row->ci_low < row->value && row->value < row->ci_high && row->ci_low > -1);
    assert_metric("leave_one_out", "val_psnr", "noise ceiling", 1, 1e-12);
    assert_metric("leave_one_out", "val_psnr", "chance", 0, 0.05);
}

// Two seeds whose noise is opposite: each predicts half of the truth, their mean all of it.
GAME_TEST(the_mean_of_seeds_predicts_more) {
    for (uint32_t i = 0; i < PHOTOS; i++) {
        double noise = i % 2 ? 1.5 : -1.5;
        scores_of[0][i] = worths[i] + noise;
        scores_of[0][PHOTOS + i] = worths[i] - noise;
    }
    play_subsets(60, 60);
    ASSERT_OK(vw_leave_one_out(&evaluation, SEEDS, FIRST_SEED, play, &game, &left_out));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    ASSERT_OK(vw_evaluate_leave_one_out(&evaluation, &left_out, &metrics));
    static const char *const groups[][2] = {{"lds", "lds_mean"}, {"leave_one_out", "leave_one_out_mean"}};
    for (int i = 0; i < 2; i++) {
        assert_metric(groups[i][1], "val_psnr", "worths", 1, 1e-3);
        assert_true(find_metric(groups[i][0], "val_psnr", "worths")->value < 0.8);
    }
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

GAME_TEST(sizes_are_predicted_by_means) {
    draw_subsets(60, 120);
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play_mean, &game));
    ASSERT_OK(vw_evaluate_subsets(&evaluation, &subsets, NULL, &metrics));
    assert_metric("lds", "val_psnr", "worths", 1, 1e-3);
    assert_metric("lds_sizes", "val_psnr", "worths", 1, 1e-3);
    assert_int_equal(find_metric("lds_sizes", "val_psnr", "worths")->count, 120);
}

TEST(a_scorer_is_known_by_its_name) {
    assert_true(vw_scorer_exists("dv_psnr") && vw_scorer_exists("worth_24") && vw_scorer_exists("leave_one_out"));
    assert_false(vw_scorer_exists("worth_") || vw_scorer_exists("worth_2x") || vw_scorer_exists("credit"));
}
