// Advice: which photos can be left out, which are irreplaceable, which need a look, on what that rests, and why.
#include "support/ledger_fixture.h"

#include "report/advice.h"

enum { PHOTOS = 12, SCORES_MOST = 4 * PHOTOS };

struct fixture {
    struct vw_ledger_image images[PHOTOS];
    struct vw_ledger_score scores[SCORES_MOST];
    uint32_t score_count;
};

// Makes photos of which photo i has dv_psnr i / 10; none stands out.
static struct fixture make(void) {
    struct fixture fixture = {0};
    for (uint32_t i = 0; i < PHOTOS; i++)
        fixture.images[i] = (struct vw_ledger_image){10 + i, "photo", "train", NULL, HEX_A, NULL};
    for (uint32_t i = 0; i < PHOTOS; i++)
        fixture.scores[fixture.score_count++] =
            (struct vw_ledger_score){10 + i, "dv_psnr", i / 10.0, "dB", 0, 3, NAN, NAN, 0, 0};
    return fixture;
}

static void free_advice(struct vw_advice *advice) { free(advice->photos); }

static struct vw_ledger_score *add(struct fixture *fixture, uint32_t photo, const char *method, double value,
                                   double half_width) {
    struct vw_ledger_score *score = &fixture->scores[fixture->score_count++];
    *score =
        (struct vw_ledger_score){10 + photo, method, value, "dB", 0, 3, value - half_width, value + half_width, 0, 0};
    return score;
}

// Returns the photos with a mark, as bits.
static uint32_t marked(const struct vw_advice *advice, enum vw_advice_mark mark) {
    uint32_t bits = 0;
    for (uint32_t i = 0; i < advice->count; i++) bits |= advice->photos[i].marks & mark ? 1u << i : 0;
    return bits;
}

static struct vw_advice advise_by(const struct fixture *fixture, double accuracy_ci_low, double noise_db,
                                  double psnr_db) {
    struct vw_results results = {
        .input = {.images = fixture->images, .image_count = PHOTOS},
        .scores = fixture->scores,
        .score_count = fixture->score_count,
        .reconstruction = {.psnr_db = psnr_db, .ssim = 0.6, .mean_colour_db = 10, .nearest_photo_db = 12},
        .worth = {.claim_count = 1, .noise_db = noise_db}};
    results.worth.claims[0].accuracy.ci_low = accuracy_ci_low;
    ASSERT_OK(vw_results_advise(&results));
    return results.advice;
}

static struct vw_advice advise(const struct fixture *fixture, double accuracy_ci_low, double noise_db) {
    return advise_by(fixture, accuracy_ci_low, noise_db, 16);
}

TEST(credit_alone_says_where_to_look) {
    struct fixture fixture = make();
    fixture.scores[2].value = fixture.scores[5].value = -20;
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "train_fit", i == 2 ? 10 : 20 + i % 3, 0);
    add(&fixture, 6, "quality", 0, 0); // a rank alone accuses nobody
    AUTO(free_advice) struct vw_advice advice = advise(&fixture, 0.5, 1);
    assert_null(advice.basis);
    assert_int_equal(marked(&advice, VW_MARK_LOOK), 1u << 2);
    assert_int_equal(marked(&advice, VW_MARK_LONE), 1u << 5); // as low, but it fits
    assert_int_equal(marked(&advice, VW_MARK_REMOVABLE) | marked(&advice, VW_MARK_IRREPLACEABLE), 0);
}

TEST(a_coarse_reconstruction_says_only_where_to_look) {
    struct fixture fixture = make();
    fixture.scores[2].value = -20;
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "train_fit", i == 2 ? 10 : 20 + i % 3, 0);
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, vw_worth_method, i - 6.0, 0.1);
    for (int coarse = 0; coarse < 2; coarse++) {
        AUTO(free_advice)
        struct vw_advice advice = advise_by(&fixture, 0.5, 1, coarse ? 13 : 16);
        uint32_t judged = marked(&advice, VW_MARK_REMOVABLE) | marked(&advice, VW_MARK_IRREPLACEABLE);
        assert_int_equal(judged == 0, coarse);
        assert_int_equal(marked(&advice, VW_MARK_LOOK), 1u << 2);
    }
}

