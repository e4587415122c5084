// Intervals of 95 % hold 95 % of the time, on series whose mean over seeds is known. SEED=N draws others.
#include "support/cmocka_test.h"

#include "base/memory.h"
#include "base/random.h"
#include "value/uncertainty.h"

enum { RUNS = 150, RUNS_OF_ONE = 3000, EPOCHS_MOST = 80, PHOTOS_MOST = 60 };

static uint64_t seed(void) { return getenv("SEED") ? strtoull(getenv("SEED"), NULL, 10) : 1; }

// Returns a normal number by a stream's seed and two counts (Box and Muller).
static double normal(uint64_t stream, uint32_t a, uint32_t b) {
    uint32_t words[4];
    vw_random_words(seed(), VW_RANDOM_RECIPE, stream, a, b, words);
    double radius = sqrt(-2 * log(1 - (double)vw_random_unit(words[0]))),
           angle = 2 * M_PI * (double)vw_random_unit(words[1]);
    return radius * cos(angle);
}

// The contributions of photos, epoch by epoch: a mean that is the same in all runs, and what differs from run to run.
struct game {
    const char *name;
    uint32_t photos, epochs;
    double correlation;  // correlation of neighbouring epochs
    double drift;        // shift of the mean at the first epoch, in standard deviations of a visit; gone after a few
    double growth;       // factor of the standard deviation, last epoch over the first
    double run_share;    // variance of a sum that all epochs of a run share, over that of what they do not
    double photo_spread; // standard deviation of the logarithm of the photos' standard deviations
    double missing;      // share of epochs without a visit
    double least, most;  // coverage that is wanted
};

static bool misses(const struct game *game, uint32_t run, uint32_t photo, uint32_t epoch) {
    uint32_t words[4];
    vw_random_words(seed(), VW_RANDOM_PIXEL, 1 + run, photo, epoch, words);
    return (double)vw_random_unit(words[0]) < game->missing;
}

// Draws a run's row of a photo; gives the mean over all runs of its sum.
static double play_photo(const struct game *game, uint32_t run, uint32_t photo, double *row) {
    double spread = exp(game->photo_spread * normal(0, photo, 0)), tilt = normal(0, photo, 1), rho = game->correlation;
    double before = normal(1 + run, photo, 1000000), shared = normal(1 + run, photo, 2000000), variance = 0, sum = 0;
    uint32_t visits = 0;
    for (uint32_t e = 0; e < game->epochs; e++) {
        double scale = spread * pow(game->growth, (double)e / game->epochs);
        double mean = spread * tilt * (0.2 + game->drift * exp(e / -4.0));
        before = rho * before + sqrt(1 - rho * rho) * normal(1 + run, photo, e);
        row[e] = misses(game, run, photo, e) ? NAN : mean + scale * before;
        if (isnan(row[e])) continue;
        sum += mean;
        variance += scale * scale * (1 + rho) / (1 - rho);
        visits++;
    }
    for (uint32_t e = 0; e < game->epochs; e++) row[e] += shared * sqrt(game->run_share * variance) / visits;
    return sum;
}

// Returns the share of intervals that hold the mean over runs.
static double cover(const struct game *game) {
    static double by_epoch[PHOTOS_MOST * EPOCHS_MOST], means[PHOTOS_MOST];
    struct vw_interval intervals[PHOTOS_MOST];
    uint32_t held = 0, runs = game->photos > 1 ? RUNS : RUNS_OF_ONE;
    for (uint32_t run = 0; run < runs; run++) {
        for (uint32_t p = 0; p < game->photos; p++)
            means[p] = play_photo(game, run, p, by_epoch + (size_t)p * game->epochs);
        ASSERT_OK(vw_intervals_of_sums(by_epoch, game->photos, game->epochs, intervals));
        for (uint32_t p = 0; p < game->photos; p++)
            held += intervals[p].ci_low <= means[p] && means[p] <= intervals[p].ci_high;
    }
    return (double)held / runs / game->photos;
}

