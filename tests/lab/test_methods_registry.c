// Methods that score photos by retrainings, on games whose exact values are known: every row of the registry.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "lab/evaluation/subset_trainings.h"
#include "lab/methods/registry.h"
#include "support/draws.h"

enum { PHOTOS = 6, EPOCHS = 10, FIRST_SEED = 40, MANY = 4800, SOME = 60 };

// Photo i is image 2 i + 1, as validation views lie between.
static const uint32_t photos[PHOTOS] = {1, 3, 5, 7, 9, 11};

enum kind { ADDITIVE, PAIRS, HARMFUL, NOISY, KINDS };
static const char *const kind_names[] = {"additive", "pairs", "harmful", "noisy"};
static const double worths[PHOTOS] = {0.5, 0.3, 0.9, -0.2, 0.7, 0.1};
enum { HARMFUL_PHOTO = 4 };

struct game {
    enum kind kind;
    bool alone;         // plays retrainings one by one, the last one first
    uint32_t fail_at;   // this one fails, counted from 1; 0: none
    uint32_t made, odd; // retrainings; and those with photos out of order, or with a seed that is not theirs
    uint64_t *played;   // hash of each; NULL: not kept
};

static bool has(const struct vw_retrain_params *retraining, uint32_t photo) {
    for (uint32_t i = 0; i < retraining->view_count; i++)
        if (retraining->views[i] == photos[photo]) return true;
    return false;
}

// Returns noise of standard deviation 0.2 dB, different for each training.
static double noise_of(const struct vw_retrain_params *retraining) {
    uint32_t key = retraining->epochs;
    for (uint32_t i = 0; i < retraining->view_count; i++) key = key * 31 + retraining->views[i];
    return 0.2 * test_normal(retraining->seed, 7, key);
}

// Returns a set's outcome. The untrained field has 8 dB. Each of the pairs 0 with 1 and 2 with 3 adds 1 when it is
// complete.
static double value_of(enum kind kind, const struct vw_retrain_params *retraining) {
    double psnr_db = 8;
    for (uint32_t i = 0; i < PHOTOS; i++)
        if (has(retraining, i)) psnr_db += kind == HARMFUL && i == HARMFUL_PHOTO ? -2 : worths[i];
    if (kind == PAIRS)
        psnr_db += (has(retraining, 0) && has(retraining, 1)) + (has(retraining, 2) && has(retraining, 3));
    return kind == NOISY ? psnr_db + noise_of(retraining) : psnr_db;
}

// Fills in the gains of one epoch, whose steps walk through the photos in an order that the seed draws.
static void fill_gains(enum kind kind, const struct vw_retrain_params *retraining) {
    uint32_t order[PHOTOS], taken[PHOTOS], count = 0;
    struct vw_retrain_params before = {.views = taken, .seed = retraining->seed};
    vw_random_order(retraining->seed, 3, PHOTOS, order);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        double psnr_db = value_of(kind, &before);
        taken[count++] = photos[order[i]];
        before.view_count = count;
        retraining->photos[order[i]].psnr_db = value_of(kind, &before) - psnr_db;
    }
}

// Fills in the PSNR of photos that were left out: each is shown as well as it fits the others.
static void fill_photos(enum kind kind, const struct vw_retrain_params *retraining) {
    if (retraining->photos_of == VW_RETRAIN_PHOTOS_GAINS) {
        assert_int_equal(retraining->photo_count, PHOTOS);
        fill_gains(kind, retraining);
        return;
    }
    for (uint32_t i = 0; i < retraining->photo_count; i++) {
        uint32_t photo = retraining->photos[i].image_id / 2;
        double worth = kind == HARMFUL && photo == HARMFUL_PHOTO ? -2 : worths[photo];
        assert_false(has(retraining, photo));
        retraining->photos[i].psnr_db = value_of(kind, retraining) + 3 * worth;
    }
}

static uint64_t hash_of(const struct vw_retrain_params *retraining) {
    uint64_t hash = retraining->seed * 1000003 + retraining->epochs;
    for (uint32_t i = 0; i < PHOTOS; i++) hash = hash * 2 + has(retraining, i);
    return hash;
}

