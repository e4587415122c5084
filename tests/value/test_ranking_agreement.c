// A run's evidence about its ranking: halves of the epochs, and of the validation photos.
#include "support/ledger_fixture.h"

#include "value/verdict.h"

enum { PHOTOS = 6, VIEWS = 4, IMAGES = PHOTOS + VIEWS, EPOCHS = 9 }; // the first epoch is burn-in
enum { RECORDS = 1 + PHOTOS * EPOCHS };

struct fixture {
    struct vw_ledger_image images[IMAGES];
    struct vw_step_record records[RECORDS];
    char names[IMAGES][8];
};

// Makes a training in which photo p's steps change PSNR by first[p] in the first half of the epochs that count, and by
// second[p] in the second half.
static void train(const double *first, const double *second, struct fixture *fixture) {
    *fixture = (struct fixture){.records[0] = {.view = VW_RECORD_UNTRAINED, .val_psnr = 10}};
    for (uint32_t i = 0; i < IMAGES; i++) {
        snprintf(fixture->names[i], sizeof fixture->names[i], "%02u", i);
        fixture->images[i] =
            (struct vw_ledger_image){i, fixture->names[i], i < PHOTOS ? "train" : "val", NULL, HEX_A, NULL, 1};
    }
    for (uint32_t i = 1; i < RECORDS; i++) {
        uint32_t epoch = (i - 1) / PHOTOS, photo = (i - 1) % PHOTOS;
        double delta = epoch == 0 ? 100.0 * photo : epoch <= (EPOCHS - 1) / 2 ? first[photo] : second[photo];
        fixture->records[i] = (struct vw_step_record){
            .step = i, .epoch = epoch, .view = photo, .val_psnr = fixture->records[i - 1].val_psnr + delta};
    }
}

static struct vw_ranking_agreement measure(const struct fixture *fixture, const struct vw_matrix *matrix) {
    const struct vw_value_input input = {.records = fixture->records,
                                         .record_count = RECORDS,
                                         .burn_in_epochs = 1,
                                         .images = fixture->images,
                                         .image_count = IMAGES};
    struct vw_ranking_agreement agreement;
    ASSERT_OK(vw_ranking_agreement_measure(&input, matrix, NULL, 0, &agreement));
    return agreement;
}

static const double rising[PHOTOS] = {1, 2, 3, 4, 5, 6}, falling[PHOTOS] = {6, 5, 4, 3, 2, 1},
                    great_falling[PHOTOS] = {60, 50, 40, 30, 20, 10};
static const struct vw_matrix no_matrix = {0};

TEST(a_ranking_that_stays_agrees_with_itself) {
    struct fixture fixture;
    train(rising, rising, &fixture);
    struct vw_ranking_agreement agreement = measure(&fixture, &no_matrix);
    assert_int_equal(agreement.epochs, EPOCHS - 1);
    assert_true(fabs(agreement.epoch_halves - 1) < 1e-12);
    assert_true(isnan(agreement.view_halves) && isnan(agreement.better_training));
}

TEST(a_ranking_that_turns_is_told) {
    struct fixture fixture;
    train(rising, falling, &fixture);
    struct vw_ranking_agreement agreement = measure(&fixture, &no_matrix);
    assert_true(fabs(agreement.epoch_halves + 1) < 1e-12);
    train(rising, great_falling, &fixture); // one epoch of which would turn the first half
    assert_true(fabs(measure(&fixture, &no_matrix).epoch_halves + 1) < 1e-12);
}

// Every view ranks the photos alike; then each ranks them in an order of its own.
TEST(halves_of_the_validation_photos_are_compared) {
    struct fixture fixture;
    uint32_t photos[PHOTOS] = {0, 1, 2, 3, 4, 5}, views[VIEWS] = {PHOTOS, PHOTOS + 1, PHOTOS + 2, PHOTOS + 3};
    double psnr[PHOTOS * VIEWS];
    const struct vw_matrix matrix = {.photos = photos,
                                     .views = views,
                                     .photo_count = PHOTOS,
                                     .view_count = VIEWS,
                                     .psnr = psnr,
                                     .visit_count = PHOTOS * EPOCHS};
    train(rising, rising, &fixture);
    for (uint32_t i = 0; i < PHOTOS * VIEWS; i++) psnr[i] = rising[i / VIEWS];
    struct vw_ranking_agreement agreement = measure(&fixture, &matrix);
    assert_int_equal(agreement.view_count, VIEWS);
    assert_true(fabs(agreement.view_halves - 1) < 1e-12);
    for (uint32_t i = 0; i < PHOTOS * VIEWS; i++) psnr[i] = rising[(i / VIEWS + i % VIEWS) % PHOTOS];
    assert_true(measure(&fixture, &matrix).view_halves < 0.5);
}

// Halves that agree by 0.5 predict that as many photos again would agree by 2 * 0.5 / 1.5.
TEST(agreement_is_corrected_to_the_length_of_all_photos) {
    struct fixture fixture;
    uint32_t photos[PHOTOS] = {0, 1, 2, 3, 4, 5}, views[2] = {PHOTOS, PHOTOS + 1};
    const double other[PHOTOS] = {3, 1, 2, 6, 4, 5}; // Spearman 1 - 6 * 12 / (6 * 35)
    double psnr[PHOTOS * 2];
    const struct vw_matrix matrix = {
        .photos = photos, .views = views, .photo_count = PHOTOS, .view_count = 2, .psnr = psnr, .visit_count = 1};
    train(rising, rising, &fixture);
    for (uint32_t i = 0; i < PHOTOS; i++) psnr[2 * i] = rising[i], psnr[2 * i + 1] = other[i];
    for (uint32_t i = PHOTOS + 2; i < IMAGES; i++) fixture.images[i].split = "test";
    double r = 1 - 6.0 * 12 / (6 * 35);
    assert_true(fabs(measure(&fixture, &matrix).view_halves - 2 * r / (1 + r)) < 1e-12);
}

// Six scores have the variance 3.5. Errors of a quarter of it leave a reliability of 0.75; larger ones than the scores
// differ by leave none.
TEST(reliable_scores_predict_a_better_training) {
    struct vw_ledger_score scores[PHOTOS + 1];
    for (uint32_t i = 0; i <= PHOTOS; i++)
        scores[i] =
            (struct vw_ledger_score){.method = i < PHOTOS ? "dv_psnr" : "dv_loss", .value = i, .standard_error = 0};
    assert_true(fabs(vw_ranking_agreement_predict(scores, PHOTOS + 1) - 0.85) < 1e-12);
    for (uint32_t i = 0; i < PHOTOS; i++) scores[i].standard_error = sqrt(3.5 / 4);
    assert_true(fabs(vw_ranking_agreement_predict(scores, PHOTOS + 1) - 0.85 * 0.75) < 1e-12);
    for (uint32_t i = 0; i < PHOTOS; i++) scores[i].standard_error = 2;
    assert_true(vw_ranking_agreement_predict(scores, PHOTOS + 1) == 0);
    for (uint32_t i = 2; i < PHOTOS; i++) scores[i].standard_error = NAN;
    assert_true(isnan(vw_ranking_agreement_predict(scores, PHOTOS + 1)));
}