TEST(lasting_credit_advises_by_order) {
    struct fixture fixture = make();
    fixture.scores[1].value = fixture.scores[2].value = -20; // neither an outlier nor a lone view is called removable
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "train_fit", i == 1 ? 10 : 20 + i % 3, 0);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        struct vw_ledger_score *score =
            add(&fixture, i, "lasting_psnr", i - 100.0, 1); // all below 0, which means nothing
        uint32_t rank = PHOTOS - i;
        if (i == 0 || i == 11) continue; // known without an interval
        score->rank_ci_low = rank > 2 ? rank - 2 : 1;
        score->rank_ci_high = rank + 1;
    }
    AUTO(free_advice) struct vw_advice advice = advise(&fixture, NAN, NAN);
    assert_string_equal(advice.basis, "lasting_psnr");
    assert_true(advice.by_order);
    assert_int_equal(marked(&advice, VW_MARK_REMOVABLE), 1u << 0 | 1u << 3);       // ranks 12, 9: from 7 on
    assert_int_equal(marked(&advice, VW_MARK_IRREPLACEABLE), 1u << 11 | 1u << 10); // up to rank 3 of 12
    assert_int_equal(marked(&advice, VW_MARK_LOOK), 1u << 1);
}

// Worths -0.5, -0.4, ... 0.6, whose median is 0.05, known to 0.25; the last one hardly.
static struct fixture make_worths(void) {
    struct fixture fixture = make();
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "lasting_psnr", -(double)i, 1);
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "worth_psnr", (i - 5.0) / 10, i == 11 ? 2 : 0.25);
    return fixture;
}

TEST(worth_advises_by_its_intervals) {
    struct fixture fixture = make_worths();
    AUTO(free_advice) struct vw_advice advice = advise(&fixture, 0.1, 0.01);
    assert_string_equal(advice.basis, "worth_psnr");
    assert_false(advice.by_order);
    assert_true(advice.tested);
    assert_int_equal(marked(&advice, VW_MARK_REMOVABLE), 7);            // up to -0.3, which ends at -0.05
    assert_int_equal(marked(&advice, VW_MARK_IRREPLACEABLE), 1u << 10); // the better-known of the best two
}

static uint32_t removable(const struct fixture *fixture, double noise_db) {
    AUTO(free_advice) struct vw_advice advice = advise(fixture, 0.1, noise_db);
    uint32_t bits = marked(&advice, VW_MARK_REMOVABLE);
    return bits;
}

TEST(noise_and_the_median_bound_what_is_removable) {
    struct fixture fixture = make();
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "worth_psnr", (i + 1) / 10.0, 0.05); // median 0.65
    assert_int_equal(removable(&fixture, 0.2), 1);   // ends at 0.15, the next at 0.25
    assert_int_equal(removable(&fixture, 10), 0x1f); // ends below the median: 0.15 to 0.55
    assert_int_equal(removable(&fixture, NAN), 0);   // one training on all photos or none: its noise is unknown
    for (uint32_t i = PHOTOS; i < fixture.score_count; i++) fixture.scores[i].ci_high = 3;
    assert_int_equal(removable(&fixture, 10), 0); // wide intervals
    for (uint32_t i = PHOTOS; i < fixture.score_count; i++) fixture.scores[i].value = fixture.scores[i].ci_high = -1;
    assert_int_equal(removable(&fixture, NAN), 0xfff); // all harm
}

TEST(worth_that_is_not_shown_to_predict_marks_nothing) {
    struct fixture fixture = make_worths();
    const double unshown[] = {0, -0.1, NAN};
    for (size_t i = 0; i < VW_ARRAY_COUNT(unshown); i++) {
        AUTO(free_advice) struct vw_advice advice = advise(&fixture, unshown[i], 0.01);
        assert_string_equal(advice.basis, "worth_psnr");
        assert_false(advice.tested);
        assert_int_equal(marked(&advice, VW_MARK_REMOVABLE) | marked(&advice, VW_MARK_IRREPLACEABLE), 0);
    }
}

// ---- Reasons --------------------------------------------------------------------------------------------------------

// Advises where photos 2 and 3 fit badly and have low credit, photo 8 is a lone view, and photo 6 helps.
static struct vw_advice advise_with(const char *const *words) {
    struct fixture fixture = make();
    struct vw_photo_finding findings[PHOTOS];
    struct vw_results results = {.input = {.images = fixture.images, .image_count = PHOTOS},
                                 .scores = fixture.scores,
                                 .findings = words ? findings : NULL,
                                 .reconstruction = vw_reconstruction_unknown};
    for (uint32_t i = 0; words && i < PHOTOS; i++) {
        findings[i] = vw_photo_finding_unknown;
        findings[i].word = words[i];
        snprintf(findings[i].description, sizeof findings[i].description, "says %u", i);
    }
    fixture.scores[2].value = fixture.scores[3].value = fixture.scores[8].value = -20;
    fixture.scores[6].ci_low = 0.5, fixture.scores[6].ci_high = 0.7;
    for (uint32_t i = 0; i < PHOTOS; i++) add(&fixture, i, "train_fit", i == 2 || i == 3 ? 10 : 20 + i % 3, 0);
    results.score_count = fixture.score_count;
    results.agreement.other_views_low = 1;
    ASSERT_OK(vw_results_advise(&results));
    for (uint32_t i = 0; i < results.advice.count; i++) { // the fixture ends here
        struct vw_photo_advice *photo = &results.advice.photos[i];
        photo->image = NULL, photo->score = NULL, photo->finding = NULL;
        photo->description = photo->description ? "told" : NULL;
    }
    return results.advice;
}

