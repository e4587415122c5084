// Every method on games whose values are known, and against a plain recomputation.
#include "support/value_game.h"

#include "lab/methods/paper_methods.h"

static const uint64_t seed = 5;
enum { EPOCHS = 13, BURN_IN = 1, VALUED = EPOCHS - BURN_IN, ALL = (1 << TEST_TRAIN_COUNT) - 1 };

static struct vw_ledger_score *score(const struct test_game *game, double beta1, uint32_t *count) {
    struct vw_value_input input = test_input_of(game, BURN_IN, beta1);
    struct vw_ledger_score *scores = NULL;
    input.further = vw_paper_methods, input.further_count = vw_paper_method_count;
    ASSERT_OK(vw_value_score(&input, &scores, count));
    return scores;
}

static double value_of(const struct vw_ledger_score *scores, uint32_t count, const char *method, uint32_t photo) {
    return test_find_score(scores, count, method, test_train_views[photo])->value;
}

// Checks a sum of some dozen numbers near 20, which is right to 1e-13.
static void check_near(double value, double expected, const char *what) {
    if (!(fabs(value - expected) <= 1e-11))
        fail_msg("%s is %.17g, not %.17g (seed %u)", what, value, expected, (unsigned)seed);
}

// ---- Games whose values are known -----------------------------------------------------------------------------------

static double played_value(test_rule *rule, uint32_t subset, uint64_t with_seed) {
    AUTO_FREE struct test_game *game = test_play_subset(rule, subset, VALUED, with_seed);
    return game->records[game->count - 1].val_psnr - 12;
}

static double leave_one_out(test_rule *rule, uint32_t photo, uint64_t with_seed) {
    return played_value(rule, ALL, with_seed) - played_value(rule, ALL & ~(1u << photo), with_seed);
}

// Returns the mean over all orders of joining of what the photo adds to those before it: subsets of s others weigh s!
// (n - 1 - s)! / n!.
static double shapley(test_rule *rule, uint32_t photo, uint64_t with_seed) {
    static const double factorial[] = {1, 1, 2, 6, 24, 120};
    double value = 0;
    for (uint32_t subset = 0; subset <= ALL; subset++) {
        if (subset >> photo & 1) continue;
        int others = __builtin_popcount(subset);
        value += factorial[others] * factorial[TEST_TRAIN_COUNT - 1 - others] / factorial[TEST_TRAIN_COUNT] *
                 (played_value(rule, subset | 1u << photo, with_seed) - played_value(rule, subset, with_seed));
    }
    return value;
}

// In a game where no photo changes another's worth, leaving one out, Shapley's value and every method that sums agree:
// visits * worth.
TEST(additive_worths_come_back) {
    AUTO_FREE struct test_game *game = test_play(test_additive, EPOCHS, seed);
    uint32_t count = 0;
    AUTO_FREE struct vw_ledger_score *scores = score(game, 0, &count);
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
        double worth = test_worth_db[photo], whole = VALUED * worth;
        check_near(leave_one_out(test_additive, photo, seed), whole, "leave-one-out");
        check_near(shapley(test_additive, photo, seed), whole, "Shapley's value");
        const struct {
            const char *method;
            double expected;
        } cases[] = {
            {"dv_psnr", whole},          {"dv_loss", whole / 100},   {"linear_psnr", whole},
            {"exponential_psnr", whole}, {"last_epoch_psnr", worth},
        };
        for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++)
            check_near(value_of(scores, count, cases[i].method, photo), cases[i].expected, cases[i].method);
    }
}

// Plays two photos that show the same: the first of them in an epoch brings all that either has, the other nothing.
static double duplicates(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)with_seed;
    if (order[step] > 1) return 0.1;
    for (uint32_t earlier = first; earlier < step; earlier++)
        if (order[earlier] == 1 - order[step]) return 0;
    return 0.5;
}

