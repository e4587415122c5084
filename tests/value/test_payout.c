// Providers' sums and their errors, and amounts divided among photos to the cent.
#include "support/ledger_fixture.h"

#include "base/random.h"
#include "value/evaluation/resampling.h"
#include "value/payout.h"
#include "value/providers.h"

// Photos 1 and 6 are alice's, 2 and 5 bob's, 3 nobody's; see test_images.
static const struct vw_ledger_score scores[] = {
    {1, "dv_psnr", 3, "dB", 0.3, 4},
    {2, "dv_psnr", 1.5, "dB", 0.5, 4},
    {3, "dv_psnr", 7, "dB", 0.1, 4},
    {5, "dv_psnr", -0.5, "dB", 1.2, 4},
    {6, "dv_psnr", -1, "dB", 0.4, 4},
    {1, "dv_loss", -0.01, "mean absolute error", NAN, 1},
    {2, "dv_loss", 0.02, "mean absolute error", 0.01, 4},
    {1, "other", 0.5, "rank", 0.1, 4},
    {6, "other", 0.5, "rank", 0.1, 4},
    {1, "momentum_psnr", 0.25, "dB", 0.5, 4},
};

static void check_group(const struct vw_provider_score *group, const char *provider, const char *method, double value,
                        double error, uint32_t photo_count) {
    assert_string_equal(group->provider, provider);
    assert_string_equal(group->method, method);
    assert_near(group->value, value, 1e-15);
    if (isnan(error)) assert_true(isnan(group->standard_error));
    else assert_near(group->standard_error, error, 1e-15);
    assert_int_equal(group->photo_count, photo_count);
}

TEST(a_providers_score_is_the_sum_over_its_photos) {
    struct vw_provider_score *groups = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_providers_score(scores, VW_ARRAY_COUNT(scores), test_images, TEST_IMAGE_COUNT, &groups, &count));
    assert_int_equal(count, 6); // scores that are not known to add up are left out
    check_group(&groups[0], "", "dv_psnr", 7, 0.1, 1);
    check_group(&groups[1], "alice", "dv_psnr", 2, 0.5, 2); // 0.3, 0.4
    check_group(&groups[2], "bob", "dv_psnr", 1, 1.3, 2);   // 0.5, 1.2
    check_group(&groups[3], "bob", "dv_loss", 0.02, 0.01, 1);
    check_group(&groups[4], "alice", "dv_loss", -0.01, NAN, 1); // a photo's error is unknown
    check_group(&groups[5], "alice", "momentum_psnr", 0.25, 0.5, 1);
    assert_string_equal(groups[3].unit, "mean absolute error");

    free(groups);
    groups = NULL;
    ASSERT_OK(vw_providers_score(NULL, 0, test_images, TEST_IMAGE_COUNT, &groups, &count));
    assert_int_equal(count, 0);
    free(groups);
    const struct vw_ledger_score stray = {.image_id = 99, .method = "m", .unit = "dB"};
    assert_int_equal(vw_providers_score(&stray, 1, test_images, TEST_IMAGE_COUNT, &groups, &count), VW_ERROR_INPUT);
}

// ---- Division -------------------------------------------------------------------------------------------------------

enum { PHOTOS_MOST = 9 };
static const char *const photo_names[PHOTOS_MOST] = {"a", "b", "c", "d", "e", "f", "g", "h", "i"};

// Photos with worths, which are drawn with a standard deviation of `error`, and their providers, a letter each; '-':
// none.
struct scene {
    struct vw_ledger_image images[PHOTOS_MOST];
    struct vw_ledger_score scores[PHOTOS_MOST];
    char providers[PHOTOS_MOST][2];
    double draws[VW_RESAMPLES * PHOTOS_MOST];
    struct vw_worth_input input;
    uint64_t amount_cents;
};

