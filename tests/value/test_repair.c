// Repair curves of a ledger whose responses are known.
#include "support/ledger_fixture.h"

#include "value/repair.h"

enum { PHOTOS = 30, EPOCHS = 5, STEPS = PHOTOS * EPOCHS, PULSE_PLACE = 10, PULSE_STEPS = 8 };

// The change of PSNR by the step on photo 10, at that step and the next ones: exposure, which is repaired.
static const double response_db[PULSE_STEPS] = {-0.95, -0.28, -0.15, -0.12, -0.10, -0.08, -0.06, -0.05};
// In the epochs after burn-in; their mean is 1.
static const double scales[EPOCHS] = {9, 0.9, 1.1, 0.9, 1.1};

static double pulse(uint64_t step) { // `step` counts from 1
    uint64_t place = (step - 1) % PHOTOS, epoch = (step - 1) / PHOTOS;
    return place >= PULSE_PLACE && place < PULSE_PLACE + PULSE_STEPS ? scales[epoch] * response_db[place - PULSE_PLACE]
                                                                     : 0;
}

struct game {
    struct vw_ledger_image images[PHOTOS + 1];
    struct vw_step_record records[STEPS + 1];
    struct vw_value_input input;
};

// Makes a game with the same order of photos in every epoch and a trend that rises by the same amount at every step.
static void make_game(struct game *game) {
    *game = (struct game){0};
    for (uint32_t i = 0; i <= PHOTOS; i++)
        game->images[i] = (struct vw_ledger_image){i,    "photo", i < PHOTOS ? "train" : "val",
                                                   NULL, HEX_A,   i == 2 || i == PULSE_PLACE ? "exposure" : "clean"};
    game->records[0] = test_step(0, 0, VW_RECORD_UNTRAINED, 10);
    for (uint64_t step = 1; step <= STEPS; step++)
        game->records[step] = test_step(step, (uint32_t)((step - 1) / PHOTOS), (uint32_t)((step - 1) % PHOTOS),
                                        10 + 0.01 * (double)step + pulse(step));
    game->input = test_value_input(game->records, STEPS + 1);
    game->input.images = game->images;
    game->input.image_count = PHOTOS + 1;
}

static const double ROUNDING_DB = 1e-9;

TEST(test_curves_are_the_responses) {
    static const uint32_t horizons[] = {1, 2, 3, 5, 8, 12, 20, 30};
    struct game game;
    AUTO(vw_repair_curves_free) struct vw_repair_curves curves;
    make_game(&game);
    ASSERT_OK(vw_repair_curves_make(&game.input, &curves));
    assert_int_equal(curves.horizon_count, 8); // up to an epoch
    const struct vw_repair_curve *photo = &curves.photos[PULSE_PLACE], *next = &curves.photos[PULSE_PLACE + 1];
    for (uint32_t k = 0; k < 5; k++) { // within the epoch, where the mean over its steps is the trend alone
        uint32_t h = horizons[k];
        double expected = response_db[h - 1];
        assert_near(photo->excess_db[k], expected, ROUNDING_DB);
        assert_int_equal(photo->visits[k], 4);
        assert_near(photo->stderr_db[k], 0.1 * fabs(expected) * sqrt(4.0 / 3) / 2,
                    ROUNDING_DB); // scales 0.9, 1.1, 0.9, 1.1
        assert_near(next->excess_db[k], (h < PULSE_STEPS ? response_db[h] : 0) - response_db[0], ROUNDING_DB);
        assert_near(curves.photos[2].excess_db[k], 0, ROUNDING_DB); // far before the pulse
        assert_int_equal(curves.photos[PHOTOS].visits[k], 0);
        assert_true(isnan(curves.photos[PHOTOS].excess_db[k]));
    }
    for (uint32_t k = 0; k < 8; k++) assert_int_equal(curves.horizons[k], horizons[k]);
    assert_int_equal(curves.photos[PHOTOS - 1].visits[1], 3); // the run ends
}

TEST(test_kinds_are_means_of_photos) {
    struct game game;
    AUTO(vw_repair_curves_free) struct vw_repair_curves curves;
    make_game(&game);
    ASSERT_OK(vw_repair_curves_make(&game.input, &curves));
    assert_int_equal(curves.kind_count, 2);
    assert_string_equal(curves.kinds[0].ground_truth, "clean");
    assert_int_equal(curves.kinds[0].photo_count, PHOTOS - 2);
    const struct vw_repair_kind *kind = &curves.kinds[1];
    assert_string_equal(kind->ground_truth, "exposure");
    assert_int_equal(kind->photo_count, 2);
    assert_near(kind->curve.excess_db[0], response_db[0] / 2, ROUNDING_DB); // the other one changes nothing
    assert_near(kind->curve.stderr_db[0], curves.photos[PULSE_PLACE].stderr_db[0] / 2, ROUNDING_DB);
    assert_int_equal(kind->curve.visits[0], 8);
    double sum = (PHOTOS - 2) * curves.kinds[0].curve.excess_db[0] + 2 * kind->curve.excess_db[0];
    assert_near(sum, 0, ROUNDING_DB); // excesses of an epoch add up to nothing
}

TEST(test_unknown_values_are_left_out) {
    struct game game;
    struct vw_repair_curves curves;
    make_game(&game);
    game.records[2 * PHOTOS + 3].val_psnr = NAN; // after the step on photo 2, and before that on photo 3
    game.records[3 * PHOTOS + 5].view = 1000;    // on a photo that is not there
    for (uint32_t i = 0; i <= PHOTOS; i++) game.images[i].ground_truth = NULL;
    ASSERT_OK(vw_repair_curves_make(&game.input, &curves));
    assert_int_equal(curves.photos[2].visits[0], 3);
    assert_int_equal(curves.photos[3].visits[0], 3);
    assert_int_equal(curves.photos[3].visits[2], 3);
    assert_int_equal(curves.photos[4].visits[0], 3);
    assert_int_equal(curves.photos[1].visits[1], 3);
    assert_int_equal(curves.photos[1].visits[0], 4);
    assert_int_equal(curves.kind_count, 0);
    vw_repair_curves_free(&curves);
    game.input.burn_in_epochs = EPOCHS;
    ASSERT_OK(vw_repair_curves_make(&game.input, &curves));
    assert_int_equal(curves.horizon_count, 0);
    vw_repair_curves_free(&curves);
    game.input = (struct vw_value_input){0};
    ASSERT_OK(vw_repair_curves_make(&game.input, &curves));
    vw_repair_curves_free(&curves);
}
