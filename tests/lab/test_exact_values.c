// Exact values of games whose Shapley and Banzhaf values are known: additive, majority and glove games.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "lab/evaluation/exact_values.h"
#include "lab/evaluation/subset_trainings.h"

enum { SEEDS = 2, FIRST_SEED = 3, PHOTOS_MAX = 5 };

static const uint32_t photos[PHOTOS_MAX] = {0, 1, 2, 3, 4};
static const double additive_worths[PHOTOS_MAX] = {0.5, -0.25, 0, 1, 0.125};

typedef double game(const struct vw_retrain_params *retraining);

static bool has(const struct vw_retrain_params *retraining, uint32_t photo) {
    for (uint32_t i = 0; i < retraining->view_count; i++)
        if (retraining->views[i] == photo) return true;
    return false;
}

// Adds the photos' worths to the 8 dB of the untrained field.
static double additive(const struct vw_retrain_params *retraining) {
    double psnr_db = 8;
    for (uint32_t i = 0; i < retraining->view_count; i++) psnr_db += additive_worths[retraining->views[i]];
    return psnr_db;
}

static double majority(const struct vw_retrain_params *retraining) { return retraining->view_count >= 3; }

// Returns 1 for a pair of gloves: photos 0 and 1 are left ones, photo 2 is the right one.
static double glove(const struct vw_retrain_params *retraining) {
    return has(retraining, 2) && (has(retraining, 0) || has(retraining, 1));
}

// Plays the game. The second seed adds 1 to all values; test photos give twice as much as validation photos.
static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *outcomes) {
    game *const *played = context;
    for (uint32_t i = 0; i < count; i++) {
        double value = (*played)(&retrainings[i]) + (double)(retrainings[i].seed - FIRST_SEED);
        outcomes[i] = (struct vw_retrain_result){.val_psnr = value, .test_psnr = 2 * value};
    }
    return VW_OK;
}

static void find_values(game *played, uint32_t photo_count, struct vw_exact_values *exact) {
    struct vw_subsets subsets;
    ASSERT_OK(vw_subsets_list_all(photo_count, SEEDS, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED, play, &played));
    ASSERT_OK(vw_exact_values_find(&subsets, exact));
    vw_subsets_free(&subsets);
}

static void check_values(const struct vw_exact_values *exact, enum vw_exact_value kind, const double *expected) {
    for (uint32_t seed = 0; seed < SEEDS; seed++)
        for (uint32_t i = 0; i < exact->photo_count; i++) {
            uint32_t place = seed * exact->photo_count + i;
            double by_val = exact->values[0][kind][place], by_test = exact->values[1][kind][place];
            if (!(fabs(by_val - expected[i]) < 1e-12) || !(fabs(by_test - 2 * expected[i]) < 1e-12))
                fail_msg("%s of photo %u: %g and %g, not %g and twice that", vw_exact_value_name(kind), i, by_val,
                         by_test, expected[i]);
        }
}

TEST(an_additive_game_has_its_worths) {
    struct vw_exact_values exact;
    find_values(additive, 5, &exact);
    for (int i = 0; i < VW_EXACT_COUNT; i++) check_values(&exact, (enum vw_exact_value)i, additive_worths);
    vw_exact_values_free(&exact);
}

static const struct {
    game *played;
    uint32_t photo_count;
    double shapley[PHOTOS_MAX], banzhaf[PHOTOS_MAX], left_out[PHOTOS_MAX];
} games[] = {
    // Three of five: a photo decides as the third of five in a row, or beside 6 of the 16 subsets of the others.
    {majority, 5, {0.2, 0.2, 0.2, 0.2, 0.2}, {0.375, 0.375, 0.375, 0.375, 0.375}, {0}},
    {glove, 3, {1.0 / 6, 1.0 / 6, 4.0 / 6}, {0.25, 0.25, 0.75}, {0, 0, 1}},
};

TEST_CASES(games_have_their_known_values, i, VW_ARRAY_COUNT(games)) {
    AUTO(vw_exact_values_free) struct vw_exact_values exact;
    find_values(games[i].played, games[i].photo_count, &exact);
    check_values(&exact, VW_EXACT_SHAPLEY, games[i].shapley);
    check_values(&exact, VW_EXACT_BANZHAF, games[i].banzhaf);
    check_values(&exact, VW_EXACT_LEAVE_ONE_OUT, games[i].left_out);
}

TEST(scores_are_held_against_exact_values) {
    struct vw_exact_values exact;
    struct vw_metrics metrics = {0};
    static const char *const kinds[] = {"clean", "noise", "clean", "clean", "clean"};
    static const double cubes[] = {0.125, -0.015625, 0, 1, 0.001953125}, opposite[] = {-0.5, 0.25, 0, -1, -0.125};
    const struct vw_scorer scorers[] = {{.name = "cubes", .scores = cubes}, {.name = "opposite", .scores = opposite}};
    const struct vw_evaluation evaluation = {photos, kinds, 5, scorers, 2, 1};
    find_values(additive, 5, &exact);
    ASSERT_OK(vw_evaluate_exact_values(&evaluation, &exact, &metrics));
    static const char *const groups[] = {"exact_shapley", "exact_banzhaf", "exact_leave_one_out"};
    for (int i = 0; i < 3; i++) {
        assert_true(fabs(vw_metrics_find(&metrics, groups[i], "val_psnr", "cubes")->value - 1) < 1e-12);
        assert_true(fabs(vw_metrics_find(&metrics, groups[i], "test_psnr", "opposite")->value + 1) < 1e-12);
        assert_true(fabs(vw_metrics_find(&metrics, groups[i], "val_psnr", "noise ceiling")->value - 1) < 1e-12);
        assert_non_null(vw_metrics_find(&metrics, groups[i], "test_psnr", "chance"));
    }
    double pearson = vw_metrics_find(&metrics, "exact_shapley_pearson", "val_psnr", "cubes")->value;
    assert_true(pearson > 0.8 && pearson < 0.99); // not of ranks
    vw_exact_values_free(&exact);
    free(metrics.rows);
}