static enum vw_status play_one(struct game *game, const struct vw_retrain_params *retraining,
                               struct vw_retrain_result *result) {
    if (++game->made == game->fail_at) return vw_fail(VW_ERROR_DEVICE, "the game is over");
    for (uint32_t i = 1; i < retraining->view_count; i++) game->odd += retraining->views[i] <= retraining->views[i - 1];
    game->odd += retraining->seed < FIRST_SEED || retraining->seed >= FIRST_SEED + (uint64_t)MANY * EPOCHS;
    if (game->played) game->played[game->made - 1] = hash_of(retraining);
    double psnr_db = value_of(game->kind, retraining);
    *result = (struct vw_retrain_result){.val_psnr = psnr_db, .test_psnr = NAN, .seconds = 0.5};
    if (retraining->photo_count) fill_photos(game->kind, retraining);
    return VW_OK;
}

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *results) {
    struct game *game = context;
    enum vw_status status = VW_OK;
    for (uint32_t i = 0; i < count && !status; i++) {
        uint32_t next = game->alone ? count - 1 - i : i;
        status = play_one(game, &retrainings[next], &results[next]);
    }
    return status;
}

static struct vw_retraining_input input_of(struct game *game, uint32_t budget) {
    return (struct vw_retraining_input){.photos = photos,
                                        .photo_count = PHOTOS,
                                        .retrain = play,
                                        .context = game,
                                        .first_seed = FIRST_SEED,
                                        .key = 5,
                                        .budget = budget,
                                        .epochs = EPOCHS};
}

static struct vw_retraining_cost score(const struct vw_retraining_method *method, struct game *game, uint32_t budget,
                                       double *scores) {
    const struct vw_retraining_input input = input_of(game, budget);
    struct vw_retraining_cost cost = {0};
    ASSERT_OK(vw_retraining_method_score(method, &input, scores, &cost));
    assert_int_equal(game->odd, 0);
    return cost;
}

// Finds the exact values as means over seeds, which differ only in a noisy game.
static void find_exact(enum kind kind, enum vw_exact_value value, double *values) {
    enum { SEEDS = 50 };
    struct game game = {.kind = kind};
    struct vw_subsets subsets;
    struct vw_exact_values exact;
    ASSERT_OK(vw_subsets_list_all(PHOTOS, SEEDS, &subsets));
    ASSERT_OK(vw_subsets_retrain(&subsets, photos, FIRST_SEED + 500, play, &game));
    ASSERT_OK(vw_exact_values_find(&subsets, &exact));
    vw_mean_of_rows(exact.values[0][value], SEEDS, PHOTOS, values);
    vw_exact_values_free(&exact);
    vw_subsets_free(&subsets);
}

// ---- What they estimate ---------------------------------------------------------------------------------------------

// Returns the bound of the error: five standard errors. Shapley: an order's change varies by 0.5 dB where photos help
// in pairs, of 100 orders at least, and by noise of 0.28 dB. Banzhaf: an outcome varies by 1 dB in 4,800 sets.
// Leave-one-out: noise of 0.28 dB in 685 seeds. The exact values of noisy games vary by less.
static double bound_of(enum kind kind, enum vw_exact_value value) {
    if (value == VW_EXACT_SHAPLEY) return kind == PAIRS ? 0.25 : kind == NOISY ? 0.15 : 1e-9;
    if (value == VW_EXACT_BANZHAF) return 5 * 2 / sqrt(MANY);
    return kind == NOISY ? 5 * 0.28 / sqrt(685) + 0.05 : 1e-9;
}

static void check_exact(const struct vw_retraining_method *method, enum kind kind) {
    struct game game = {.kind = kind};
    double scores[PHOTOS], exact[PHOTOS], bound = bound_of(kind, method->estimates);
    score(method, &game, MANY, scores);
    find_exact(kind, method->estimates, exact);
    for (uint32_t i = 0; i < PHOTOS; i++)
        if (!(fabs(scores[i] - exact[i]) <= bound))
            fail_msg("%s of photo %u of the %s game is %g, not %g (%g)", method->name, i, kind_names[kind], scores[i],
                     exact[i], bound);
}

TEST(methods_tend_to_what_they_estimate) {
    uint32_t checked = 0;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++)
        for (enum kind kind = 0; kind < KINDS && vw_retraining_methods[m]->estimates < VW_EXACT_COUNT; kind++) {
            check_exact(vw_retraining_methods[m], kind);
            checked++;
        }
    assert_true(checked >= 3 * KINDS);
}

