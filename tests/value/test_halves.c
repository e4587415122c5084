// Halves of the validation photos: how they are split, and that the scores of a half are those of a run that has only
// its photos to validate.
#include "support/ledger_fixture.h"

#include "base/statistics.h"
#include "value/halves.h"

enum { PHOTOS = 6, VIEWS = 5, IMAGES = PHOTOS + VIEWS, EPOCHS = 6, STEPS = 1 + PHOTOS * EPOCHS, LOST_STEP = 20 };

static struct vw_ledger_image images[IMAGES];
static char names[IMAGES][16];

// Makes images of which every other one validates at first, and the rest train.
static void make_images(void) {
    for (uint32_t i = 0; i < IMAGES; i++) {
        snprintf(names[i], sizeof names[i], "photo %u", i);
        images[i] =
            (struct vw_ledger_image){i, names[i], i < 2 * VIEWS && i % 2 ? "val" : "train", NULL, HEX_A, NULL, 1};
    }
}

static uint32_t train_photo(uint32_t place) { return place < VIEWS ? 2 * place : IMAGES - 1; }

static struct vw_view_error error_of(uint32_t step, uint32_t view) {
    uint32_t words[4];
    vw_random_words(7, VW_RANDOM_RECIPE, step, view, 0, words);
    return (struct vw_view_error){0.01 + 0.05 * vw_random_unit(words[0]), 0.1 + 0.2 * vw_random_unit(words[1])};
}

// Returns the ledger of the run as the validation photos with `validates` make it. One step is lost: it was not finite.
static struct vw_ledger *record(const char *folder, const bool validates[IMAGES], struct vw_value_input *input) {
    static struct vw_view_error errors[STEPS][VIEWS];
    static struct vw_step_record records[STEPS];
    uint32_t views[VIEWS], view_count = 0;
    double sum = 0;
    for (uint32_t i = 0; i < IMAGES; i++) {
        if (validates[i]) views[view_count++] = i;
        sum += validates[i] ? images[i].weight : 0;
    }
    for (uint32_t t = 0; t < STEPS; t++) {
        struct vw_step_record *record = &records[t];
        *record = (struct vw_step_record){.step = t,
                                          .epoch = t ? (t - 1) / PHOTOS : 0,
                                          .view = t ? train_photo((t * 5) % PHOTOS) : VW_RECORD_UNTRAINED,
                                          .train_loss = t ? 0.1 + 0.01 * (t % 7) : NAN,
                                          .validated = true,
                                          .nonfinite = t == LOST_STEP,
                                          .views = errors[t],
                                          .view_count = view_count};
        double mse = 0;
        for (uint32_t v = 0; v < view_count; v++) {
            double share = images[views[v]].weight / sum;
            errors[t][v] = error_of(t, views[v]);
            record->val_psnr += share * vw_psnr_db(errors[t][v].mse);
            record->val_l1 += share * errors[t][v].l1;
            mse += share * errors[t][v].mse;
        }
        record->val_psnr_pooled = vw_psnr_db(mse);
        if (record->nonfinite) record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
    }
    AUTO_FREE char *path = vw_path_join(folder, "ledger.db");
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run row = test_run("{}");
    remove(path);
    ASSERT_OK(vw_ledger_create(path, &row, images, IMAGES, &ledger));
    ASSERT_OK(vw_ledger_append(ledger, records, STEPS, views));
    *input = (struct vw_value_input){
        .records = records, .record_count = STEPS, .burn_in_epochs = 1, .images = images, .image_count = IMAGES};
    return ledger;
}

static void check_half(const char *folder, const uint8_t *halves, uint8_t half) {
    bool all[IMAGES], of_half[IMAGES];
    struct vw_value_input input;
    AUTO_FREE struct vw_ledger_score *scores = NULL, *expected = NULL;
    uint32_t score_count = 0, expected_count = 0;
    for (uint32_t i = 0; i < IMAGES; i++) {
        all[i] = halves[i] != VW_HALF_NONE;
        of_half[i] = halves[i] == half;
    }
    struct vw_ledger *ledger = record(folder, all, &input);
    ASSERT_OK(vw_halves_score(ledger, &input, halves, half, &scores, &score_count));
    vw_ledger_close(&ledger);
    ledger = record(folder, of_half, &input);
    ASSERT_OK(vw_value_score(&input, &expected, &expected_count));
    vw_ledger_close(&ledger);
    assert_int_equal(score_count, expected_count);
    assert_true(score_count >= 2 * PHOTOS);
    for (uint32_t i = 0; i < score_count; i++) {
        assert_string_equal(scores[i].method, expected[i].method);
        assert_int_equal(scores[i].image_id, expected[i].image_id);
        assert_int_equal(scores[i].visits, expected[i].visits);
        assert_near(scores[i].value, expected[i].value, 1e-9); // rounding of sums
        if (!isnan(expected[i].ci_low)) assert_near(scores[i].ci_low, expected[i].ci_low, 1e-6);
    }
}

FOLDER_TEST(scores_of_a_half_are_weighted) {
    uint8_t halves[IMAGES];
    uint32_t sizes[VW_HALVES];
    make_images();
    for (uint32_t i = 1; i < 2 * VIEWS; i += 2) images[i].weight = i == 5 ? 0 : 0.5 + i;
    ASSERT_OK(vw_halves_split(images, IMAGES, 5, halves, sizes));
    for (uint8_t half = 0; half < VW_HALVES; half++) check_half(*state, halves, half);
}

