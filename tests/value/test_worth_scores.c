// Worth from retrainings, on games whose worths are known: the photos of a training share its steps, so that the
// outcome is a mean over them, besides what their number gives.
#include "support/draws.h"

#include "base/memory.h"
#include "base/random.h"
#include "base/statistics.h"
#include "value/evaluation/resampling.h"
#include "value/payout.h"
#include "value/worth.h"

enum { PHOTOS = 12, MOST = 200 };
static const double PER_LOG_SHARE_DB = 3;
// The worth of each photo alone. Photos 2 and 5 harm; photo 9's worth is 0 (see set_up).
static double given_db[PHOTOS] = {2, 1, -9, 3, 0.5, -12, 1.5, 0, 2.5, 0, 1, 2};

// Returns an outcome without noise.
static double play(const uint32_t *ids, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += given_db[ids[i]];
    return 20 + PER_LOG_SHARE_DB * log((double)count / PHOTOS) + sum / count;
}

static double worth_of(uint32_t photo) {
    uint32_t all[PHOTOS], others[PHOTOS], count = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) {
        all[i] = i;
        if (i != photo) others[count++] = i;
    }
    return play(all, PHOTOS) - play(others, count);
}

static int set_up(void **state) {
    (void)state;
    double low = -20, high = 20;
    for (int i = 0; i < 60; i++) {
        given_db[9] = (low + high) / 2;
        if (worth_of(9) > 0) high = given_db[9];
        else low = given_db[9];
    }
    return 0;
}

// A game's retrainings, as `worth` deals them out.
struct played {
    struct vw_ledger_image images[PHOTOS];
    struct vw_ledger_retraining rows[MOST];
    uint32_t ids[MOST][PHOTOS];
    struct vw_ledger_score scores[3 * PHOTOS];
    struct vw_worth_input input;
};

// Lists the photos of a retraining.
static void deal(const struct vw_subsets *subsets, uint32_t number, struct played *played) {
    uint32_t *ids = played->ids[number], count = 0, place = vw_worth_place(number);
    for (uint32_t j = 0; j < PHOTOS && vw_worth_is_of_all(number); j++) ids[count++] = j;
    if (!vw_worth_is_of_all(number))
        for (uint32_t i = subsets->offsets[place]; i < subsets->offsets[place + 1]; i++)
            ids[count++] = subsets->places[i];
    played->rows[number] = (struct vw_ledger_retraining){.image_ids = ids, .image_count = count};
}

// Plays `count` retrainings. With `providers`, each has the same number of neighbouring photos.
static struct played *play_game(uint32_t count, double noise_db, uint64_t seed, uint32_t providers) {
    static const char *const names[] = {"ada", "bob", "cyd", "dee"};
    struct played *played = calloc(1, sizeof *played);
    struct vw_subsets subsets;
    assert_non_null(played);
    assert_true(count <= MOST);
    ASSERT_OK(vw_subsets_draw(&(struct vw_subsets_params){PHOTOS, 0, count, 1, seed + 1}, &subsets));
    for (uint32_t i = 0; i < PHOTOS; i++)
        played->images[i] = (struct vw_ledger_image){.image_id = i,
                                                     .name = "photo",
                                                     .split = "train",
                                                     .provider = providers ? names[i * providers / PHOTOS] : ""};
    for (uint32_t i = 0; i < count; i++) {
        deal(&subsets, i, played);
        played->rows[i].val_psnr =
            play(played->ids[i], played->rows[i].image_count) + noise_db * test_normal(seed, 5, i);
    }
    vw_subsets_free(&subsets);
    played->input = (struct vw_worth_input){.retrainings = played->rows,
                                            .retraining_count = count,
                                            .images = played->images,
                                            .image_count = PHOTOS,
                                            .scores = played->scores};
    return played;
}

// Adds a prior: `share` times the worths, plus noise with a standard deviation of `noise`.
static void add_score(struct played *played, const char *method, double share, double noise, uint64_t seed) {
    for (uint32_t i = 0; i < PHOTOS; i++)
        played->scores[played->input.score_count++] =
            (struct vw_ledger_score){.image_id = i,
                                     .method = method,
                                     .visits = 3,
                                     .value = share * given_db[i] + noise * test_normal(seed, 5, 1000 + i)};
}

static const struct vw_ledger_score *find_worths(struct played *played, uint32_t *count) {
    struct vw_ledger_score *made = played->scores + played->input.score_count;
    *count = 0;
    ASSERT_OK(vw_worth_append(&played->input, made, count));
    return made;
}