static bool is_as_wanted(const struct game *game) {
    double coverage = cover(game);
    printf("%-38s %3u photos %3u epochs: %.1f %% hold the mean\n", game->name, game->photos, game->epochs,
           100 * coverage);
    if (coverage >= game->least && coverage <= game->most) return true;
    printf("    which is not %g to %g\n", 100 * game->least, 100 * game->most);
    return false;
}

static void check(const struct game *games, size_t count) {
    bool all = true;
    for (size_t i = 0; i < count; i++) all = is_as_wanted(&games[i]) && all;
    assert_true(all);
}

// Coverage is as claimed if runs share what the interval allows for and the epochs are enough.
TEST(intervals_hold_the_mean) {
    for (uint32_t epochs = 29; epochs <= 58; epochs *= 2) { // 29 count of the 30 that are usual
        const struct game games[] = {
            {"independent epochs", 36, epochs, 0, 0, 1, 0.5, 0.4, 0, 0.93, 0.97},
            {"neighbours alike", 36, epochs, 0.4, 0, 1, 0.5, 0.4, 0, 0.92, 0.97},
            {"neighbours opposed", 36, epochs, -0.5, 0, 1, 0.5, 0.4, 0, 0.93, 0.98},
            {"a mean that falls", 36, epochs, 0, 3, 1, 0.5, 0.4, 0, 0.93, 0.97},
            {"a mean that falls, neighbours opposed", 36, epochs, -0.5, 3, 1, 0.5, 0.4, 0, 0.93, 0.98},
            {"noise that grows fourfold", 36, epochs, 0, 0, 4, 0.5, 0.4, 0, 0.93, 0.975},
            {"noise that shrinks to a quarter", 36, epochs, 0, 0, 0.25, 0.5, 0.4, 0, 0.93, 0.97},
            {"a tenth of the visits missing", 36, epochs, 0, 0, 1, 0.5, 0.4, 0.1, 0.93, 0.97},
            {"photos of unlike noise", 36, epochs, 0, 0, 1, 0.5, 0.8, 0, 0.93, 0.97},
            {"few photos", 6, epochs, 0, 0, 1, 0.5, 0.4, 0, 0.92, 0.98},
            {"a single photo", 1, epochs, 0, 0, 1, 0.5, 0.4, 0, 0.92, 0.98},
        };
        check(games, VW_ARRAY_COUNT(games));
    }
}

// Limits of the intervals: they are a little wide when runs share nothing, and narrow when runs share twice as much.
// With few epochs they are wide, or narrow where the epochs are too few to tell that neighbours are alike or that noise
// fell while it was still large.
TEST(where_less_is_claimed) {
    const struct game games[] = {
        {"runs share nothing", 36, 32, 0, 0, 1, 0, 0.4, 0, 0.96, 0.99},
        {"runs share as much again", 36, 32, 0, 0, 1, 1, 0.4, 0, 0.88, 0.94},
        {"fewer epochs, neighbours alike", 36, 16, 0.4, 0, 1, 0.5, 0.4, 0, 0.9, 0.97},
        {"fewer epochs, noise that shrinks", 36, 16, 0, 0, 0.25, 0.5, 0.4, 0, 0.9, 0.97},
        {"few epochs", 36, 8, 0, 0, 1, 0.5, 0.4, 0, 0.93, 0.99},
        {"very few epochs", 36, 4, 0, 0, 1, 0.5, 0.4, 0, 0.93, 1},
        {"two epochs", 36, 2, 0, 0, 1, 0.5, 0.4, 0, 0.93, 1},
    };
    check(games, VW_ARRAY_COUNT(games));
}

static void fill(double *by_epoch, uint32_t photos, uint32_t epochs) {
    for (uint32_t i = 0; i < photos * epochs; i++) by_epoch[i] = 0.3 * (i / epochs) + normal(7, i / epochs, i % epochs);
}