// A bag without photo i has another photo with probability 1 - (4/5)^6, since each of 6 draws is one of 5 others.
// Outcomes vary by 0.5 dB in the third of 4,800 bags that leaves a photo out; the bound is five standard errors.
TEST(data_oob_by_hand) {
    struct game game = {.kind = ADDITIVE};
    double scores[PHOTOS], share = 1 - pow(0.8, 6), all = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) all += worths[i];
    score(&vw_data_oob, &game, MANY, scores);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        double expected = 8 + share * (all - worths[i]) + 3 * worths[i];
        if (!(fabs(scores[i] - expected) < 5 * 0.5 / sqrt(MANY / 3)))
            fail_msg("photo %u has %g, not %g", i, scores[i], expected);
    }
}

// Two bags leave out few photos. The others have the mean of these.
TEST(data_oob_puts_unknown_photos_in_the_middle) {
    struct game game = {.kind = ADDITIVE};
    double scores[PHOTOS], lowest = 1e9, highest = 0;
    uint32_t middle = 0;
    score(&vw_data_oob, &game, 2, scores);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        lowest = fmin(lowest, scores[i]);
        highest = fmax(highest, scores[i]);
    }
    for (uint32_t i = 0; i < PHOTOS; i++)
        for (uint32_t j = 0; j < i; j++) middle += scores[i] == scores[j] && lowest < scores[i] && scores[i] < highest;
    assert_true(middle > 0);
}

// The game's epochs walk through random orders, as those of TMC Data Shapley do.
TEST(g_shapley_averages_gains) {
    struct game game = {.kind = PAIRS};
    double scores[PHOTOS], exact[PHOTOS];
    score(&vw_g_shapley, &game, MANY / EPOCHS, scores);
    find_exact(PAIRS, VW_EXACT_SHAPLEY, exact);
    for (uint32_t i = 0; i < PHOTOS; i++) // 0.5 dB in 4,800 epochs, five standard errors
        if (!(fabs(scores[i] - exact[i]) < 5 * 0.5 / sqrt(MANY)))
            fail_msg("photo %u has %g, not %g", i, scores[i], exact[i]);
}

// Also those that estimate no such value.
TEST_CASES(methods_order_photos_by_their_worths, m, vw_retraining_method_count) {
    const struct vw_retraining_method *method = vw_retraining_methods[m];
    struct game game = {.kind = ADDITIVE};
    double scores[PHOTOS], correlation;
    score(method, &game, SOME, scores);
    ASSERT_OK(vw_spearman(scores, worths, PHOTOS, &correlation));
    if (!(correlation > 0.8)) fail_msg("%s agrees with the worths by %g", method->name, correlation);
}

TEST_CASES(methods_find_the_harmful_photo, m, vw_retraining_method_count) {
    const struct vw_retraining_method *method = vw_retraining_methods[m];
    struct game game = {.kind = HARMFUL};
    double scores[PHOTOS];
    score(method, &game, SOME, scores);
    for (uint32_t i = 0; i < PHOTOS; i++)
        if (i != HARMFUL_PHOTO && !(scores[i] > scores[HARMFUL_PHOTO]))
            fail_msg("%s: photo %u has %g, the harmful one %g", method->name, i, scores[i], scores[HARMFUL_PHOTO]);
    assert_true(!method->has_sign || scores[HARMFUL_PHOTO] < 0);
}

// ---- Budgets --------------------------------------------------------------------------------------------------------

static bool was_played(const struct game *game, uint64_t hash) {
    for (uint32_t i = 0; i < game->made; i++)
        if (game->played[i] == hash) return true;
    return false;
}

TEST(costs_stay_within_budgets_and_are_used) {
    for (uint32_t m = 0; m < vw_retraining_method_count; m++)
        for (uint32_t budget = 1; budget < 30; budget++) {
            const struct vw_retraining_method *method = vw_retraining_methods[m];
            struct game game = {.kind = NOISY};
            const struct vw_retraining_input input = input_of(&game, budget);
            struct vw_retraining_cost cost = {0};
            double scores[PHOTOS];
            enum vw_status status = vw_retraining_method_score(method, &input, scores, &cost);
            assert_int_equal(status, budget < method->least_budget(&input) ? VW_ERROR_USAGE : VW_OK);
            if (status) continue;
            assert_int_equal(cost.retrainings, game.made);
            assert_true(fabs(cost.seconds - 0.5 * game.made) < 1e-9);
            // Leave-one-out leaves a rest that does not pay for a whole seed, DVRL one that does not pay for a whole
            // step.
            if (!(cost.run_equivalents <= budget) || !(cost.run_equivalents > (double)budget - PHOTOS - 1))
                fail_msg("%s costs %g of %u", method->name, cost.run_equivalents, budget);
            for (uint32_t i = 0; i < PHOTOS; i++) assert_true(isfinite(scores[i]));
        }
}