TEST(a_defect_is_looked_at_whatever_the_credit) {
    static const char *const words[PHOTOS] = {[2] = "blur", [5] = "noise", [6] = "pose", [8] = "occluder"};
    AUTO(free_advice) struct vw_advice advice = advise_with(words);
    const struct vw_photo_advice *photos = advice.photos;
    assert_string_equal(photos[1].word, "unclear");
    assert_string_equal(photos[1].reason, "within noise");
    for (uint32_t i = 0; i < PHOTOS; i++) {
        if (!words[i]) continue;
        assert_int_equal(photos[i].advice, VW_ADVICE_LOOK); // though 6 helps, and 8 is a lone view
        assert_string_equal(photos[i].reason, words[i]);
        assert_string_equal(photos[i].description, "told");
    }
    assert_int_equal(photos[3].advice, VW_ADVICE_LOOK);
    assert_string_equal(photos[3].reason, "fits badly");
    assert_null(photos[3].description);
    assert_true(photos[3].train_fit == 10);
}

TEST(sound_photos_are_advised_by_credit) {
    AUTO(free_advice) struct vw_advice advice = advise_with(NULL);
    assert_string_equal(advice.photos[1].reason, "within noise");
    assert_string_equal(advice.photos[2].reason, "fits badly");
    assert_string_equal(advice.photos[6].reason, "helps");
    assert_string_equal(advice.photos[8].reason, "lone view");
}

// Credit beyond noise is for the validation photos: it keeps a photo only if others would agree.
TEST(credit_keeps_photos_where_others_would_agree) {
    static const struct {
        double value, agreement_low;
        enum vw_advice_word advice;
        const char *reason;
    } cases[] = {{1, 0.31, VW_ADVICE_KEEP, "helps"},
                 {1, 0.29, VW_ADVICE_UNCLEAR, "other views may differ"},
                 {-1, 0.31, VW_ADVICE_UNCLEAR, "negative credit"},
                 {-1, 0.29, VW_ADVICE_UNCLEAR, "other views may differ"},
                 {0.1, 0.29, VW_ADVICE_UNCLEAR, "within noise"}};
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        struct fixture fixture = make();
        fixture.scores[6].value = cases[i].value;
        fixture.scores[6].ci_low = cases[i].value - 0.5;
        fixture.scores[6].ci_high = cases[i].value + 0.5;
        struct vw_results results = {.input = {.images = fixture.images, .image_count = PHOTOS},
                                     .scores = fixture.scores,
                                     .score_count = fixture.score_count,
                                     .reconstruction = vw_reconstruction_unknown,
                                     .agreement = {.view_count = 7, .other_views_low = cases[i].agreement_low}};
        ASSERT_OK(vw_results_advise(&results));
        if (results.advice.photos[6].advice != cases[i].advice) fail_msg("case %zu", i);
        assert_string_equal(results.advice.photos[6].reason, cases[i].reason);
        free_advice(&results.advice);
    }
}

TEST(photos_that_judge_get_no_advice) {
    struct fixture fixture = make();
    fixture.images[4].split = "val";
    AUTO(free_advice) struct vw_advice advice = advise(&fixture, 0.5, 1);
    assert_int_equal(advice.count, PHOTOS - 1);
    const struct vw_rows rows = vw_advice_rows(&advice);
    struct vw_csv_text table = {0};
    ASSERT_OK(vw_rows_make_csv("advice.csv", &rows, &table));
    static const char first[] = "name,advice,reason,score,ci_low,ci_high,unit,method,description,in_place,"
                                "hidden_share,turned_deg,stops,sharpness,noise,covered_share,train_fit,quality\n"
                                "photo,unclear,within noise,0,,,dB,dv_psnr,,,,,,,,,,\n";
    assert_memory_equal(table.text, first, strlen(first));
    free(table.text);
}

TEST(no_scores_no_advice) {
    AUTO(vw_results_free) struct vw_results results = {.reconstruction = vw_reconstruction_unknown};
    ASSERT_OK(vw_results_advise(&results));
    assert_null(results.advice.basis);
    assert_int_equal(results.advice.count, 0);
}