TEST(duplicates_share_their_worth) {
    double pair[2] = {0};
    enum { SEEDS = 40 };
    for (uint64_t with_seed = 0; with_seed < SEEDS; with_seed++) {
        AUTO_FREE struct test_game *game = test_play(duplicates, EPOCHS, with_seed);
        uint32_t count = 0;
        AUTO_FREE struct vw_ledger_score *scores = score(game, 0, &count);
        double first = value_of(scores, count, "dv_psnr", 0), second = value_of(scores, count, "dv_psnr", 1);
        check_near(first + second, 0.5 * VALUED, "what a pair shares");
        pair[0] += first / SEEDS;
        pair[1] += second / SEEDS;
    }
    // Half each but for the luck of the draw: 480 coins of 0.5 dB, summed per run, spread the mean by 0.137 dB; within
    // four of that.
    assert_true(fabs(pair[0] - 0.25 * VALUED) < 0.55);
    for (uint32_t photo = 0; photo < 2;
         photo++) { // so that the sums tell Shapley's value, not what is lost without the photo
        check_near(shapley(duplicates, photo, seed), 0.25 * VALUED, "Shapley's value");
        check_near(leave_one_out(duplicates, photo, seed), 0, "leave-one-out");
    }
}

// ---- Against a plain recomputation ----------------------------------------------------------------------------------

static double noisy(const uint32_t *order, uint32_t first, uint32_t step, uint64_t with_seed) {
    (void)first;
    double noise = test_noise(with_seed, step);
    return (test_worth_db[order[step]] + 0.6 * noise) * (step % 7 == 0 ? 8 : 1) /
           (1 + 0.01 * step); // some outsized, all fading
}

// The deltas of a measure by valued epoch and photo, from the records; NaN where there is none.
struct grid {
    double d[VALUED][TEST_TRAIN_COUNT];
};
static const double beta1 = 0.9;

static double read_measure(const struct vw_step_record *record, bool loss) {
    return loss ? -record->val_l1 : record->val_psnr;
}

// Returns the credit with which Adam's kernel makes `delta` of it and the credits before.
static double solve_for_credit(double delta, const double *credits, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) delta -= (1 - beta1) * pow(beta1, count - i) * credits[i];
    return delta / (1 - beta1);
}

static struct grid grid_of(const struct test_game *game, bool loss, const char *method) {
    struct grid grid;
    double own[TEST_TRAIN_COUNT], shared = read_measure(&game->records[0], loss), credits[TEST_RECORDS_MOST];
    uint32_t taken = 0;
    bool revisit = strcmp(method, "revisit") == 0, momentum = strcmp(method, "momentum") == 0;
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) own[i] = NAN;
    for (uint32_t step = 1; step < game->count; step++) {
        const struct vw_step_record *record = &game->records[step];
        uint32_t photo = game->order[step];
        double measure = read_measure(record, loss), delta = measure - (revisit ? own[photo] : shared);
        if (momentum && !isnan(delta)) {
            credits[taken] = solve_for_credit(delta, credits, taken);
            delta = credits[taken++];
        }
        if (record->epoch >= BURN_IN) grid.d[record->epoch - BURN_IN][photo] = delta;
        if (!isnan(measure)) own[photo] = shared = measure;
    }
    return grid;
}

// Returns what an epoch adds to the score of a method, whose name is given without _psnr and _loss.
static double contribution(const char *method, const double *epoch, uint32_t photo, double e) {
    const double d = epoch[photo], count = VALUED;
    if (strcmp(method, "dv") == 0) return d;
    if (strcmp(method, "revisit") == 0 || strcmp(method, "momentum") == 0) return d; // the grid is of their form
    if (strcmp(method, "last_epoch") == 0) return e == count ? d : NAN;
    if (strcmp(method, "linear") == 0) return 2 * e / (count + 1) * d;
    if (strcmp(method, "exponential") == 0) { // a geometric series
        double ratio = exp(3 / count), mean = ratio * (pow(ratio, count) - 1) / (ratio - 1) / count;
        return pow(ratio, e) / mean * d;
    }
    fail_msg("no formula here for %s", method);
    return NAN;
}

