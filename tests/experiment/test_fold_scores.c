// Scores over folds: means, errors and intervals by the formula of the header, and how photos are divided.

#include "support/cmocka_test.h"

#include "base/statistics.h"
#include "experiment/fold_scores.h"
#include "experiment/kfold.h"
#include "viewworth/scene.h"

static struct vw_ledger_score made_score(uint32_t image_id, const char *method, double value, double error) {
    return (struct vw_ledger_score){image_id,          method, value, "dB", error, 4, value - 3 * error,
                                    value + 3 * error, 0,      0};
}

// Photo 0 trains in folds 1 and 2, photo 1 in 0 and 2, photo 2 in 0 and 1.
TEST(test_pools_by_the_formula) {
    const struct vw_ledger_score first[] = {made_score(1, "dv_psnr", 2, 0.1), made_score(2, "dv_psnr", -1, 0.1)};
    const struct vw_ledger_score second[] = {made_score(0, "dv_psnr", 5, 0.1), made_score(2, "dv_psnr", -3, 4)};
    const struct vw_ledger_score third[] = {made_score(0, "dv_psnr", 5.5, 0.1), made_score(1, "dv_psnr", 3, 0.1)};
    const struct vw_fold_scores folds[] = {{first, 2}, {second, 2}, {third, 2}};
    AUTO_FREE struct vw_ledger_score *pooled = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_fold_scores_pool(folds, 3, &pooled, &count));
    assert_int_equal(count, 3);
    const double means[] = {5.25, 2.5, -2}, squares[] = {0.125, 0.5, 2}, own[] = {0.01, 0.01, (0.01 + 16) / 2};
    for (uint32_t i = 0; i < 3; i++) {
        double between = (squares[i] + 2 * 0.5) / 3; // the median of 0.125, 0.5 and 2 counts twice
        double error = sqrt(fmax(between, own[i]) / 2);
        assert_int_equal(pooled[i].image_id, i);
        assert_true(fabs(pooled[i].value - means[i]) < 1e-12);
        assert_true(fabs(pooled[i].standard_error - error) < 1e-12);
        assert_true(fabs(pooled[i].ci_high - means[i] - vw_student_quantile(3) * error) < 1e-12);
        assert_true(fabs(pooled[i].ci_low - means[i] + vw_student_quantile(3) * error) < 1e-12);
        assert_int_equal(pooled[i].visits, 8);
        assert_true(pooled[i].rank_ci_low >= 1 && pooled[i].rank_ci_high <= 3);
    }
    assert_int_equal(pooled[0].rank_ci_low, 1);
    // A longer training adds a variance of 0.45 (1.4826 * 2.75)^2 to each: 2.75 is too little then, 7.25 is not.
    assert_int_equal(pooled[0].rank_ci_high, 2);
    assert_int_equal(pooled[2].rank_ci_low, 2);
}

TEST(test_keeps_the_only_fold) {
    const struct vw_ledger_score first[] = {made_score(1, "dv_psnr", 2, 0.1), made_score(1, "dv_loss", 7, 0.2)};
    struct vw_ledger_score second[] = {made_score(0, "dv_psnr", 5, 0.3), made_score(1, "dv_psnr", 9, 0.3)};
    second[1].visits = 0; // no value
    const struct vw_fold_scores folds[] = {{first, 2}, {second, 2}};
    struct vw_ledger_score *pooled = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_fold_scores_pool(folds, 2, &pooled, &count));
    assert_int_equal(count, 3);
    assert_true(pooled[0].value == 5 && pooled[1].value == 2 && pooled[2].value == 7);
    assert_true(pooled[1].ci_low == first[0].ci_low && pooled[1].standard_error == 0.1 && pooled[1].visits == 4);
    assert_string_equal(pooled[2].method, "dv_loss");
    free(pooled);
    ASSERT_OK(vw_fold_scores_pool(folds, 0, &pooled, &count));
    assert_int_equal(count, 0);
    free(pooled);
}

enum { VIEWS = 11 };

static void make_scene(struct vw_view *views, struct vw_scene *scene, bool reversed) {
    static char names[VIEWS][8];
    *scene = (struct vw_scene){.views = views, .view_count = VIEWS};
    for (uint32_t i = 0; i < VIEWS; i++) {
        uint32_t place = reversed ? VIEWS - 1 - i : i;
        snprintf(names[i], sizeof names[i], "p%u", i);
        views[place] = (struct vw_view){.name = names[i], .split = i % 4};
    }
}

TEST(test_folds_partition_by_name) {
    struct vw_view views[VIEWS], turned_views[VIEWS];
    struct vw_scene scene, turned;
    uint32_t *fold_of = NULL, *turned_fold_of = NULL, *other_fold_of = NULL, sizes[3] = {0};
    make_scene(views, &scene, false);
    make_scene(turned_views, &turned, true);
    ASSERT_OK(vw_kfold_divide(&scene, 1, 3, &fold_of));
    ASSERT_OK(vw_kfold_divide(&turned, 1, 3, &turned_fold_of));
    ASSERT_OK(vw_kfold_divide(&scene, 2, 3, &other_fold_of));
    bool differs = false;
    for (uint32_t v = 0; v < VIEWS; v++) {
        bool divided = views[v].split == VW_SPLIT_TRAIN || views[v].split == VW_SPLIT_VAL;
        assert_int_equal(fold_of[v] == UINT32_MAX, !divided);
        assert_int_equal(fold_of[v], turned_fold_of[VIEWS - 1 - v]);
        if (divided) sizes[fold_of[v]]++;
        differs |= fold_of[v] != other_fold_of[v];
    }
    assert_true(sizes[0] == 2 && sizes[1] == 2 && sizes[2] == 2 &&
                differs); // 0 1 4 5 8 9 are train or validation photos
    free(fold_of);
    free(turned_fold_of);
    free(other_fold_of);
    assert_int_equal(vw_kfold_divide(&scene, 1, 7, &fold_of), VW_ERROR_USAGE);
}
