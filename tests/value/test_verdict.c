// The verdict on a reconstruction, and its JSON.
#include "support/ledger_fixture.h"

#include "value/verdict.h"

static const struct vw_ranking_agreement agreement = {.epochs = 29, .view_count = 7, .better_training = 0.9};

static struct vw_reconstruction reconstruction(double psnr_db, double mean_colour_db, double nearest_photo_db) {
    return (struct vw_reconstruction){7, true, {120, 80}, {480, 320}, psnr_db, 0.8, mean_colour_db, nearest_photo_db};
}

TEST(the_gain_over_trivial_predictions_and_similarity_decide) {
    static const struct {
        double psnr_db, mean_colour_db, nearest_photo_db;
        enum vw_verdict verdict;
    } cases[] = {
        {15, 10, 13, VW_VERDICT_TOO_COARSE}, // 2 dB above the nearest photo
        {15, 13, 10, VW_VERDICT_TOO_COARSE}, // or above the mean colour
        {18, 12, 14, VW_VERDICT_USABLE},     {25, 12, 14, VW_VERDICT_GOOD},      {10, 12, 14, VW_VERDICT_TOO_COARSE},
        {NAN, 12, 14, VW_VERDICT_UNKNOWN},   {25, NAN, NAN, VW_VERDICT_UNKNOWN}, {25, NAN, 14, VW_VERDICT_GOOD},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        const struct vw_reconstruction seen =
            reconstruction(cases[i].psnr_db, cases[i].mean_colour_db, cases[i].nearest_photo_db);
        if (vw_verdict_judge(&seen) != cases[i].verdict) fail_msg("case %zu", i);
    }
    struct vw_reconstruction blurred = reconstruction(25, 12, 14);
    blurred.ssim = 0.69;
    assert_int_equal(vw_verdict_judge(&blurred), VW_VERDICT_USABLE);
    blurred.ssim = 0.49;
    assert_int_equal(vw_verdict_judge(&blurred), VW_VERDICT_TOO_COARSE);
    blurred.ssim = NAN;
    assert_int_equal(vw_verdict_judge(&blurred), VW_VERDICT_UNKNOWN);
}

TEST(a_reconstruction_is_read_as_it_was_written) {
    const struct vw_reconstruction seen = reconstruction(21.5, NAN, 14.25);
    struct vw_reconstruction read = {0};
    json_t *json = vw_reconstruction_to_json(&seen);
    assert_null(vw_reconstruction_from_json(json, &read));
    assert_true(read.psnr_db == 21.5 && isnan(read.mean_colour_db) && read.nearest_photo_db == 14.25);
    assert_true(read.view_count == 7 && read.of_test && read.ssim == 0.8);
    assert_true(read.trained_px[1] == 80 && read.measured_px[0] == 480 && read.measured_px[1] == 320);
    json_object_set_new(json, "ssim", json_string("high"));
    assert_string_equal(vw_reconstruction_from_json(json, &read), "ssim");
    json_object_set_new(json, "measured_px", json_pack("[i, i]", 480, -1));
    assert_string_equal(vw_reconstruction_from_json(json, &read), "measured_px");
    json_object_set_new(json, "split", json_string("train"));
    assert_string_equal(vw_reconstruction_from_json(json, &read), "split");
    json_object_set_new(json, "views", json_integer(-1));
    assert_string_equal(vw_reconstruction_from_json(json, &read), "views");
    json_decref(json);
    assert_non_null(vw_reconstruction_from_json(NULL, &read));
}

TEST(unknown_numbers_are_null) {
    json_t *json = vw_verdict_to_json(&vw_reconstruction_unknown, &agreement);
    assert_string_equal(json_string_value(json_object_get(json, "verdict")), "unknown");
    assert_true(json_is_null(json_object_get(json_object_get(json, "reconstruction"), "ssim")));
    assert_true(json_real_value(json_object_get(json_object_get(json, "ranking"), "better_training")) == 0.9);
    json_decref(json);
}