static double error_of(struct played *played) {
    uint32_t count;
    double error = 0;
    const struct vw_ledger_score *worths = find_worths(played, &count);
    assert_int_equal(count, PHOTOS);
    for (uint32_t i = 0; i < PHOTOS; i++) error += pow(worths[i].value - worth_of(i), 2) / PHOTOS;
    return sqrt(error);
}

// ---- Photos --------------------------------------------------------------------------------------------------------

TEST(every_eighth_retraining_is_of_all) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < 100; i++) {
        assert_int_equal(vw_worth_is_of_all(i), i % VW_WORTH_REPEAT_EVERY == 0);
        if (!vw_worth_is_of_all(i)) assert_int_equal(vw_worth_place(i), next++);
    }
}

TEST(known_worths_are_found) {
    AUTO_FREE struct played *played = play_game(100, 0, 1, 0);
    uint32_t count;
    const struct vw_ledger_score *worths = find_worths(played, &count);
    assert_int_equal(count, PHOTOS);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        if (!(fabs(worths[i].value - worth_of(i)) < 1e-3))
            fail_msg("photo %u is worth %g, not %g", i, worths[i].value, worth_of(i));
        assert_true(worths[i].image_id == i && worths[i].visits > 40 && worths[i].visits < 100);
        assert_true(worths[i].rank_ci_low >= 1 && worths[i].rank_ci_high <= PHOTOS);
    }
    assert_true(worths[2].ci_high < 0 && worths[5].ci_high < 0 && worths[0].ci_low > 0);
    assert_int_equal(worths[5].rank_ci_low, PHOTOS);
}

// Means over 40 games with as many retrainings as photos or twice as many, with a prior and without.
TEST(intervals_hold_the_worths) {
    uint32_t held = 0, zero_known = 0, all = 0;
    for (uint32_t game = 0; game < 40; game++) {
        AUTO_FREE struct played *played = play_game(game % 4 < 2 ? 2 * PHOTOS : 4 * PHOTOS, 0.1, 100 + game, 0);
        uint32_t count;
        if (game % 2) add_score(played, "dv_psnr", 1, 3, 100 + game);
        const struct vw_ledger_score *worths = find_worths(played, &count);
        for (uint32_t i = 0; i < PHOTOS; i++, all++)
            held += worths[i].ci_low <= worth_of(i) && worth_of(i) <= worths[i].ci_high;
        zero_known += worths[9].ci_low > 0 || worths[9].ci_high < 0;
    }
    print_message("%u of %u intervals hold, %u of 40 are sure of a photo of no worth\n", held, all, zero_known);
    if (held < 0.9 * all) fail_msg("%u of %u intervals hold the true worth", held, all);
    if (zero_known > 6) fail_msg("%u of 40 games are sure of a photo without worth", zero_known);
}

// Fewer retrainings than photos show some directions of the worths, and the intervals hold what they do not show.
TEST(few_retrainings_leave_wide_intervals) {
    uint32_t held = 0, all = 0;
    double width = 0;
    for (uint32_t game = 0; game < 40; game++) {
        AUTO_FREE struct played *played = play_game(PHOTOS - 2, 0.1, 500 + game, 0);
        uint32_t count;
        const struct vw_ledger_score *worths = find_worths(played, &count);
        for (uint32_t i = 0; i < PHOTOS; i++, all++) {
            held += worths[i].ci_low <= worth_of(i) && worth_of(i) <= worths[i].ci_high;
            width += (worths[i].ci_high - worths[i].ci_low) / (40 * PHOTOS);
        }
    }
    print_message("%u of %u intervals hold, of a width of %.3f dB\n", held, all, width);
    if (fabs(width - 1.904) > 0.002) fail_msg("the width is not 1.904 dB, which a fit with a column per photo gives");
    if (held < 0.9 * all) fail_msg("%u of %u intervals hold the true worth", held, all);
}

// With few retrainings a good score helps, and one of chance does little harm.
TEST(a_prior_helps_where_it_is_right) {
    double none = 0, good = 0, chance = 0;
    for (uint32_t game = 0; game < 20; game++) {
        AUTO_FREE struct played *played = play_game(PHOTOS + 2, 0.3, 200 + game, 0);
        none += error_of(played) / 20;
        add_score(played, "dv_psnr", 1, 0.5, 200 + game);
        good += error_of(played) / 20;
        played->input.score_count = 0;
        add_score(played, "dv_psnr", 0, 1, 200 + game);
        chance += error_of(played) / 20;
    }
    print_message("error %.3f dB without a prior, %.3f with a good one, %.3f with chance\n", none, good, chance);
    if (!(good < 0.7 * none)) fail_msg("a good prior leaves %g of %g dB of error", good, none);
    if (!(chance < 1.15 * none)) fail_msg("a prior of chance makes %g of %g dB of error", chance, none);
}

