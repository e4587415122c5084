// Truncation and the end of TMC Data Shapley, on games of many photos.
#include "support/cmocka_test.h"

#include "lab/methods/registry.h"

enum { PHOTOS = 24, ENOUGH = 3, EPOCHS = 10 };
static uint32_t photos[PHOTOS];

// Any three photos do as well as all, but for `slope_db` of each.
struct game {
    double slope_db;
    double untrained_db;
    uint32_t made, largest;
    uint64_t last_seed;
};

static enum vw_status play(void *context, const struct vw_retrain_params *retrainings, uint32_t count,
                           struct vw_retrain_result *results) {
    struct game *game = context;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t size = retrainings[i].view_count;
        game->made += size > 0;
        if (retrainings[i].seed > game->last_seed) game->last_seed = retrainings[i].seed;
        if (game->made > PHOTOS && size > game->largest) game->largest = size;
        results[i].val_psnr = game->untrained_db + (size < ENOUGH ? size : ENOUGH) * 2.0 + game->slope_db * size;
    }
    return VW_OK;
}

static struct vw_retraining_cost score(struct game *game, uint32_t budget, double *scores) {
    const struct vw_retraining_input input = {.photos = photos,
                                              .photo_count = PHOTOS,
                                              .retrain = play,
                                              .context = game,
                                              .first_seed = 1,
                                              .key = 3,
                                              .budget = budget,
                                              .epochs = EPOCHS};
    struct vw_retraining_cost cost;
    for (uint32_t i = 0; i < PHOTOS; i++) photos[i] = i;
    ASSERT_OK(vw_retraining_method_score(&vw_tmc_shapley, &input, scores, &cost));
    return cost;
}

static double sum_of(const double *scores) {
    double sum = 0;
    for (uint32_t i = 0; i < PHOTOS; i++) sum += scores[i];
    return sum;
}

// Sizes 3 to 8 are as good as all: six in a row, in the first group of 16. The first order is whole, the others end
// there.
TEST(orders_end_where_photos_change_nothing) {
    struct game game = {.untrained_db = -1}; // PSNR crosses zero
    double scores[PHOTOS];
    struct vw_retraining_cost cost = score(&game, PHOTOS + 16 * 10, scores);
    assert_int_equal(game.made, PHOTOS + 16 * 10);
    assert_int_equal(game.largest, 16);
    assert_int_equal(game.last_seed, 11); // one of each order
    assert_true(cost.run_equivalents == PHOTOS + 16 * 10);
    assert_true(fabs(sum_of(scores) - 3 * 2.0) < 1e-9); // eleven orders, each shared out among all photos
}

// Within the tolerance at the end alone: with a slope of 0.03 dB sizes 21 to 24 are near all, four in a row.
TEST(orders_that_still_change_are_whole) {
    struct game game = {.slope_db = 0.03, .untrained_db = 8};
    double scores[PHOTOS];
    score(&game, 2 * PHOTOS, scores);
    assert_int_equal(game.largest, PHOTOS);
    assert_true(fabs(sum_of(scores) - 6 - 0.03 * PHOTOS) < 1e-9);
}

// Only the photos that an order reached before the budget ended count.
TEST(an_order_without_budget_counts_as_far_as_it_went) {
    struct game game = {.slope_db = 1, .untrained_db = 8};
    double once[PHOTOS], more[PHOTOS];
    uint32_t changed = 0;
    score(&game, PHOTOS, once);
    score(&game, PHOTOS + 5, more);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        assert_true(fabs(once[i] - 1) < 1e-9 || fabs(once[i] - 3) < 1e-9);
        changed += fabs(more[i] - once[i]) > 1e-9;
    }
    assert_in_range(changed, 1, 5);
    assert_int_equal(game.made, 2 * PHOTOS + 5);
}

// If every order says the same, 100 of them are enough.
TEST(settled_scores_end_it) {
    struct game game = {.slope_db = 1, .untrained_db = 8};
    double scores[PHOTOS];
    struct vw_retraining_cost cost = score(&game, 1000 * PHOTOS, scores);
    assert_true(cost.run_equivalents >= 100 * PHOTOS && cost.run_equivalents < 500 * PHOTOS);
    for (uint32_t i = 0; i < PHOTOS; i++) assert_true(fabs(scores[i] - 1.25) < 0.4); // 1 + 3 * 2 / 24
}
