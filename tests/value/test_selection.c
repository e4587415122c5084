// The choice of photos by their scores: rules, ties, what is unknown, rounding, refusals.
#include "support/ledger_fixture.h"

#include "viewworth/selection.h"

// Photos 1, 2, 3, 5 and 6 train; see test_images.
static const struct vw_ledger_score scores[] = {
    {.image_id = 1, .method = "dv_psnr", .value = 0.25, .visits = 4, .ci_low = -1, .ci_high = 1.5},
    {.image_id = 2, .method = "dv_psnr", .value = 3, .visits = 4, .ci_low = 0.5, .ci_high = 5.5},
    {.image_id = 3, .method = "dv_psnr", .value = 0, .visits = 4, .ci_low = 0, .ci_high = 0},
    {.image_id = 5, .method = "dv_psnr", .value = 0.25, .visits = 4, .ci_low = 0.125, .ci_high = 0.375},
    {.image_id = 6, .method = "dv_psnr", .value = -7, .visits = 4, .ci_low = -9, .ci_high = -5},
    {.image_id = 1, .method = "dv_loss", .value = 1, .visits = 4, .ci_low = NAN, .ci_high = NAN},
    {.image_id = 2, .method = "dv_loss", .value = NAN, .visits = 4, .ci_low = 1, .ci_high = 2},
    {.image_id = 3, .method = "dv_loss", .value = 0, .visits = 0, .ci_low = 1, .ci_high = 1}, // never visited after
                                                                                              // burn-in
    {.image_id = 5, .method = "dv_loss", .value = 2, .visits = 1, .ci_low = NAN, .ci_high = NAN},
    {.image_id = 6, .method = "dv_loss", .value = -1, .visits = 4, .ci_low = NAN, .ci_high = NAN},
    {.image_id = 0, .method = "odd", .value = 9, .visits = 4, .ci_low = 8, .ci_high = 10}, // a validation photo
    {.image_id = 1, .method = "odd", .value = -1, .visits = 4, .ci_low = -2, .ci_high = -0.5},
    {.image_id = 4, .method = "validation_alone", .value = 9, .visits = 4, .ci_low = 8, .ci_high = 10},
};

#define SELECT(...) ((struct vw_selection_params){__VA_ARGS__})