// Returns how far differences of worth are from the true ones, dB.
static double difference_error_of(struct played *played) {
    uint32_t count;
    const struct vw_ledger_score *worths = find_worths(played, &count);
    double level = 0, sum = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) level += (worths[i].value - worth_of(i)) / PHOTOS;
    for (uint32_t i = 0; i < PHOTOS; i++) sum += pow(worths[i].value - worth_of(i) - level, 2);
    return sqrt(sum / PHOTOS);
}

// Lasting credit is in dB of what leaving a photo out does: with few and noisy retrainings it is taken at its word,
// where a score of any unit is hardly believed. Where it is wrong, more retrainings overrule it.
TEST(lasting_credit_is_taken_at_its_word) {
    double of_any_unit = 0, lasting = 0, wrong = 0, none = 0;
    for (uint32_t game = 0; game < 20; game++) {
        struct played *played = play_game(VW_WORTH_FOLDS + 2, 1, 300 + game, 0);
        add_score(played, "dv_psnr", 1, 0.1, 300 + game);
        of_any_unit += difference_error_of(played) / 20;
        played->input.score_count = 0;
        add_score(played, "lasting_psnr", 1, 0.1, 300 + game);
        lasting += difference_error_of(played) / 20;
        free(played);
        played = play_game(4 * PHOTOS, 0.1, 300 + game, 0);
        none += difference_error_of(played) / 20;
        add_score(played, "lasting_psnr", 0, 1, 300 + game);
        wrong += difference_error_of(played) / 20;
        free(played);
    }
    print_message("error %.3f dB by a score of any unit, %.3f by lasting credit; wrong %.3f, none %.3f\n", of_any_unit,
                  lasting, wrong, none);
    if (!(lasting < 0.95 * of_any_unit)) fail_msg("lasting credit leaves %g of %g dB of error", lasting, of_any_unit);
    if (!(wrong < 1.15 * none)) fail_msg("wrong lasting credit makes %g of %g dB of error", wrong, none);
}

TEST(too_few_retrainings_have_no_worths) {
    AUTO_FREE struct played *played = play_game(VW_WORTH_FOLDS - 1, 0, 1, 0);
    struct vw_worth_summary summary;
    uint32_t count;
    find_worths(played, &count);
    assert_int_equal(count, 0);
    ASSERT_OK(vw_worth_summarise(&played->input, &summary));
    assert_true(summary.claim_count == 0 && isnan(summary.r2));
    played->input.retraining_count = 0;
    find_worths(played, &count);
    assert_int_equal(count, 0);
    assert_null(vw_worth_first_prior(played->scores, 0));
    add_score(played, "dv_psnr", 1, 0, 1);
    assert_string_equal(vw_worth_first_prior(played->scores, PHOTOS), "dv_psnr");
    add_score(played, "lasting_psnr", 1, 0, 1);
    assert_string_equal(vw_worth_first_prior(played->scores, 2 * PHOTOS), "lasting_psnr");
}

// ---- The claim -----------------------------------------------------------------------------------------------------

// Outcomes that the number of photos alone decides, beside noise: nothing tells photos apart, and whatever scores there
// are, no accuracy is claimed. A fit that saw what it predicts would claim some.
TEST(what_cannot_be_known_is_not_claimed) {
    uint32_t sure = 0;
    double mean = 0;
    for (uint32_t game = 0; game < 20; game++) {
        AUTO_FREE struct played *played = play_game(40, 0, 300 + game, 0);
        struct vw_worth_summary summary;
        for (uint32_t i = 0; i < 40; i++)
            played->rows[i].val_psnr =
                20 + 3 * log(played->rows[i].image_count / 12.0) + 0.2 * test_normal(game, 5, 50 + i);
        add_score(played, "dv_psnr", 0, 1, 300 + game);
        add_score(played, "quality", 0, 1, 400 + game);
        ASSERT_OK(vw_worth_summarise(&played->input, &summary));
        assert_int_equal(summary.claim_count, 3);
        assert_true(summary.r2 > 0.5); // the number of photos is predicted
        mean += summary.claims[0].accuracy.spearman / 20;
        sure += summary.claims[0].accuracy.ci_low > 0;
    }
    print_message("mean accuracy of nothing %.3f, %u of 20 sure\n", mean, sure);
    if (mean > 0.1) fail_msg("an accuracy of %g is claimed of noise", mean);
    if (sure > 3) fail_msg("%u of 20 games are sure of noise", sure);
}