static void set_scene(const double *values, uint32_t count, double error, const char *providers, uint64_t amount_cents,
                      struct scene *scene) {
    *scene = (struct scene){.amount_cents = amount_cents};
    for (uint32_t i = 0; i < count; i++) {
        scene->providers[i][0] = providers[i] == '-' ? 0 : providers[i];
        scene->images[i] = (struct vw_ledger_image){
            .image_id = i, .name = photo_names[i], .split = "train", .provider = scene->providers[i]};
        scene->scores[i] = (struct vw_ledger_score){.image_id = i, .method = vw_worth_method, .value = values[i]};
        for (uint32_t r = 0; r < VW_RESAMPLES; r++)
            scene->draws[r * count + i] = values[i] + error * vw_resampling_normal(r, i);
    }
    scene->input = (struct vw_worth_input){
        .images = scene->images, .image_count = count, .scores = scene->scores, .score_count = count};
}

static enum vw_status divide(struct scene *scene, struct vw_payouts *payouts) {
    *payouts = (struct vw_payouts){.amount_cents = scene->amount_cents};
    return vw_payouts_divide(&scene->input, scene->draws, payouts);
}

// Returns the payout of a provider; NULL: it has none.
static const struct vw_payout *payout_of(const struct vw_payouts *payouts, char provider) {
    for (uint32_t i = 0; i < payouts->provider_count; i++)
        if (payouts->providers[i].provider[0] == provider) return &payouts->providers[i];
    return NULL;
}

// Returns the cents of all photos, in their own order; checks that those of a provider add up to its own.
static uint64_t cents_of_photos(const struct vw_payouts *payouts, uint64_t *cents) {
    uint64_t sum = 0;
    uint32_t photos = 0;
    for (uint32_t p = 0; p < payouts->provider_count; p++) {
        const struct vw_payout *payout = &payouts->providers[p];
        uint64_t own = 0;
        for (uint32_t i = 0; i < payout->photo_count; i++, photos++) {
            const struct vw_photo_payout *photo = &payouts->photos[payout->first_photo + i];
            assert_string_equal(photo->image->provider, payout->provider);
            own += cents[photo->image->image_id] = photo->cents;
        }
        assert_int_equal(own, payout->cents);
        assert_true(p == 0 || payouts->providers[p - 1].cents >= own);
        sum += own;
    }
    assert_int_equal(photos, payouts->photo_count);
    return sum;
}

TEST(amounts_are_divided_to_the_cent) {
    static const struct {
        double values[PHOTOS_MOST];
        uint32_t count;
        uint64_t amount_cents, expected[PHOTOS_MOST];
    } cases[] = {
        {{1}, 1, 1, {1}},
        {{1, 1, 1}, 3, 100, {34, 33, 33}}, // a tie: by the photo's name
        {{1, 1, 1}, 3, 2, {1, 1, 0}},      //
        {{5, 3, 2}, 3, 10000, {5000, 3000, 2000}},
        {{0.5, 0.3, 0.2}, 3, 99, {49, 30, 20}},      // 49.5, 29.7, 19.8: the largest fractions get the two left
        {{4, -9, 1}, 3, 1000, {800, 0, 200}},        // a photo that harms is not paid, nor does it take from others
        {{4, 0, 1, NAN}, 4, 1001, {801, 0, 200, 0}}, // 800.8 and 200.2
        {{-1, -2, -3}, 3, 100, {0, 0, 0}},           // nobody is paid
        {{1e-300, 3e-300}, 2, 400, {100, 300}},
        {{1, 1e-30}, 2, 1000, {1000, 0}},
        {{1, 2, 4}, 3, 1000000000000000, {142857142857143, 285714285714286, 571428571428571}},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct scene scene;
        struct vw_payouts payouts;
        uint64_t cents[PHOTOS_MOST], all = cases[i].values[0] > 0 ? cases[i].amount_cents : 0;
        set_scene(cases[i].values, cases[i].count, NAN, "zyxwvutsr", cases[i].amount_cents, &scene);
        ASSERT_OK(divide(&scene, &payouts));
        assert_int_equal(cents_of_photos(&payouts, cents), all);
        for (uint32_t p = 0; p < cases[i].count; p++)
            if (cents[p] != cases[i].expected[p])
                fail_msg("case %zu: photo %u gets %llu cents, not %llu", i, p, (unsigned long long)cents[p],
                         (unsigned long long)cases[i].expected[p]);
        assert_int_equal(payouts.outcome, VW_PAYOUT_NOT_TOLD_APART);
        assert_true(isnan(payouts.providers[0].interval.low_cents)); // no worth has an error
        vw_payouts_free(&payouts);
    }
}