static void check_chosen(struct vw_selection_params params, const char *expected, uint32_t scored_count) {
    struct vw_selection selection = {0};
    char text[64] = "";
    ASSERT_OK(vw_selection_make(scores, VW_ARRAY_COUNT(scores), test_images, TEST_IMAGE_COUNT, &params, &selection));
    for (uint32_t i = 0; i < selection.count; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%u", i > 0 ? " " : "", selection.image_ids[i]);
    if (strcmp(text, expected) != 0)
        fail_msg("rule %d, %g%s gives %s, not %s", params.rule, params.amount, params.percent ? " %" : "", text,
                 expected);
    assert_int_equal(selection.scored_count, scored_count);
    vw_selection_free(&selection);
    assert_null(selection.image_ids);
}

TEST(rules_choose_by_value_and_interval) {
    check_chosen(SELECT(.rule = VW_SELECT_POSITIVE), "2 1 5", 5); // a tie: by image; zero does not help
    check_chosen(SELECT(.rule = VW_SELECT_SIGNIFICANT), "2 5", 5);
    check_chosen(SELECT(.rule = VW_SELECT_NOT_HARMFUL), "2 1 5 3",
                 5); // an interval that ends at zero is not below it
    check_chosen(SELECT(.rule = VW_SELECT_TOP, .amount = 2), "2 1", 5);
    check_chosen(SELECT(.rule = VW_SELECT_TOP, .amount = 99), "2 1 5 3 6", 5);
    check_chosen(SELECT(.rule = VW_SELECT_DROP, .amount = 1), "2 1 5 3", 5);
    check_chosen(SELECT(.method = "dv_psnr", .rule = VW_SELECT_DROP, .amount = 4), "2", 5);
}

TEST(percentages_round_to_the_nearest_photo) {
    static const struct {
        double percent;
        const char *top, *drop; // photos chosen from five; NULL: refused
    } cases[] = {
        {0.001, "2", "2 1 5 3 6"}, {9.9, "2", "2 1 5 3 6"},  {10, "2", "2 1 5 3"}, {29.9, "2", "2 1 5 3"},
        {30, "2 1", "2 1 5"},      {60, "2 1 5", "2 1"},     {80, "2 1 5 3", "2"}, {89.9, "2 1 5 3", "2"},
        {90, "2 1 5 3 6", NULL},   {100, "2 1 5 3 6", NULL},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct vw_selection_params params = {.rule = VW_SELECT_TOP, .amount = cases[i].percent, .percent = true};
        check_chosen(params, cases[i].top, 5);
        params.rule = VW_SELECT_DROP;
        if (cases[i].drop) check_chosen(params, cases[i].drop, 5);
    }
}

TEST(what_is_unknown_is_never_chosen) {
    check_chosen(SELECT(.method = "dv_loss", .rule = VW_SELECT_POSITIVE), "5 1", 3);
    check_chosen(SELECT(.method = "dv_loss", .rule = VW_SELECT_NOT_HARMFUL), "5 1 6",
                 3); // none has an interval
    check_chosen(SELECT(.method = "dv_loss", .rule = VW_SELECT_TOP, .amount = 100, .percent = true), "5 1 6", 3);
    check_chosen(SELECT(.method = "dv_loss", .rule = VW_SELECT_DROP, .amount = 1), "5 1", 3);
    check_chosen(SELECT(.method = "odd", .rule = VW_SELECT_TOP, .amount = 5), "1", 1);
}

// Photos 0 to 8, the last of which validates. Medians 10 and spreads 1.4826, so that -3 is a score of 5.5522.
enum { PHOTOS = 9 };
#define ROW(method_name, id, score)                                                                                    \
    { .image_id = id, .method = method_name, .value = score, .visits = 4 }
#define ROWS(method, a, b, c, d, e, f, g, h)                                                                           \
    ROW(method, 0, a), ROW(method, 1, b), ROW(method, 2, c), ROW(method, 3, d), ROW(method, 4, e), ROW(method, 5, f),  \
        ROW(method, 6, g), ROW(method, 7, h)

static void check_without_outliers(const struct vw_ledger_score *rows, uint32_t row_count, const char *method,
                                   const char *expected, const char *expected_out) {
    struct vw_ledger_image photos[PHOTOS];
    struct vw_selection selection = {0};
    char kept[64] = "", out[256] = "";
    for (uint32_t i = 0; i < PHOTOS; i++)
        photos[i] = (struct vw_ledger_image){i, "photo", i == PHOTOS - 1 ? "val" : "train", "", NULL, NULL};
    const struct vw_selection_params params = {.method = method};
    ASSERT_OK(vw_selection_make(rows, row_count, photos, PHOTOS, &params, &selection));
    for (uint32_t i = 0; i < selection.count; i++)
        snprintf(kept + strlen(kept), sizeof kept - strlen(kept), "%s%u", i ? " " : "", selection.image_ids[i]);
    for (uint32_t i = 0; i < selection.outlier_count; i++)
        snprintf(out + strlen(out), sizeof out - strlen(out), "%s%s%u %s %.2f", i ? ", " : "",
                 selection.outliers[i].lone ? "lone " : "", selection.outliers[i].image_id,
                 selection.outliers[i].method, selection.outliers[i].z);
    assert_string_equal(kept, expected);
    assert_string_equal(out, expected_out);
    vw_selection_free(&selection);
    assert_null(selection.outliers);
}

TEST(outliers_of_a_score_are_left_out) {
    static const struct vw_ledger_score rows[] = {
        ROWS("dv_psnr", 9, 11, 9, 11, 10, 10, 5.5, 40), // 5.5: z = -3.04; high scores do not count as outliers
        ROWS("dv_loss", 9, 5.6, 10, 11, 11, 10, 2, 10), // 5.6: z = -2.97
        ROWS("quality", 9, 11, 1, 11, 10, NAN, 10, 10), // an unknown score is none
        {.image_id = 8, .method = "dv_psnr", .value = -99, .visits = 4}, // a validation photo
        ROWS("other", 0, 11, 9, 11, 9, 10, 10, 10),
    };
    const uint32_t count = VW_ARRAY_COUNT(rows);
    check_without_outliers(rows, count, "dv_psnr", "7 1 3 4 5 0 2", "6 dv_psnr -3.04");
    check_without_outliers(rows, count, "quality", "1 3 4 6 7 0 5", "2 quality -6.07"); // 5 has no score
    check_without_outliers(rows, count, "other", "1 3 5 6 7 2 4", "0 other -6.74");
    check_without_outliers(rows, count, NULL, "7 1 3 4 5 0 2 6", ""); // without training losses nobody is accused
}

// Every row: what a photo's own fit and its credits say together.
TEST(a_photo_is_an_outlier_only_by_its_own_fit_and_its_credit) {
    static const struct vw_ledger_score rows[] = {
        // 0: fits badly, and its credit is below the median. 1: as badly, but others gain by it. 2: low credit, and it
        // fits a little worse. 3: as low, but it fits. 4: low by one credit alone.
        ROWS("train_fit", 10, 10, 18.5, 21, 20, 20, 21, 20),
        ROWS("dv_psnr", 9, 12, -30, -30, -30, 10, 11, 10),
        ROWS("dv_loss", 11, 12, -30, -30, 10, 9, 11, 10),
    };
    const uint32_t count = VW_ARRAY_COUNT(rows);
    check_without_outliers(rows, count, NULL, "1 6 5 7 3 4",
                           "0 train_fit -6.74, 0 dv_psnr -0.17, 0 dv_loss 0.67, 2 train_fit -1.01, 2 dv_psnr -13.32, "
                           "2 dv_loss -26.98, lone 3 train_fit 0.67, lone 3 dv_psnr -13.32, lone 3 dv_loss -26.98");
    check_without_outliers(rows + 8, count - 8, NULL, "1 6 5 7 0 2 3 4", "");
}

TEST(few_or_equal_scores_have_no_outlier) {
    static const struct vw_ledger_score equal[] = {ROWS("dv_psnr", 1, 1, 1, 1, 1, 1, 1, -9)};
    static const struct vw_ledger_score few[] = {ROW("dv_psnr", 0, 1), ROW("dv_psnr", 1, 2), ROW("dv_psnr", 2, 3),
                                                 ROW("dv_psnr", 3, -99)};
    check_without_outliers(equal, VW_ARRAY_COUNT(equal), NULL, "0 1 2 3 4 5 6 7", "");
    check_without_outliers(few, VW_ARRAY_COUNT(few), NULL, "2 1 0 3 4 5 6 7", "");
}

static void check_refused(const struct vw_ledger_score *rows, uint32_t count, struct vw_selection_params params,
                          enum vw_status expected, const char *said) {
    struct vw_selection selection = {.count = 77};
    enum vw_status status = vw_selection_make(rows, count, test_images, TEST_IMAGE_COUNT, &params, &selection);
    if (status != expected || !strstr(vw_error_message(), said))
        fail_msg("gave %d: %s, not %s", status, vw_error_message(), said);
    assert_int_equal(selection.count, 77); // untouched
}

TEST(refusals_say_what_is_missing) {
    const uint32_t count = VW_ARRAY_COUNT(scores);
    const struct vw_selection_params positive = {.rule = VW_SELECT_POSITIVE};
    check_refused(scores, 0, positive, VW_ERROR_INPUT, "no scores; value the photos first");
    check_refused(scores, count, SELECT(.method = "dv_pnsr"), VW_ERROR_USAGE,
                  "\"dv_pnsr\" has no scores; use one of: dv_psnr, dv_loss, odd, validation_alone");
    check_refused(scores, count, SELECT(.method = "odd", .rule = VW_SELECT_POSITIVE), VW_ERROR_INPUT,
                  "none of 1 scores is above zero");
    check_refused(scores, count, SELECT(.method = "dv_loss", .rule = VW_SELECT_SIGNIFICANT), VW_ERROR_INPUT,
                  "none of 3 scores has an interval above zero");
    check_refused(scores, count, SELECT(.method = "odd", .rule = VW_SELECT_NOT_HARMFUL), VW_ERROR_INPUT,
                  "the intervals of all 1 scores are below zero");
    check_refused(scores, count, SELECT(.method = "dv_pnsr", .rule = VW_SELECT_POSITIVE), VW_ERROR_USAGE,
                  "\"dv_pnsr\" has no scores");
    check_refused(scores, count, SELECT(.method = "validation_alone", .rule = VW_SELECT_POSITIVE), VW_ERROR_INPUT,
                  "no train photo has a score");
    check_refused(scores, count, SELECT(.method = "validation_alone", .rule = VW_SELECT_TOP, .amount = 1),
                  VW_ERROR_INPUT, "no train photo has a score");
    check_refused(scores, count, SELECT(.rule = VW_SELECT_DROP, .amount = 5), VW_ERROR_INPUT, "all 5 photos");
    const struct vw_ledger_score stray = {.image_id = 99, .method = "dv_psnr", .value = 1, .visits = 1};
    check_refused(&stray, 1, positive, VW_ERROR_INPUT, "image 99");
}

TEST(amounts_out_of_range_are_refused) {
    static const double photos[] = {0, -1, 0.5, 2.5, 5e9, INFINITY, NAN}, percentages[] = {0, -5, 100.1, INFINITY, NAN};
    for (int rule = VW_SELECT_TOP; rule <= VW_SELECT_DROP; rule++) {
        struct vw_selection_params params = {.rule = (enum vw_selection_rule)rule};
        for (size_t i = 0; i < VW_ARRAY_COUNT(photos); i++) {
            params.amount = photos[i];
            check_refused(scores, VW_ARRAY_COUNT(scores), params, VW_ERROR_USAGE, "cannot select by");
        }
        params.percent = true;
        for (size_t i = 0; i < VW_ARRAY_COUNT(percentages); i++) {
            params.amount = percentages[i];
            check_refused(scores, VW_ARRAY_COUNT(scores), params, VW_ERROR_USAGE, "cannot select by");
        }
    }
}

TEST(rules_are_read_whole) {
    static const struct {
        const char *text;
        enum vw_selection_rule rule;
        double amount;
        bool percent;
    } good[] = {{"without-outliers", VW_SELECT_OUTLIERS, 0, false},
                {"positive", VW_SELECT_POSITIVE, 0, false},
                {"significant", VW_SELECT_SIGNIFICANT, 0, false},
                {"not-harmful", VW_SELECT_NOT_HARMFUL, 0, false},
                {"top:3", VW_SELECT_TOP, 3, false},
                {"drop:25%", VW_SELECT_DROP, 25, true},
                {"top:2.5%", VW_SELECT_TOP, 2.5, true},
                {"drop:0", VW_SELECT_DROP, 0, false}}; // ranges are looked at later
    static const char *const bad[] = {"",         "top",    "top:",      "top:%",     "top: 3",   "top:3 ",
                                      "top:3 %",  "top:+3", "drop:-3",   "top:inf",   "top:nan%", "top:3%%",
                                      "drop:few", "top:.5", "positive:", "positives", "negative", "not-harmful:3"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(good); i++) {
        struct vw_selection_params params = {0};
        if (!vw_selection_read_rule(good[i].text, &params)) fail_msg("%s is not a rule", good[i].text);
        assert_int_equal(params.rule, good[i].rule);
        assert_true(params.amount == good[i].amount && params.percent == good[i].percent);
    }
    for (size_t i = 0; i < VW_ARRAY_COUNT(bad); i++)
        if (vw_selection_read_rule(bad[i], &(struct vw_selection_params){0})) fail_msg("\"%s\" is a rule", bad[i]);
}

// The zero of a rank means nothing.
TEST(ranks_are_not_compared_with_zero) {
    const struct vw_ledger_score ranks[] = {
        {.image_id = 1, .method = "quality", .value = 0.25, .visits = 4, .ci_low = 0.1, .ci_high = 0.4},
        {.image_id = 2, .method = "quality", .value = 0.75, .visits = 4, .ci_low = 0.6, .ci_high = 0.9},
    };
    const enum vw_selection_rule refused[] = {VW_SELECT_POSITIVE, VW_SELECT_SIGNIFICANT, VW_SELECT_NOT_HARMFUL};
    struct vw_selection selection = {0};
    struct vw_selection_params params = {.method = "quality", .rule = VW_SELECT_DROP, .amount = 1};
    ASSERT_OK(vw_selection_make(ranks, 2, test_images, TEST_IMAGE_COUNT, &params, &selection));
    assert_true(selection.count == 1 && selection.image_ids[0] == 2);
    vw_selection_free(&selection);
    for (size_t i = 0; i < VW_ARRAY_COUNT(refused); i++) {
        params.rule = refused[i];
        ASSERT_FAILS(vw_selection_make(ranks, 2, test_images, TEST_IMAGE_COUNT, &params, &selection), VW_ERROR_USAGE,
                     "\"quality\" has a zero that means nothing");
    }
}
