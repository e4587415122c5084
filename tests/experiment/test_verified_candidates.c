// The candidate lists of a verified selection: rules on given scores, equal lists, lists that are too short.
#include "support/ledger_fixture.h"

#include "experiment/verified_candidates.h"

enum { PHOTOS = 10 };
static struct vw_ledger_image images[PHOTOS];
static struct vw_ledger_score rows[VW_SCORINGS][2 * PHOTOS];

// Makes scorings by which photo 3 is an outlier in half A, photo 4 in half B, photo 3 in both. All intervals hold zero.
static struct vw_scorings make_scorings(uint32_t method_count) {
    static const uint32_t outliers[VW_SCORINGS] = {3, 4, 3};
    struct vw_scorings scorings = {.images = images, .image_count = PHOTOS};
    for (uint32_t i = 0; i < PHOTOS; i++) images[i] = (struct vw_ledger_image){i, "photo", "train", NULL, HEX_A, NULL};
    for (int s = 0; s < VW_SCORINGS; s++) {
        for (uint32_t i = 0; i < 2 * PHOTOS; i++) {
            double value = i < PHOTOS ? 1 + 0.1 * i : 0.5 - 0.01 * i;
            if (i == outliers[s]) value = -20;
            rows[s][i] = (struct vw_ledger_score){
                i % PHOTOS, i < PHOTOS ? "dv_psnr" : "quality", value, "", 0, 4, value - 50, value + 50, 0, 0};
        }
        scorings.scores[s] = rows[s];
        scorings.score_counts[s] = method_count * PHOTOS;
    }
    return scorings;
}

static void check_names(const struct vw_candidates *candidates, const char *expected) {
    char text[512] = "";
    for (uint32_t c = 0; c < candidates->count; c++) {
        const struct vw_candidate *candidate = &candidates->list[c];
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s %u%s%s", c ? "; " : "", candidate->name,
                 candidate->selections[VW_HALF_BOTH].count, candidate->same_as ? " = " : "",
                 candidate->same_as ? candidate->same_as : "");
    }
    assert_string_equal(text, expected);
}

static bool keeps(const struct vw_selection *selection, uint32_t image_id) {
    for (uint32_t i = 0; i < selection->count; i++)
        if (selection->image_ids[i] == image_id) return true;
    return false;
}

TEST(rules_apply_to_the_scores_of_each_half) {
    struct vw_candidates candidates;
    struct vw_scorings scorings = make_scorings(2);
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    check_names(&candidates, "all 10 = without-outliers, without-outliers:quality, not-harmful; "
                             "without-outliers:dv_psnr 9 = positive, top:90%:dv_psnr; top:75%:dv_psnr 8; "
                             "top:50%:dv_psnr 5; top:90%:quality 9; top:75%:quality 8; top:50%:quality 5");
    const struct vw_selection *lists = candidates.list[1].selections;
    assert_true(!keeps(&lists[VW_HALF_A], 3) && keeps(&lists[VW_HALF_A], 4));
    assert_true(keeps(&lists[VW_HALF_B], 3) && !keeps(&lists[VW_HALF_B], 4));
    assert_true(!keeps(&lists[VW_HALF_BOTH], 3) && keeps(&lists[VW_HALF_BOTH], 4));
    vw_candidates_free(&candidates);
    assert_int_equal(candidates.count, 0);
    vw_candidates_free(&candidates);
}

TEST(a_method_without_scores_has_no_candidates) {
    AUTO(vw_candidates_free) struct vw_candidates candidates;
    struct vw_scorings scorings = make_scorings(1);
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    check_names(&candidates,
                "all 10 = without-outliers, not-harmful; without-outliers:dv_psnr 9 = positive, top:90%:dv_psnr; "
                "top:75%:dv_psnr 8; top:50%:dv_psnr 5");
}

TEST(lasting_credit_selects_where_every_scoring_has_it) {
    struct vw_candidates candidates;
    struct vw_scorings scorings = make_scorings(2);
    for (int s = 0; s < VW_SCORINGS; s++)
        for (uint32_t i = PHOTOS; i < 2 * PHOTOS; i++) rows[s][i].method = "lasting_psnr";
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    check_names(&candidates,
                "all 10 = without-outliers, not-harmful, without-outliers:lasting_psnr; without-outliers:dv_psnr 9 = "
                "positive, top:90%:dv_psnr; top:75%:dv_psnr 8; top:50%:dv_psnr 5; top:90%:lasting_psnr 9; "
                "top:75%:lasting_psnr 8; top:50%:lasting_psnr 5");
    vw_candidates_free(&candidates);
    scorings.score_counts[VW_HALF_B] = PHOTOS; // a sweep of all validation photos together
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    for (uint32_t c = 0; c < candidates.count; c++) assert_string_not_equal(candidates.list[c].method, "lasting_psnr");
    vw_candidates_free(&candidates);
}

// Lists that agree by both halves but not by all photos are two.
TEST(lists_that_differ_by_one_scoring_are_two) {
    AUTO(vw_candidates_free) struct vw_candidates candidates;
    struct vw_scorings scorings = make_scorings(1);
    rows[VW_HALF_BOTH][5].value = -1; // not positive, but no outlier
    rows[VW_HALF_BOTH][3].value = 1;
    for (uint32_t i = 6; i < PHOTOS; i++) rows[VW_HALF_BOTH][i].value = 2 * i;
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    assert_string_equal(candidates.list[1].name, "without-outliers:dv_psnr");
    assert_null(candidates.list[1].same_as);
    assert_int_equal(candidates.list[1].selections[VW_HALF_BOTH].count, 10);
    assert_string_equal(candidates.list[2].name, "positive");
}

TEST(a_rule_that_keeps_too_few_by_a_half_is_left_out) {
    struct vw_candidates candidates;
    struct vw_scorings scorings = make_scorings(1);
    for (uint32_t i = 1; i < PHOTOS; i++) rows[VW_HALF_B][i].value = -rows[VW_HALF_B][i].value; // photo 0 and 4 stay
    rows[VW_HALF_B][4].value = -3;
    ASSERT_OK(vw_candidates_make(&scorings, NULL, NULL, &candidates));
    for (uint32_t c = 0; c < candidates.count; c++) {
        assert_string_not_equal(candidates.list[c].name, "positive");
        if (candidates.list[c].same_as) assert_null(strstr(candidates.list[c].same_as, "positive"));
    }
    vw_candidates_free(&candidates);
    scorings.score_counts[VW_HALF_A] = 0;
    ASSERT_FAILS(vw_candidates_make(&scorings, NULL, NULL, &candidates), VW_ERROR_INPUT,
                 "no scores; value the photos first");
    vw_candidates_free(&candidates);
}
