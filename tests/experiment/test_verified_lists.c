// The list lists of a verified selection: rules on given scores, equal lists, lists that are too short, lone
// views, and lists without scores.
#include "support/ledger_fixture.h"

#include "experiment/verified_selection.h"

enum { PHOTOS = 10 };
#define CONTROLS "thinned:90% 9; thinned:75% 8; random:90% 9; random:75% 8"
static struct vw_ledger_image images[PHOTOS];
static struct vw_ledger_score rows[VW_SCORINGS][3 * PHOTOS];

// Makes scorings by which photo 3 is an outlier in half A, photo 4 in half B, photo 3 in both. All intervals hold zero.
static struct vw_scorings make_scorings(uint32_t method_count) {
    static const uint32_t outliers[VW_SCORINGS] = {3, 4, 3};
    struct vw_scorings scorings = {.images = images, .image_count = PHOTOS};
    static char names[PHOTOS][8];
    for (uint32_t i = 0; i < PHOTOS; i++) {
        snprintf(names[i], sizeof names[i], "photo%u", (PHOTOS - 1 - i)); // the last by name is the first one
        images[i] = (struct vw_ledger_image){i, names[i], "train", NULL, HEX_A, NULL};
    }
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

static void check_names(const struct vw_verified_lists *lists, const char *expected) {
    char text[512] = "";
    for (uint32_t c = 0; c < lists->count; c++) {
        const struct vw_verified_list *list = &lists->of[c];
        snprintf(text + strlen(text), sizeof text - strlen(text), "%s%s %u%s%s", c ? "; " : "", list->name,
                 list->selections[VW_HALF_BOTH].count, list->same_as ? " = " : "", list->same_as ? list->same_as : "");
    }
    assert_string_equal(text, expected);
}

static bool keeps(const struct vw_selection *selection, uint32_t image_id) {
    for (uint32_t i = 0; i < selection->count; i++)
        if (selection->image_ids[i] == image_id) return true;
    return false;
}

TEST(rules_apply_to_the_scores_of_each_half) {
    struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(2);
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    check_names(&lists, "all 10 = without-outliers, not-harmful; positive 9 = top:90%:dv_psnr; top:75%:dv_psnr 8; "
                        "top:75%:quality 8; " CONTROLS);
    const struct vw_selection *made = lists.of[1].selections;
    assert_true(!keeps(&made[VW_HALF_A], 3) && keeps(&made[VW_HALF_A], 4));
    assert_true(keeps(&made[VW_HALF_B], 3) && !keeps(&made[VW_HALF_B], 4));
    assert_true(!keeps(&made[VW_HALF_BOTH], 3) && keeps(&made[VW_HALF_BOTH], 4));
    vw_verified_lists_free(&lists);
    assert_int_equal(lists.count, 0);
    vw_verified_lists_free(&lists);
}

TEST(a_method_without_scores_has_no_lists) {
    AUTO(vw_verified_lists_free) struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(1);
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    check_names(&lists, "all 10 = without-outliers, not-harmful; positive 9 = top:90%:dv_psnr; "
                        "top:75%:dv_psnr 8; " CONTROLS);
}

TEST(lasting_credit_selects_where_every_scoring_has_it) {
    struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(2);
    for (int s = 0; s < VW_SCORINGS; s++)
        for (uint32_t i = PHOTOS; i < 2 * PHOTOS; i++) rows[s][i].method = "lasting_psnr";
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    check_names(&lists, "all 10 = without-outliers, not-harmful; positive 9 = top:90%:dv_psnr; top:75%:dv_psnr 8; "
                        "top:90%:lasting_psnr 9; top:75%:lasting_psnr 8; " CONTROLS);
    vw_verified_lists_free(&lists);
    scorings.score_counts[VW_HALF_B] = PHOTOS; // a sweep of all validation photos together
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    for (uint32_t c = 0; c < lists.count; c++) assert_string_not_equal(lists.of[c].method, "lasting_psnr");
    vw_verified_lists_free(&lists);
}

// Lists that agree by both halves but not by all photos are two.
TEST(lists_that_differ_by_one_scoring_are_two) {
    AUTO(vw_verified_lists_free) struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(1);
    rows[VW_HALF_BOTH][3].value = 1; // positive keeps all photos by all validation photos
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    assert_string_equal(lists.of[1].name, "positive");
    assert_null(lists.of[1].same_as);
    assert_int_equal(lists.of[1].selections[VW_HALF_BOTH].count, 10);
    assert_string_equal(lists.of[2].name, "top:90%:dv_psnr");
}

TEST(a_rule_that_keeps_too_few_by_a_half_is_left_out) {
    struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(1);
    for (uint32_t i = 1; i < PHOTOS; i++) rows[VW_HALF_B][i].value = -rows[VW_HALF_B][i].value; // photo 0 and 4 stay
    rows[VW_HALF_B][4].value = -3;
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    for (uint32_t c = 0; c < lists.count; c++) {
        assert_string_not_equal(lists.of[c].name, "positive");
        if (lists.of[c].same_as) assert_null(strstr(lists.of[c].same_as, "positive"));
    }
    vw_verified_lists_free(&lists);
    scorings.score_counts[VW_HALF_A] = 0;
    ASSERT_FAILS(vw_verified_lists_make(&scorings, &lists), VW_ERROR_INPUT, "no scores; value the photos first");
    vw_verified_lists_free(&lists);
}

// The photo with the low credit fits as well as others do.
TEST(a_lone_view_is_left_out_by_no_score) {
    struct vw_verified_lists lists;
    struct vw_scorings scorings = make_scorings(3);
    for (int s = 0; s < VW_SCORINGS; s++)
        for (uint32_t i = 0; i < PHOTOS; i++) {
            rows[s][PHOTOS + i] = rows[s][i];
            rows[s][PHOTOS + i].method = "dv_loss";
            rows[s][2 * PHOTOS + i] = (struct vw_ledger_score){i, "train_fit", 20 + 0.1 * i, "", 0, 4, 0, 50, 0, 0};
        }
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    check_names(&lists,
                "all 10 = without-outliers, not-harmful, positive, top:90%:dv_psnr; top:75%:dv_psnr 9; " CONTROLS);
    assert_true(keeps(&lists.of[1].selections[VW_HALF_A], 3));
    assert_true(keeps(&lists.of[1].selections[VW_HALF_B], 4));
    assert_true(keeps(&lists.of[1].selections[VW_HALF_BOTH], 3));
    vw_verified_lists_free(&lists);
}

TEST(lists_without_scores_are_the_same_by_all_scorings) {
    struct vw_verified_lists lists, again;
    struct vw_scorings scorings = make_scorings(1);
    ASSERT_OK(vw_verified_lists_make(&scorings, &lists));
    scorings.seed = 1;
    ASSERT_OK(vw_verified_lists_make(&scorings, &again));
    uint32_t first = lists.count - 4, differ = 0;
    for (uint32_t c = first; c < lists.count; c++) {
        const struct vw_selection *made = lists.of[c].selections;
        for (int s = 1; s < VW_SCORINGS; s++)
            assert_memory_equal(made[s].image_ids, made[0].image_ids, made[0].count * sizeof *made[0].image_ids);
        assert_string_equal(lists.of[c].method, "none");
        differ += memcmp(again.of[c].selections[0].image_ids, made[0].image_ids,
                         made[0].count * sizeof *made[0].image_ids) != 0;
    }
    assert_int_equal(differ, 2); // the random ones, by another seed
    // Ten photos by name, which is the other way round: the third of each five is left out.
    const struct vw_selection *thinned = &lists.of[first + 1].selections[VW_HALF_BOTH];
    for (uint32_t i = 0; i < PHOTOS; i++) assert_int_equal(keeps(thinned, PHOTOS - 1 - i), i != 2 && i != 7);
    vw_verified_lists_free(&lists);
    vw_verified_lists_free(&again);
}
