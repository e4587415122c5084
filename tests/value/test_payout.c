// Providers' sums and their errors, and amounts divided to the cent.
#include "support/ledger_fixture.h"

#include "value/providers.h"

// Photos 1 and 6 are alice's, 2 and 5 bob's, 3 nobody's; see test_images.
static const struct vw_ledger_score scores[] = {
    {.image_id = 1, .method = "dv_psnr", .value = 3, .unit = "dB", .standard_error = 0.3, .visits = 4},
    {.image_id = 2, .method = "dv_psnr", .value = 1.5, .unit = "dB", .standard_error = 0.5, .visits = 4},
    {.image_id = 3, .method = "dv_psnr", .value = 7, .unit = "dB", .standard_error = 0.1, .visits = 4},
    {.image_id = 5, .method = "dv_psnr", .value = -0.5, .unit = "dB", .standard_error = 1.2, .visits = 4},
    {.image_id = 6, .method = "dv_psnr", .value = -1, .unit = "dB", .standard_error = 0.4, .visits = 4},
    {.image_id = 1,
     .method = "dv_loss",
     .value = -0.01,
     .unit = "mean absolute error",
     .standard_error = NAN,
     .visits = 1},
    {.image_id = 2,
     .method = "dv_loss",
     .value = 0.02,
     .unit = "mean absolute error",
     .standard_error = 0.01,
     .visits = 4},
    {.image_id = 1, .method = "other", .value = 0.5, .unit = "rank", .standard_error = 0.1, .visits = 4},
    {.image_id = 6, .method = "other", .value = 0.5, .unit = "rank", .standard_error = 0.1, .visits = 4},
    {.image_id = 1, .method = "momentum_psnr", .value = 0.25, .unit = "dB", .standard_error = 0.5, .visits = 4},
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

TEST(sums_are_of_the_photos) {
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

    struct vw_payout *payouts = NULL;
    uint32_t payout_count = 0;
    bool none_positive = true;
    ASSERT_OK(vw_payout_divide(groups, count, "dv_psnr", 10000, &payouts, &payout_count, &none_positive));
    assert_int_equal(payout_count, 2); // nobody is paid for the photo without a provider
    assert_false(none_positive);
    assert_true(payouts[0].group == &groups[1] && payouts[0].cents == 6667);
    assert_true(payouts[1].group == &groups[2] && payouts[1].cents == 3333);
    assert_near(payouts[0].share, 2.0 / 3, 1e-15);
    free(payouts);
    assert_int_equal(vw_payout_divide(groups, 1, "dv_psnr", 10000, &payouts, &payout_count, &none_positive),
                     VW_ERROR_INPUT);
    assert_int_equal(vw_payout_divide(groups, count, "other", 10000, &payouts, &payout_count, &none_positive),
                     VW_ERROR_INPUT);
    free(groups);
    groups = NULL;
    ASSERT_OK(vw_providers_score(NULL, 0, test_images, TEST_IMAGE_COUNT, &groups, &count));
    assert_int_equal(count, 0);
    free(groups);
    const struct vw_ledger_score stray = {.image_id = 99, .method = "m", .unit = "dB"};
    assert_int_equal(vw_providers_score(&stray, 1, test_images, TEST_IMAGE_COUNT, &groups, &count), VW_ERROR_INPUT);
}

enum { PROVIDERS_MOST = 7 };
static const char *const names[PROVIDERS_MOST] = {"a", "b", "c", "d", "e", "f", "g"};

static uint64_t divide(const double *values, uint32_t count, uint64_t amount_cents, uint64_t *cents,
                       bool *none_positive) {
    struct vw_provider_score groups[PROVIDERS_MOST] = {0};
    struct vw_payout *payouts = NULL;
    uint32_t payout_count = 0;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        groups[i] = (struct vw_provider_score){.provider = names[i], .method = "m", .value = values[i]};
    ASSERT_OK(vw_payout_divide(groups, count, "m", amount_cents, &payouts, &payout_count, none_positive));
    assert_int_equal(payout_count, count);
    for (uint32_t i = 0; i < count; i++) sum += cents[i] = payouts[i].cents;
    free(payouts);
    return sum;
}

TEST(amounts_are_divided_to_the_cent) {
    static const struct {
        double values[PROVIDERS_MOST];
        uint32_t count;
        uint64_t amount_cents, expected[PROVIDERS_MOST];
        bool none_positive;
    } cases[] = {
        {{1}, 1, 1, {1}, false},
        {{1, 1, 1}, 3, 100, {34, 33, 33}, false},         // a tie: by name
        {{1, 1, 1}, 3, 2, {1, 1, 0}, false},              //
        {{5, 3, 2}, 3, 10000, {5000, 3000, 2000}, false}, //
        {{0.5, 0.3, 0.2},
         3,
         99,
         {49, 30, 20},
         false},                                     // 49.5, 29.7, 19.8: the two cents left go to the largest fractions
        {{4, -9, 1}, 3, 1000, {800, 0, 200}, false}, // a harmful provider is not paid, nor does it take from others
        {{4, 0, 1, NAN}, 4, 1001, {801, 0, 200, 0}, false}, // 800.8 and 200.2
        {{-1, -2, -3}, 3, 100, {34, 33, 33}, true},         //
        {{0, 0}, 2, 5, {3, 2}, true},                       //
        {{1e-300, 3e-300}, 2, 400, {100, 300}, false},      //
        {{1, 1e-30}, 2, 1000, {1000, 0}, false},            //
        {{1, 2, 4},
         3,
         1000000000000000,
         {142857142857143, 285714285714286, 571428571428571},
         false}, // .857, .714, .429
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        uint64_t cents[PROVIDERS_MOST];
        const uint64_t *expected = cases[i].expected;
        bool none_positive = !cases[i].none_positive;
        assert_int_equal(divide(cases[i].values, cases[i].count, cases[i].amount_cents, cents, &none_positive),
                         cases[i].amount_cents);
        for (uint32_t p = 0; p < cases[i].count; p++)
            if (cents[p] != expected[p])
                fail_msg("case %zu: %s gets %llu cents, not %llu", i, names[p], (unsigned long long)cents[p],
                         (unsigned long long)expected[p]);
        assert_int_equal(none_positive, cases[i].none_positive);
    }
}

// For any scores the cents add up, every share is exact to a cent, and a provider who harms gets nothing.
TEST(any_amount_adds_up) {
    const uint64_t seed = 7;
    for (uint32_t round = 0; round < 2000; round++) {
        double values[PROVIDERS_MOST], positive = 0;
        uint64_t cents[PROVIDERS_MOST];
        uint32_t words[4];
        bool none_positive = false;
        vw_random_words(seed, VW_RANDOM_JITTER, round, 0, 0, words);
        uint32_t count = 1 + words[0] % PROVIDERS_MOST;
        uint64_t amount = 1 + ((uint64_t)words[1] << 16) % (round % 2 ? 1000 : VW_PAYOUT_CENTS_MAX);
        for (uint32_t i = 0; i < count; i++) {
            vw_random_words(seed, VW_RANDOM_JITTER, round, 1 + i, 0, words);
            values[i] = 2 * vw_random_unit(words[0]) - 0.5;
            positive += fmax(values[i], 0);
        }
        uint64_t sum = divide(values, count, amount, cents, &none_positive);
        if (sum != amount)
            fail_msg("seed 7, round %u: %llu of %llu cents", round, (unsigned long long)sum,
                     (unsigned long long)amount);
        for (uint32_t i = 0; i < count && !none_positive; i++) {
            double share = (double)amount * fmax(values[i], 0) / positive;
            assert_near((double)cents[i], share, 1 + 1e-12 * (double)amount); // and the rounding of this sum in double
            if (values[i] <= 0) assert_int_equal(cents[i], 0);
        }
    }
}

static struct vw_ledger_score lasting(uint32_t image_id, double value) {
    return (struct vw_ledger_score){.image_id = image_id, .method = "lasting_psnr", .value = value, .unit = "dB"};
}

static struct vw_ledger_score worth(uint32_t image_id, double ci_high) {
    return (struct vw_ledger_score){.image_id = image_id, .method = "worth_psnr", .ci_low = -1, .ci_high = ci_high};
}

// Alice's photos are 1 and 6, bob's 2 and 5; the lowest is nobody's, 3.
TEST(a_payout_is_split_by_lasting_credit) {
    enum { PHOTOS = 4, SCORES = 7 };
    static const struct {
        const char *what;
        double values[5];          // lasting credit of photos 1, 2, 3, 5 and 6
        double ci_high[2];         // upper limits of the worth of photos 6 and 2
        uint64_t expected[PHOTOS]; // cents for photos 1, 6, 2 and 5
    } cases[] = {
        {"above the scene's lowest", {0.5, 0.25, -0.5, 0.25, -0.25}, {1, 1}, {5334, 1333, 1667, 1666}},
        {"a shift means nothing", {100.5, 100.25, 99.5, 100.25, 99.75}, {1, 1}, {5334, 1333, 1667, 1666}},
        {"what harms gets nothing", {0.5, 0.25, -0.5, 0.25, -0.25}, {-0.1, -0.1}, {6667, 0, 0, 3333}},
        {"the lowest gets nothing", {0.5, 0.25, 0, 0, -0.5}, {1, 1}, {6667, 0, 2000, 1333}},
        {"all equal", {1, 1, 1, 1, 1}, {1, 1}, {3334, 3333, 1667, 1666}},
    };
    const struct vw_provider_score groups[] = {{.provider = "alice"}, {.provider = "bob"}};
    const struct vw_payout payouts[] = {{.group = &groups[0], .cents = 6667}, {.group = &groups[1], .cents = 3333}};
    struct vw_photo_payout *photos = NULL;
    uint32_t count = 0;
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const double *values = cases[i].values;
        const struct vw_ledger_score all[SCORES] = {
            lasting(1, values[0]), lasting(2, values[1]),         lasting(3, values[2]),        lasting(5, values[3]),
            lasting(6, values[4]), worth(6, cases[i].ci_high[0]), worth(2, cases[i].ci_high[1])};
        const struct vw_payout_scores of_run = {all, SCORES, test_images, TEST_IMAGE_COUNT};
        ASSERT_OK(vw_payout_split(payouts, 2, &of_run, &photos, &count));
        assert_int_equal(count, PHOTOS);
        static const uint32_t ids[PHOTOS] = {1, 6, 2, 5};
        for (uint32_t p = 0; p < PHOTOS; p++) {
            assert_true(photos[p].payout == &payouts[p / 2] && photos[p].image->image_id == ids[p]);
            if (photos[p].cents != cases[i].expected[p])
                fail_msg("%s: photo %u gets %llu cents, not %llu", cases[i].what, ids[p],
                         (unsigned long long)photos[p].cents, (unsigned long long)cases[i].expected[p]);
        }
        assert_near(photos[0].share + photos[1].share, 1, 1e-15);
        free(photos);
    }
    const struct vw_payout_scores none = {scores, VW_ARRAY_COUNT(scores), test_images, TEST_IMAGE_COUNT};
    ASSERT_OK(vw_payout_split(payouts, 2, &none, &photos, &count));
    assert_int_equal(count, 0); // no lasting credit
    free(photos);
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