TEST_CASES(a_larger_budget_has_the_retrainings_of_a_smaller_one, m, vw_retraining_method_count) {
    const struct vw_retraining_method *method = vw_retraining_methods[m];
    struct game few = {.kind = NOISY}, many = {.kind = NOISY};
    double scores[PHOTOS];
    few.played = test_allocate(40 * EPOCHS, sizeof *few.played);
    many.played = test_allocate(40 * EPOCHS, sizeof *many.played);
    score(method, &few, 10, scores);
    score(method, &many, 30, scores);
    assert_true(many.made > few.made);
    for (uint32_t i = 0; i < few.made; i++)
        if (!was_played(&many, few.played[i])) fail_msg("%s: retraining %u is not nested", method->name, i);
}

// A short training costs its share, one on half of the photos at equal epochs a half, the untrained field nothing.
TEST(costs_are_in_whole_trainings) {
    struct game game = {.kind = ADDITIVE};
    struct vw_retraining_input input = input_of(&game, 12);
    struct vw_retraining_cost cost;
    double scores[PHOTOS];
    ASSERT_OK(vw_retraining_method_score(&vw_tmc_shapley, &input, scores, &cost)); // two orders
    assert_true(cost.run_equivalents == 12 && cost.retrainings == 14);
    ASSERT_OK(vw_retraining_method_score(&vw_g_shapley, &input, scores, &cost));
    assert_true(fabs(cost.run_equivalents - 12) < 1e-9 && cost.retrainings == 12 * EPOCHS);
    input.equal = VW_EQUAL_EPOCHS;
    ASSERT_OK(vw_retraining_method_score(&vw_tmc_shapley, &input, scores, &cost));
    assert_true(fabs(cost.run_equivalents - 2 * 21.0 / 6) < 1e-9); // sets of sizes 1 to 6
}

// ---- How they ask ---------------------------------------------------------------------------------------------------

TEST_CASES(scores_do_not_depend_on_what_is_made_together, m, vw_retraining_method_count) {
    struct game together = {.kind = NOISY}, alone = {.kind = NOISY, .alone = true};
    double a[PHOTOS], b[PHOTOS];
    score(vw_retraining_methods[m], &together, SOME, a);
    score(vw_retraining_methods[m], &alone, SOME, b);
    assert_memory_equal(a, b, sizeof a);
}

TEST_CASES(a_failing_retraining_ends_a_method, m, vw_retraining_method_count) {
    struct game whole = {.kind = NOISY};
    double scores[PHOTOS];
    struct vw_retraining_cost cost;
    score(vw_retraining_methods[m], &whole, 20, scores);
    for (uint32_t at = 1; at <= whole.made; at += 7) {
        struct game game = {.kind = NOISY, .fail_at = at};
        const struct vw_retraining_input input = input_of(&game, 20);
        assert_int_equal(vw_retraining_method_score(vw_retraining_methods[m], &input, scores, &cost), VW_ERROR_DEVICE);
        assert_int_equal(game.made, at);
    }
}

TEST(names_are_of_methods_and_budgets) {
    assert_true(vw_is_method_and_budget("tmc_shapley_40") && vw_is_method_and_budget("dvrl_1") &&
                vw_is_method_and_budget("tmc_shapley_4N"));
    assert_false(vw_is_method_and_budget("tmc_shapley") || vw_is_method_and_budget("tmc_shapley_") ||
                 vw_is_method_and_budget("tmc_shapley_4x") || vw_is_method_and_budget("shapley_4"));
    const char *listed = VW_RETRAINING_METHODS;
    for (uint32_t m = 0; m < vw_retraining_method_count; m++) {
        const struct vw_retraining_method *method = vw_retraining_methods[m];
        assert_int_equal(strncmp(listed, method->name, strlen(method->name)), 0);
        listed += strlen(method->name) + (m + 1 < vw_retraining_method_count ? strlen(", ") : 0);
        assert_true(strlen(method->name) <= 16 && method->meaning[0]);
    }
    assert_string_equal(listed, "");
}