// Scale and offset of a photo, and epochs that no photo was visited in, change what they must and nothing else.
TEST(intervals_follow_the_sum) {
    enum { PHOTOS = 5, EPOCHS = 20, BEFORE = 3, AFTER = 4, WIDE = BEFORE + EPOCHS + AFTER };
    double plain[PHOTOS * EPOCHS], scaled[PHOTOS * EPOCHS], padded[PHOTOS * WIDE];
    struct vw_interval a[PHOTOS], b[PHOTOS], c[PHOTOS];
    fill(plain, PHOTOS, EPOCHS);
    for (uint32_t i = 0; i < PHOTOS * EPOCHS; i++) scaled[i] = -3 * plain[i] + 2;
    for (uint32_t i = 0; i < PHOTOS * WIDE; i++) {
        uint32_t epoch = i % WIDE;
        padded[i] = epoch < BEFORE || epoch >= BEFORE + EPOCHS ? NAN : plain[i / WIDE * EPOCHS + epoch - BEFORE];
    }
    ASSERT_OK(vw_intervals_of_sums(plain, PHOTOS, EPOCHS, a));
    ASSERT_OK(vw_intervals_of_sums(scaled, PHOTOS, EPOCHS, b));
    ASSERT_OK(vw_intervals_of_sums(padded, PHOTOS, WIDE, c));
    for (uint32_t p = 0; p < PHOTOS; p++) {
        double sum = 0;
        for (uint32_t e = 0; e < EPOCHS; e++) sum += plain[p * EPOCHS + e];
        assert_near((a[p].ci_low + a[p].ci_high) / 2, sum, 1e-9);
        assert_true(a[p].standard_error > 0 && a[p].ci_high - sum > 1.96 * a[p].standard_error);
        assert_near(b[p].standard_error, 3 * a[p].standard_error, 1e-9);
        assert_near(b[p].ci_low, -3 * a[p].ci_high + 2 * EPOCHS, 1e-9);
        assert_true(c[p].standard_error == a[p].standard_error && c[p].ci_low == a[p].ci_low &&
                    c[p].ci_high == a[p].ci_high);
    }
}

TEST(what_is_unknown_is_said) {
    enum { PHOTOS = 4, EPOCHS = 12 };
    double by_epoch[PHOTOS * EPOCHS];
    struct vw_interval intervals[PHOTOS];
    fill(by_epoch, PHOTOS, EPOCHS);
    for (uint32_t e = 0; e < EPOCHS; e++) by_epoch[e] = NAN;                                 // never visited
    for (uint32_t e = 0; e < EPOCHS; e++) by_epoch[EPOCHS + e] = e == 4 ? 1 : NAN;           // once
    for (uint32_t e = 0; e < EPOCHS; e++) by_epoch[2 * EPOCHS + e] = e % 6 == 1 ? 0.5 : NAN; // twice, alike
    ASSERT_OK(vw_intervals_of_sums(by_epoch, PHOTOS, EPOCHS, intervals));
    for (uint32_t p = 0; p < 2; p++)
        assert_true(isnan(intervals[p].standard_error) && isnan(intervals[p].ci_low) && isnan(intervals[p].ci_high));
    assert_true(intervals[2].standard_error >
                0); // the agreement of two visits does not prove precision: the other photos' variance is used too
    assert_near((intervals[2].ci_low + intervals[2].ci_high) / 2, 1, 1e-9);
    for (uint32_t i = 0; i < PHOTOS * EPOCHS; i++) by_epoch[i] = i / EPOCHS;
    ASSERT_OK(vw_intervals_of_sums(by_epoch, PHOTOS, EPOCHS, intervals));
    for (uint32_t p = 0; p < PHOTOS; p++) {
        assert_true(intervals[p].standard_error < 1e-12); // rounding
        assert_near(intervals[p].ci_low, p * EPOCHS, 1e-9);
    }
    ASSERT_OK(vw_intervals_of_sums(by_epoch, PHOTOS, 1, intervals));
    assert_true(isnan(intervals[3].standard_error));
    ASSERT_OK(vw_intervals_of_sums(by_epoch, 0, EPOCHS, intervals));
}