TEST(the_claim_grows_with_what_is_known) {
    struct vw_worth_summary exact, noisy;
    struct played *played = play_game(100, 0.01, 5, 0);
    add_score(played, "dv_psnr", 1, 0, 1);
    ASSERT_OK(vw_worth_summarise(&played->input, &exact));
    free(played);
    played = play_game(100, 0.6, 5, 0);
    ASSERT_OK(vw_worth_summarise(&played->input, &noisy));
    free(played);
    assert_true(exact.claims[0].accuracy.spearman > 0.99 && exact.claims[0].accuracy.r2 > 0.99 && exact.ceiling > 0.99);
    assert_string_equal(exact.claims[1].method, "dv_psnr");
    assert_true(exact.claims[1].accuracy.spearman > 0.9);
    assert_true(noisy.claims[0].accuracy.spearman < exact.claims[0].accuracy.ci_low && noisy.ceiling < exact.ceiling);
    if (fabs(noisy.noise_db - 0.6) > 0.3) fail_msg("the noise is %g dB, not 0.6", noisy.noise_db); // in 13 trainings
    assert_int_equal(exact.retraining_count, 100);
    assert_true(exact.repeat_count >= 13);
}

// ---- Draws ---------------------------------------------------------------------------------------------------------

// The draws of a photo have its worth as their mean and its standard error as their spread, with many retrainings, and
// with fewer than photos, where most of the spread is what no retraining shows.
TEST(draws_are_as_wide_as_intervals) {
    static const uint32_t numbers[] = {PHOTOS - 3, 60};
    AUTO_FREE double *draws = calloc(VW_RESAMPLES, PHOTOS * sizeof *draws);
    assert_non_null(draws);
    for (size_t n = 0; n < VW_ARRAY_COUNT(numbers); n++) {
        AUTO_FREE struct played *played = play_game(numbers[n], 0.3, 11, 0);
        uint32_t count;
        add_score(played, "dv_psnr", 1, 3, 11);
        const struct vw_ledger_score *worths = find_worths(played, &count);
        ASSERT_OK(vw_worth_draw(&played->input, draws));
        for (uint32_t i = 0; i < PHOTOS; i++) {
            struct vw_spread spread = {0};
            for (size_t r = 0; r < VW_RESAMPLES; r++) vw_spread_add(&spread, draws[r * PHOTOS + i]);
            double error = worths[i].standard_error, degrees = numbers[n] - 2.0;
            double expected = error * sqrt(degrees / (degrees - 2)); // Student's draws are wider
            if (fabs(spread.mean - worths[i].value) > 0.2 * error ||
                fabs(sqrt(vw_spread_variance(&spread)) / expected - 1) > 0.2)
                fail_msg("%u retrainings: photo %u is drawn as %g ± %g, not %g ± %g", numbers[n], i, spread.mean,
                         sqrt(vw_spread_variance(&spread)), worths[i].value, expected);
        }
    }
}

// Providers' payouts by the true worths lie within the 90 % intervals.
TEST(intervals_hold_the_payouts) {
    enum { GAMES = 40, PROVIDERS = 3, CENTS = 100000 };
    uint32_t held = 0, apart = 0, all = 0;
    for (uint32_t game = 0; game < GAMES; game++) {
        AUTO_FREE struct played *played = play_game(game % 2 ? PHOTOS : 3 * PHOTOS, 0.3, 700 + game, PROVIDERS);
        struct vw_payouts payouts;
        uint32_t count;
        double whole = 0, real[PROVIDERS] = {0};
        find_worths(played, &count);
        played->input.score_count = count;
        for (uint32_t i = 0; i < PHOTOS; i++) {
            double worth = fmax(worth_of(i), 0);
            whole += worth, real[i * PROVIDERS / PHOTOS] += worth;
        }
        ASSERT_OK(vw_payouts_make(&played->input, CENTS, &payouts));
        assert_int_equal(payouts.provider_count, PROVIDERS);
        for (uint32_t p = 0; p < PROVIDERS; p++, all++) {
            const struct vw_payout *payout = &payouts.providers[p];
            double expected = CENTS * real[payout->provider[0] - 'a'] / whole;
            held += payout->interval.low_cents <= expected && expected <= payout->interval.high_cents;
        }
        apart += payouts.outcome == VW_PAYOUT_PAID;
        vw_payouts_free(&payouts);
    }
    print_message("%u of %u payouts held, somebody is told apart in %u of %d games\n", held, all, apart, GAMES);
    if (held < 0.85 * all) fail_msg("%u of %u intervals hold the payout by the true worth", held, all);
}

TEST_GROUP(set_up, NULL)