FOLDER_TEST(scores_of_a_half_are_of_its_photos_alone) {
    uint8_t halves[IMAGES];
    uint32_t sizes[VW_HALVES];
    make_images();
    ASSERT_OK(vw_halves_split(images, IMAGES, 5, halves, sizes));
    assert_int_equal(sizes[VW_HALF_A], 3);
    assert_int_equal(sizes[VW_HALF_B], 2);
    check_half(*state, halves, VW_HALF_A);
    check_half(*state, halves, VW_HALF_B);
}

// The split depends on names and seed, not on the order of the images.
TEST(halves_are_drawn_by_name_and_seed) {
    uint8_t halves[IMAGES], turned_halves[IMAGES], other[IMAGES];
    uint32_t sizes[VW_HALVES], differ = 0, counts[VW_HALVES + 1] = {0};
    struct vw_ledger_image turned[IMAGES];
    make_images();
    for (uint32_t i = 0; i < IMAGES; i++) turned[i] = images[IMAGES - 1 - i];
    ASSERT_OK(vw_halves_split(images, IMAGES, 5, halves, sizes));
    ASSERT_OK(vw_halves_split(turned, IMAGES, 5, turned_halves, sizes));
    for (uint32_t i = 0; i < IMAGES; i++) {
        assert_int_equal(halves[i], turned_halves[IMAGES - 1 - i]);
        assert_int_equal(halves[i] == VW_HALF_NONE, strcmp(images[i].split, "val") != 0);
        counts[halves[i]]++;
    }
    assert_int_equal(counts[VW_HALF_A], 3);
    assert_int_equal(counts[VW_HALF_B], 2);
    for (uint64_t seed = 0; seed < 8; seed++) {
        ASSERT_OK(vw_halves_split(images, IMAGES, seed, other, sizes));
        differ += memcmp(other, halves, sizeof halves) != 0;
    }
    assert_true(differ > 0);
}

// The weighted mean over the half's photos of what each gains, by photo; no lasting_loss, which no single photo has.
FOLDER_TEST(a_sweep_by_validation_photo_has_halves) {
    static struct vw_lasting_step steps[STEPS - 1];
    static double view_psnr[STEPS - 1][VIEWS];
    const uint32_t views[VIEWS] = {1, 3, 5, 7, 9};
    struct vw_value_input input;
    struct vw_ledger_score *scores = NULL;
    uint32_t score_count = 0, sizes[VW_HALVES], found = 0;
    uint8_t halves[IMAGES];
    bool all[IMAGES];
    double sum_of_half = 0;
    make_images();
    for (uint32_t i = 1; i < 2 * VIEWS; i += 2) images[i].weight = 1.0 + i;
    ASSERT_OK(vw_halves_split(images, IMAGES, 5, halves, sizes));
    for (uint32_t i = 0; i < IMAGES; i++) {
        all[i] = halves[i] != VW_HALF_NONE;
        sum_of_half += halves[i] == VW_HALF_B ? images[i].weight : 0;
    }
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record(*state, all, &input);
    for (uint32_t t = 1; t < STEPS; t++) {
        steps[t - 1] = (struct vw_lasting_step){t, 9, 9, 1, 1};
        for (uint32_t v = 0; v < VIEWS; v++) view_psnr[t - 1][v] = error_of(t, views[v]).l1;
    }
    input.lasting = (struct vw_lasting_pass){.steps = steps, .step_count = STEPS - 1, .view_psnr = *view_psnr};
    ASSERT_OK(vw_halves_score(ledger, &input, halves, VW_HALF_B, &scores, &score_count));
    for (uint32_t i = 0; i < score_count; i++)
        assert_null(strstr(scores[i].method, "lasting")); // lasting credit needs a value per validation photo
    free(scores);
    input.lasting.views = views;
    input.lasting.view_count = VIEWS;
    ASSERT_OK(vw_halves_score(ledger, &input, halves, VW_HALF_B, &scores, &score_count));
    for (uint32_t i = 0; i < score_count; i++) {
        assert_string_not_equal(scores[i].method, "lasting_loss");
        if (strcmp(scores[i].method, "lasting_psnr") != 0) continue;
        double sum = 0;
        for (uint32_t t = 1; t < STEPS; t++)
            for (uint32_t v = 0; v < VIEWS && input.records[t].view == scores[i].image_id; v++)
                if (halves[views[v]] == VW_HALF_B) sum += images[views[v]].weight * view_psnr[t - 1][v] / sum_of_half;
        assert_near(scores[i].value, sum, 1e-12);
        found++;
    }
    assert_int_equal(found, PHOTOS);
    free(scores);
}

// A ledger that lacks rows of view has no values for that half.
FOLDER_TEST(a_step_without_all_photos_has_no_value) {
    uint8_t halves[IMAGES];
    uint32_t sizes[VW_HALVES], score_count = 77;
    struct vw_value_input input;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    bool of_half[IMAGES];
    make_images();
    ASSERT_OK(vw_halves_split(images, IMAGES, 5, halves, sizes));
    for (uint32_t i = 0; i < IMAGES; i++) of_half[i] = halves[i] == VW_HALF_A;
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record(*state, of_half, &input);
    ASSERT_OK(vw_halves_score(ledger, &input, halves, VW_HALF_B, &scores, &score_count));
    for (uint32_t i = 0; i < score_count; i++) // quality may have scores, by the training loss
        assert_true(strncmp(scores[i].method, "dv_", 3) != 0);
}