// Photos' payouts, in their own order.
struct paid {
    uint64_t cents[PHOTOS_MOST];
    struct vw_payout_interval intervals[PHOTOS_MOST];
};

static bool has_none_positive(const double *values, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (values[i] > 0) return false;
    return true;
}

static void pay(const double *values, uint32_t count, const char *providers, uint64_t amount_cents, struct paid *paid) {
    struct scene scene;
    struct vw_payouts payouts;
    set_scene(values, count, 0.2, providers, amount_cents, &scene);
    ASSERT_OK(divide(&scene, &payouts));
    *paid = (struct paid){0};
    uint64_t sum = cents_of_photos(&payouts, paid->cents);
    assert_true(sum == amount_cents || (sum == 0 && has_none_positive(values, count)));
    for (uint32_t i = 0; i < count; i++)
        paid->intervals[payouts.photos[i].image->image_id] = payouts.photos[i].interval;
    vw_payouts_free(&payouts);
}

// Checks for any scores, names and amount that cents add up, a photo's share is exact to a cent, and names change
// nothing.
TEST(names_change_no_payout) {
    static const char *const names[] = {"pqpqpqpqp", "abcdefghi", "ihgfedcba", "zzaazzaaz"};
    const uint64_t seed = 7;
    for (uint32_t round = 0; round < 300; round++) {
        double values[PHOTOS_MOST], positive = 0;
        struct paid first, other;
        uint32_t words[4];
        vw_random_words(seed, VW_RANDOM_JITTER, round, 0, 0, words);
        uint32_t count = 1 + words[0] % PHOTOS_MOST;
        uint64_t amount = 1 + ((uint64_t)words[1] << 16) % (round % 2 ? 1000 : VW_PAYOUT_CENTS_MAX);
        for (uint32_t i = 0; i < count; i++) {
            vw_random_words(seed, VW_RANDOM_JITTER, round, 1 + i, 0, words);
            values[i] = 2 * vw_random_unit(words[0]) - 0.5;
            positive += fmax(values[i], 0);
        }
        pay(values, count, "ppppppppp", amount, &first);
        for (uint32_t n = 0; n < VW_ARRAY_COUNT(names); n++) {
            pay(values, count, names[n], amount, &other);
            assert_memory_equal(&other, &first, sizeof first);
        }
        for (uint32_t i = 0; i < count && positive > 0; i++) {
            double share = (double)amount * fmax(values[i], 0) / positive;
            assert_near((double)first.cents[i], share, 1 + 1e-12 * (double)amount); // and the rounding of this sum
            if (values[i] <= 0) assert_int_equal(first.cents[i], 0);
        }
    }
}

// ---- Who is paid for what -------------------------------------------------------------------------------------------

TEST(what_was_not_valued_is_counted) {
    struct scene scene;
    struct vw_payouts payouts;
    set_scene((double[]){1, 1, 1, 1, 1, 1, 1}, 7, 0.1, "abab-bc", 100, &scene);
    scene.images[1].split = "val";
    scene.images[2].split = "test";
    scene.images[5].split = "excluded";
    scene.images[6].split = "val";
    for (uint32_t i = 1; i < 7; i++) scene.scores[i].method = i == 4 ? vw_worth_method : "dv_loss";
    ASSERT_OK(divide(&scene, &payouts));
    assert_int_equal(payouts.provider_count, 3);
    assert_int_equal(payouts.photo_count, 1);
    const struct vw_payout *a = payout_of(&payouts, 'a'), *b = payout_of(&payouts, 'b'), *c = payout_of(&payouts, 'c');
    assert_true(a->photo_count == 1 && a->unvalued_count == 1 && a->cents == 100);
    assert_true(b->photo_count == 0 && b->unvalued_count == 2);
    assert_true(c->photo_count == 0 && c->unvalued_count == 1 && c->cents == 0);
    assert_int_equal(payouts.outcome, VW_PAYOUT_NOT_TOLD_APART); // the only one: nothing tells it apart
    vw_payouts_free(&payouts);
    set_scene((double[]){1, 1}, 2, 0.1, "--", 100, &scene);
    assert_int_equal(divide(&scene, &payouts), VW_ERROR_INPUT);
    vw_payouts_free(&payouts);
    scene.input.score_count = 0;
    ASSERT_OK(vw_payouts_make(&scene.input, 100, &payouts));
    assert_true(payouts.outcome == VW_PAYOUT_UNKNOWN_WORTH && !payouts.provider_count);
    vw_payouts_free(&payouts);
}

