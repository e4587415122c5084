// A run's evidence about its ranking: halves of the epochs, other validation photos, a better training.
#include "support/ledger_fixture.h"

#include "support/draws.h"
#include "value/agreement.h"

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
    assert_true(isnan(agreement.other_views) && isnan(agreement.better_training));
}

TEST(a_ranking_that_turns_is_told) {
    struct fixture fixture;
    train(rising, falling, &fixture);
    struct vw_ranking_agreement agreement = measure(&fixture, &no_matrix);
    assert_true(fabs(agreement.epoch_halves + 1) < 1e-12);
    train(rising, great_falling, &fixture); // one epoch of which would turn the first half
    assert_true(fabs(measure(&fixture, &no_matrix).epoch_halves + 1) < 1e-12);
}

static struct vw_ranking_agreement measure_matrix(double *psnr, uint32_t photo_count, uint32_t view_count,
                                                  double *blocks) {
    struct fixture fixture;
    struct vw_matrix matrix = {
        .photo_count = photo_count, .view_count = view_count, .psnr = psnr, .visit_count = 1, .blocks = blocks};
    for (uint32_t block = 0; blocks && block < VW_MATRIX_BLOCKS; block++) matrix.visits_of_block[block] = 1;
    train(rising, rising, &fixture);
    return measure(&fixture, &matrix);
}

// Every view ranks the photos alike; then each ranks them in an order of its own.
TEST(views_that_agree_foretell_others) {
    double psnr[PHOTOS * VIEWS];
    for (uint32_t i = 0; i < PHOTOS * VIEWS; i++) psnr[i] = rising[i / VIEWS];
    struct vw_ranking_agreement agreement = measure_matrix(psnr, PHOTOS, VIEWS, NULL);
    assert_int_equal(agreement.view_count, VIEWS);
    assert_true(agreement.other_views > 0.999 && agreement.other_views_low > 0.999);
    assert_false(vw_ranking_agreement_is_low(&agreement));
    for (uint32_t i = 0; i < PHOTOS * VIEWS; i++) psnr[i] = rising[(i / VIEWS + i % VIEWS) % PHOTOS];
    agreement = measure_matrix(psnr, PHOTOS, VIEWS, NULL);
    assert_true(agreement.other_views < 0.5 && agreement.other_views_low == 0);
    assert_true(vw_ranking_agreement_is_low(&agreement));
}

// Two views of the same spread that correlate by r foretell two others by 2 r / (1 + r), as Spearman and Brown have it
// (1910); of normal values the ranks then correlate by 6 / pi asin(r / 2). Two views tell no interval, one nothing.
TEST(two_views_foretell_as_a_test_of_twice_the_length) {
    const double other[PHOTOS] = {3, 1, 2, 6, 4, 5}, r = 1 - 6.0 * 12 / (6 * 35), longer = 2 * r / (1 + r);
    double psnr[PHOTOS * 2];
    for (uint32_t i = 0; i < PHOTOS; i++) psnr[2 * i] = rising[i], psnr[2 * i + 1] = other[i];
    struct vw_ranking_agreement agreement = measure_matrix(psnr, PHOTOS, 2, NULL);
    assert_true(fabs(agreement.other_views - 6 / 3.14159265358979 * asin(longer / 2)) < 1e-12);
    assert_true(agreement.other_views_low == 0 && agreement.other_views_high == 1);
    agreement = measure_matrix(psnr, PHOTOS * 2, 1, NULL);
    assert_true(isnan(agreement.other_views) && vw_ranking_agreement_is_low(&agreement));
}

// Draws seven views of 30 photos. Photos vary by 1, photos by view by 7, and those by block of epochs by 8 times 7 /
// 16, so that two such sums correlate by 1 / (1 + 1.5). The intervals of 90 % of 400 runs should contain what that
// means for ranks; 0.86 is 2.7 standard errors less.
TEST(intervals_contain_what_others_would_say) {
    enum { RUNS = 400, MANY = 30, SEVEN = 7, ENTRIES = MANY * SEVEN };
    static double psnr[ENTRIES], blocks[VW_MATRIX_BLOCKS * ENTRIES];
    const double truth = 6 / 3.14159265358979 * asin(1 / (1 + 1.5) / 2);
    uint32_t contained = 0, above = 0, place = 0;
    for (uint32_t run = 0; run < RUNS; run++) {
        double own = 0;
        for (uint32_t i = 0; i < ENTRIES; i++) {
            if (i % SEVEN == 0) own = test_normal(62, place++, 0);
            double with_view = own + sqrt(7) * test_normal(62, place++, 0);
            psnr[i] = 0;
            for (uint32_t block = 0; block < VW_MATRIX_BLOCKS; block++) {
                blocks[block * ENTRIES + i] =
                    with_view / VW_MATRIX_BLOCKS + sqrt(7 * 0.5 / VW_MATRIX_BLOCKS) * test_normal(62, place++, 0);
                psnr[i] += blocks[block * ENTRIES + i];
            }
        }
        struct vw_ranking_agreement agreement = measure_matrix(psnr, MANY, SEVEN, blocks);
        contained += agreement.other_views_low <= truth && truth <= agreement.other_views_high;
        above += agreement.other_views > truth;
    }
    if (contained < 0.86 * RUNS) fail_msg("%u of %d intervals contain the truth", contained, RUNS);
    if (above < 0.3 * RUNS || above > 0.7 * RUNS) fail_msg("%u of %d are above the truth", above, RUNS);
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