// ---- Ranks ----

static struct vw_ledger_score score(double value, double standard_error) {
    return (struct vw_ledger_score){.method = "m", .value = value, .unit = "dB", .standard_error = standard_error};
}

static void assert_ranks(const struct vw_ledger_score *score, uint32_t low, uint32_t high) {
    if (score->rank_ci_low != low || score->rank_ci_high != high)
        fail_msg("%g +- %g ranks %u-%u, not %u-%u", score->value, score->standard_error, score->rank_ci_low,
                 score->rank_ci_high, low, high);
}

TEST(ranks_count_who_is_surely_better) {
    // 10 and 8 differ by 1.41 standard errors of the difference, 8 and 3 by 3.5, and 3 from itself by none.
    struct vw_ledger_score scores[] = {score(3, 1),     score(10, 1),    score(8, 1), score(3, 1),
                                       score(NAN, NAN), score(-50, NAN), score(-5, 0)};
    scores[4].value = 4;
    vw_rank_intervals(scores, VW_ARRAY_COUNT(scores), 0);
    assert_ranks(&scores[1], 1, 4); // not surely better than 8, nor than the two that are not known
    assert_ranks(&scores[2], 1, 4);
    assert_ranks(&scores[0], 3, 6);
    assert_ranks(&scores[3], 3, 6);
    assert_ranks(&scores[4], 0, 0);
    assert_ranks(&scores[5], 0, 0);
    assert_ranks(&scores[6], 5, 7);
    struct vw_ledger_score exact[] = {score(1, 0), score(2, 0), score(1, 0)};
    vw_rank_intervals(exact, 3, 0);
    assert_ranks(&exact[1], 1, 1);
    assert_ranks(&exact[0], 2, 3);    // a tie
    vw_rank_intervals(exact, 3, 0.2); // 1 is 1.58 standard errors of the difference then
    assert_ranks(&exact[1], 1, 3);
    vw_rank_intervals(exact, 3, 0.18); // 1.67
    assert_ranks(&exact[1], 1, 1);
    vw_rank_intervals(NULL, 0, 0);
}

// The share of rank intervals that hold the true rank, where values spread `spread` standard errors.
TEST(ranks_are_held) {
    enum { PHOTOS = 40 };
    const double spreads[] = {0.5, 1, 3, 10};
    for (size_t s = 0; s < VW_ARRAY_COUNT(spreads); s++) {
        uint32_t held = 0, width = 0;
        for (uint32_t run = 0; run < RUNS; run++) {
            struct vw_ledger_score scores[PHOTOS];
            double ground_truths[PHOTOS];
            for (uint32_t p = 0; p < PHOTOS; p++) {
                double error = exp(0.4 * normal(20 + run, p, 0));
                ground_truths[p] = spreads[s] * normal(20 + run, p, 1);
                scores[p] = score(ground_truths[p] + error * normal(20 + run, p, 2), error);
            }
            vw_rank_intervals(scores, PHOTOS, 0);
            for (uint32_t p = 0; p < PHOTOS; p++) {
                uint32_t rank = 1;
                for (uint32_t other = 0; other < PHOTOS; other++) rank += ground_truths[other] > ground_truths[p];
                held += scores[p].rank_ci_low <= rank && rank <= scores[p].rank_ci_high;
                width += scores[p].rank_ci_high - scores[p].rank_ci_low + 1;
            }
        }
        double coverage = (double)held / RUNS / PHOTOS;
        printf("ranks, ground_truths %g errors apart: %.1f %% hold the true one, %.1f wide\n", spreads[s],
               100 * coverage, (double)width / RUNS / PHOTOS);
        assert_true(coverage >= 0.93 && coverage <= 0.99);
        assert_true(s < 3 || width < 8 * RUNS * PHOTOS); // and say something
    }
}