// ---- Intervals ------------------------------------------------------------------------------------------------------

// Two photos of 3 and 1 with a small error e: the share of the first is 3/4 with the error e sqrt(10) / 16.
TEST(intervals_hold_nine_of_ten) {
    struct scene scene;
    struct vw_payouts payouts;
    set_scene((double[]){3, 1}, 2, 0.05, "ab", 1000000, &scene);
    ASSERT_OK(divide(&scene, &payouts));
    double half = 1.645 * 1000000 * 0.05 * sqrt(10) / 16;
    const struct vw_payout_interval *interval = &payouts.providers[0].interval;
    print_message("[%.0f, %.0f], expected 750000 ± %.0f\n", interval->low_cents, interval->high_cents, half);
    assert_near(interval->low_cents, 750000 - half, 0.1 * half);
    assert_near(interval->high_cents, 750000 + half, 0.1 * half);
    vw_payouts_free(&payouts);
}

// The same photos under any names are paid or not: alike, and whoever has all of them.
TEST(names_do_not_decide_who_is_paid) {
    static const char *const names[] = {"aaaa", "aabb", "abab", "abcd", "abbb"};
    static const struct {
        double values[4], error;
        enum vw_payout_outcome outcome;
    } cases[] = {{{3, 3, 3, 3}, 0.1, VW_PAYOUT_NOT_TOLD_APART},
                 {{3, 1, 1, 1}, 0.1, VW_PAYOUT_PAID},
                 {{3, 2, 2, 3}, 1, VW_PAYOUT_NOT_TOLD_APART},
                 {{3, 2, 2, 3}, NAN, VW_PAYOUT_NOT_TOLD_APART}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++)
        for (size_t n = 0; n < VW_ARRAY_COUNT(names); n++) {
            struct scene scene;
            struct vw_payouts payouts;
            set_scene(cases[i].values, 4, cases[i].error, names[n], 10000, &scene);
            ASSERT_OK(divide(&scene, &payouts));
            if (payouts.outcome != cases[i].outcome) fail_msg("case %zu: %s", i, names[n]);
            vw_payouts_free(&payouts);
        }
}

TEST(amounts_are_read_exactly) {
    static const struct {
        const char *text;
        uint64_t cents; // 0: refused
    } cases[] = {
        {"1000", 100000}, {"0.01", 1},  {"99.5", 9950},
        {"99.05", 9905},  {"0.29", 29}, {"10000000000000", 1000000000000000},
        {"", 0},          {"0", 0},     {"0.00", 0},
        {"-5", 0},        {"5.", 0},    {"10000000000000.01", 0},
        {".5", 0},        {"1.005", 0}, {"1e3", 0},
        {"1,000", 0},     {" 1", 0},    {"99999999999999999999999999", 0},
        {"nan", 0},       {"5 ", 0},    {"1.0.0", 0},
        {"+5", 0},        {"5x", 0},    {"0.00000000000000000000000000001", 0},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        uint64_t cents = 0;
        if (vw_payout_parse(cases[i].text, &cents) != (cases[i].cents > 0) ||
            (cases[i].cents > 0 && cents != cases[i].cents))
            fail_msg("\"%s\" is read as %llu cents", cases[i].text, (unsigned long long)cents);
    }
}