static void check_score(const struct test_game *game, const struct vw_ledger_score *score) {
    const char *end = strrchr(score->method, '_');
    AUTO_FREE char *method = vw_format_text("%.*s", (int)(end - score->method), score->method);
    uint32_t photo = 0, visits = 0;
    while (test_train_views[photo] != score->image_id) photo++;
    const struct grid grid = grid_of(game, strcmp(end, "_loss") == 0, method);
    double sum = 0;
    for (uint32_t e = 0; e < VALUED; e++) {
        double part = contribution(method, grid.d[e], photo, e + 1);
        if (isnan(part)) continue;
        sum += part;
        visits++;
    }
    check_near(score->value, sum, score->method);
    assert_int_equal(score->visits, visits);
}

// Tells the scores that test_quality tests.
static bool is_of_quality(const struct vw_ledger_score *score) {
    return strcmp(score->method, "quality") == 0 || strcmp(score->method, "train_fit") == 0;
}

TEST(methods_follow_their_formulas) {
    for (uint64_t with_seed = 0; with_seed < 6; with_seed++) {
        AUTO_FREE struct test_game *game = test_play(noisy, EPOCHS, with_seed);
        for (uint32_t step = 17; step < 23 + with_seed; step++) test_flag(game, step); // one epoch keeps a photo or two
        uint32_t count = 0;
        bool momentum = with_seed % 2;
        AUTO_FREE struct vw_ledger_score *scores = score(game, momentum ? beta1 : 0, &count);
        for (uint32_t i = 0; i < count; i++)
            if (!is_of_quality(&scores[i])) check_score(game, &scores[i]);
        assert_int_equal(count, (momentum ? 10 : 9) * TEST_TRAIN_COUNT);
    }
}

// ---- The table and the edges ----------------------------------------------------------------------------------------

TEST(the_list_is_in_the_order_of_scores) {
    AUTO_FREE struct test_game *game = test_play(noisy, EPOCHS, seed);
    uint32_t count = 0, listed;
    const struct vw_value_method *methods = vw_value_methods(&listed);
    struct vw_value_input input = test_input_of(game, BURN_IN, 0.9);
    AUTO_FREE struct vw_lasting_step *pass = vw_allocate(input.record_count, sizeof *pass);
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    input.lasting = (struct vw_lasting_pass){.steps = pass, .step_count = input.record_count - 1};
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    bool has_default = false;
    assert_string_equal(methods[--listed].name, "worth_psnr"); // the game has no retrainings
    for (uint32_t i = 0; i < listed; i++) {
        assert_string_equal(scores[i * TEST_TRAIN_COUNT].method, methods[i].name);
        assert_string_equal(scores[i * TEST_TRAIN_COUNT].unit, methods[i].unit);
        assert_true(strlen(methods[i].formula) > 0);
        has_default = has_default || strcmp(methods[i].name, vw_value_default_method) == 0;
        for (uint32_t j = 0; j < i; j++) assert_string_not_equal(methods[i].name, methods[j].name);
    }
    assert_true(has_default);
}

TEST(a_single_epoch_has_scores_without_errors) {
    AUTO_FREE struct test_game *game = test_play(noisy, 1, seed);
    struct vw_value_input input = test_input_of(game, 0, 0);
    struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    input.further = vw_paper_methods, input.further_count = vw_paper_method_count;
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    for (uint32_t i = 0; i < count; i++) {
        assert_true(isfinite(scores[i].value) && isnan(scores[i].standard_error));
        assert_int_equal(scores[i].visits, strcmp(scores[i].method, "train_fit") != 0); // the game has no losses
        assert_true(strncmp(scores[i].method, "revisit", 7) != 0);                      // nothing to start from
    }
    for (uint32_t photo = 0; photo < TEST_TRAIN_COUNT; photo++) {
        double whole = value_of(scores, count, "dv_psnr", photo);
        assert_true(value_of(scores, count, "last_epoch_psnr", photo) == whole);
        check_near(value_of(scores, count, "exponential_psnr", photo), whole, "exponential_psnr");
        check_near(value_of(scores, count, "linear_psnr", photo), whole, "linear_psnr");
    }
    free(scores);
    ASSERT_OK(vw_value_score(&(struct vw_value_input){.records = game->records, .record_count = 1}, &scores, &count));
    assert_int_equal(count, 0); // the untrained field alone
    free(scores);
    input.burn_in_epochs = 1;
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    assert_int_equal(count, 0); // no visit after burn-in
    free(scores);
}
