// The matrix of photos and validation views against numbers worked out by hand and against dv_psnr, its jackknife, and
// what is odd of a view.
#include "support/ledger_fixture.h"

#include "base/statistics.h"
#include "report/tables.h"
#include "support/draws.h"
#include "value/matrix.h"
#include "viewworth/value.h"

enum { VIEWS_MOST = 8, STEPS_MOST = 400 };

// A run being recorded: its images, and steps whose measures follow from those of the views.
struct run {
    struct vw_ledger_image images[64];
    uint32_t image_count, view_count;
    uint32_t views[VIEWS_MOST];
    struct vw_step_record records[STEPS_MOST];
    struct vw_view_error errors[STEPS_MOST][VIEWS_MOST];
    uint32_t count;
};

static void add_image(struct run *run, const char *name, const char *split) {
    if (strcmp(split, "val") == 0) run->views[run->view_count++] = run->image_count;
    run->images[run->image_count] = (struct vw_ledger_image){run->image_count, name, split, NULL, HEX_A, NULL, 1};
    run->image_count++;
}

// Adds a step. `errors` has one entry per validation view; NULL flags the step.
static void add_step(struct run *run, uint32_t epoch, uint32_t photo, const struct vw_view_error *errors) {
    struct vw_step_record *record = &run->records[run->count];
    *record = (struct vw_step_record){.step = run->count,
                                      .epoch = epoch,
                                      .view = photo,
                                      .train_loss = 0.1,
                                      .validated = true,
                                      .nonfinite = !errors,
                                      .views = run->errors[run->count],
                                      .view_count = run->view_count};
    double mse = 0;
    for (uint32_t v = 0; errors && v < run->view_count; v++) {
        run->errors[run->count][v] = errors[v];
        record->val_psnr += vw_psnr_db(errors[v].mse) / run->view_count;
        record->val_l1 += errors[v].l1 / run->view_count;
        mse += errors[v].mse / run->view_count;
    }
    record->val_psnr_pooled = vw_psnr_db(mse);
    if (!errors) record->val_psnr = record->val_psnr_pooled = record->val_l1 = NAN;
    run->count++;
}

static struct vw_ledger *record(const char *folder, const struct run *run) {
    AUTO_FREE char *path = vw_path_join(folder, "ledger.db");
    struct vw_ledger *ledger = NULL;
    struct vw_ledger_run row = test_run("{}");
    remove(path);
    ASSERT_OK(vw_ledger_create(path, &row, run->images, run->image_count, &ledger));
    ASSERT_OK(vw_ledger_append(ledger, run->records, run->count, run->views));
    return ledger;
}

static struct vw_value_input input_of(const struct run *run, uint32_t burn_in_epochs) {
    return (struct vw_value_input){.records = run->records,
                                   .record_count = run->count,
                                   .burn_in_epochs = burn_in_epochs,
                                   .images = run->images,
                                   .image_count = run->image_count};
}

static struct vw_view_error error_of(double psnr_db, double l1) {
    return (struct vw_view_error){pow(10, -psnr_db / 10), l1};
}

// Makes a run with two views. The last step matches the first view perfectly, which counts as 100 dB.
static struct run *hand_made(void) {
    static const struct {
        uint32_t epoch, photo;
        double psnr[2], l1[2];
    } steps[] = {
        {0, VW_RECORD_UNTRAINED, {10, 20}, {0.5, 0.4}},
        {0, 1, {11, 21}, {0.4, 0.3}},
        {0, 2, {12, 20}, {0.35, 0.3}},
        {1, 2, {14, 19}, {0.25, 0.32}},
        {1, 1, {NAN, NAN}, {0, 0}},
        {2, 1, {15, 22}, {0.2, 0.02}},
        {2, 2, {INFINITY, 22}, {0, 0.04}},
    };
    struct run *run = vw_allocate(1, sizeof *run);
    add_image(run, "val,0.png", "val");
    add_image(run, "1.png", "train");
    add_image(run, "2.png", "train");
    add_image(run, "3.png", "val");
    add_image(run, "4.png", "test");
    for (size_t i = 0; i < VW_ARRAY_COUNT(steps); i++) {
        const struct vw_view_error errors[2] = {error_of(steps[i].psnr[0], steps[i].l1[0]),
                                                error_of(steps[i].psnr[1], steps[i].l1[1])};
        add_step(run, steps[i].epoch, steps[i].photo, isnan(steps[i].psnr[0]) ? NULL : errors);
    }
    return run;
}

// The tolerance is the rounding of powers of ten and their logarithms.
FOLDER_TEST(deltas_are_summed_by_view) {
    AUTO_FREE struct run *run = hand_made();
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record(*state, run);
    struct vw_value_input input = input_of(run, 1);
    struct vw_matrix matrix;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    assert_int_equal(matrix.photo_count, 2);
    assert_int_equal(matrix.view_count, 2);
    assert_true(matrix.photos[0] == 1 && matrix.photos[1] == 2 && matrix.views[0] == 0 && matrix.views[1] == 3);
    const double psnr[] = {1, 3, 2 + 85, -1 + 0},
                 l1[] = {0.05, 0.3, 0.1 + 0.2, -0.02 - 0.02}; // the flagged step is bridged
    for (size_t i = 0; i < 4; i++) {
        assert_near(matrix.psnr[i], psnr[i], 1e-12);
        assert_near(matrix.l1[i], l1[i], 1e-15);
    }
    assert_int_equal(matrix.visit_count, 3);
    assert_near(matrix.end_psnr[0], 100, 1e-12);
    assert_near(matrix.end_psnr[1], 22, 1e-12);

    const double standard_errors[] = {0.5, NAN};
    struct vw_csv_text table = {0};
    for (size_t i = 0; i < 4; i++) matrix.psnr[i] = psnr[i], matrix.l1[i] = i / 4.0;
    ASSERT_OK(vw_table_make_matrix("m", &matrix, standard_errors, run->images, run->image_count, &table));
    assert_string_equal(table.text, "name,provider,measure,unit,mean,jackknife_stderr,\"val,0.png\",3.png\n"
                                    "1.png,,dv_psnr,dB,2,0.5,1,3\n"
                                    "1.png,,dv_loss,mean absolute error,,,0,0.25\n"
                                    "2.png,,dv_psnr,dB,43,,87,-1\n"
                                    "2.png,,dv_loss,mean absolute error,,,0.5,0.75\n");
    assert_true(matrix.weights[0] == 1 && matrix.weights[1] == 1);
    matrix.weights[1] = 3;
    free(table.text);
    ASSERT_OK(vw_table_make_matrix("m", &matrix, standard_errors, run->images, run->image_count, &table));
    assert_non_null(strstr(table.text, "1.png,,dv_psnr,dB,2.5,0.5,1,3\n"));
    free(table.text);
    assert_int_equal(vw_table_make_matrix("m", &matrix, standard_errors, run->images, 3, &table), VW_ERROR_INPUT);
    vw_matrix_clear(&matrix);

    input.burn_in_epochs = 3;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    assert_int_equal(matrix.visit_count, 0);
    for (size_t i = 0; i < 4; i++) assert_true(matrix.psnr[i] == 0 && matrix.l1[i] == 0);
    vw_matrix_clear(&matrix);
}

FOLDER_TEST(a_run_without_views_has_no_columns) {
    AUTO_FREE struct run *run = hand_made();
    run->view_count = 0;
    for (uint32_t i = 0; i < run->count; i++) {
        run->records[i].view_count = 0;
        run->records[i].val_psnr_pooled = NAN; // an imported run: no reason to flag it
    }
    AUTO(vw_ledger_close) struct vw_ledger *ledger = record(*state, run);
    struct vw_value_input input = input_of(run, 1);
    AUTO(vw_matrix_clear) struct vw_matrix matrix;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    assert_int_equal(matrix.view_count, 0);
    AUTO_FREE struct vw_step_record *records = NULL;
    uint64_t count = 0;
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &count));
    for (uint64_t i = 0; i < count; i++) assert_int_equal(records[i].nonfinite, i == 4);
    assert_true(records[1].validated && isnan(records[1].val_psnr_pooled));
}

// The mean of a row is the photo's dv_psnr; with equal views, that of L1 its dv_loss.
FOLDER_TEST(row_means_are_the_scores) {
    const uint64_t seed = 11;
    enum { PHOTOS = 20, EPOCHS = 6 };
    AUTO_FREE struct run *run = vw_allocate(1, sizeof *run);
    for (uint32_t i = 0; i < PHOTOS + VIEWS_MOST; i++)
        add_image(run, vw_format_text("%u.png", i), i % 3 == 1 && i < 24 ? "val" : "train");
    assert_int_equal(run->view_count, VIEWS_MOST);
    uint32_t step = 0;
    for (uint32_t epoch = 0; epoch < EPOCHS; epoch++)
        for (uint32_t i = 0; i < run->image_count; i++) {
            if (strcmp(run->images[i].split, "train") != 0) continue;
            struct vw_view_error errors[VIEWS_MOST];
            for (uint32_t v = 0; v < VIEWS_MOST; v++)
                errors[v] = error_of(20 + test_draw(seed, step, v), 0.1 + 0.01 * test_draw(seed, step, v));
            errors[step % VIEWS_MOST].mse = step % 5 ? 0.01 : 0; // now and then a floored one
            if (step == 0) add_step(run, 0, VW_RECORD_UNTRAINED, errors);
            add_step(run, epoch, i, step % 17 == 5 ? NULL : errors);
            step++;
        }
    struct vw_ledger *ledger = record(*state, run);
    struct vw_value_input input = input_of(run, 1);
    AUTO(vw_matrix_clear) struct vw_matrix matrix;
    AUTO_FREE struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    assert_int_equal(matrix.photo_count, PHOTOS);
    uint32_t visits = 0;
    for (uint32_t p = 0; p < PHOTOS; p++) {
        double psnr = 0, l1 = 0;
        for (uint32_t v = 0; v < VIEWS_MOST; v++) {
            psnr += matrix.psnr[p * VIEWS_MOST + v] / VIEWS_MOST;
            l1 += matrix.l1[p * VIEWS_MOST + v] / VIEWS_MOST;
        }
        const struct vw_ledger_score *score = test_find_score(scores, count, "dv_psnr", matrix.photos[p]);
        visits += score->visits;
        assert_near(psnr, score->value, 1e-11); // sums of hundreds of values of up to 100, in another order
        assert_near(l1, test_find_score(scores, count, "dv_loss", matrix.photos[p])->value, 1e-13);
    }
    assert_int_equal(matrix.visit_count, visits);
    vw_ledger_close(&ledger);
    for (uint32_t i = 0; i < run->image_count; i++) free((char *)run->images[i].name);
}

// ---- The jackknife --------------------------------------------------------------------------------------------------

TEST(one_view_at_a_time_is_left_out) {
    uint32_t photos[] = {1, 2, 3}, ids[] = {7, 8, 9};
    double psnr[] = {1, 2, 3, 4, 5, 0, 0, 0, 3}, l1[9] = {0}, end_psnr[] = {20, 21, 10}; // means 2, 3, 1
    const struct vw_matrix matrix = {photos, ids, 3, 3, psnr, l1, NULL, end_psnr, 9};
    struct vw_view_evidence views[3];
    double standard_errors[3];
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    assert_near(standard_errors[0], sqrt(2.0 / 6), 1e-15); // deviations -1, 0, 1
    assert_near(standard_errors[1], sqrt(14.0 / 6), 1e-15);
    assert_near(standard_errors[2], 1, 1e-15);
    // Without the first or the second view photos 1 and 2 are even, above 3: ranks 2.5, 2.5, 1 against 2, 3, 1.
    assert_near(views[0].without, 1.5 / sqrt(1.5 * 2), 1e-15);
    assert_near(views[1].without, 1.5 / sqrt(1.5 * 2), 1e-15);
    assert_near(views[2].without, 1, 1e-15);
    assert_near(views[0].agreement, 1.5 / sqrt(1.5 * 2), 1e-15);
    assert_near(views[2].agreement, -1.5 / sqrt(1.5 * 2), 1e-15); // 3, 0, 3 against 1.5, 4.5, 0
    for (int v = 0; v < 3; v++) {
        assert_int_equal(views[v].image_id, ids[v]);
        assert_true(views[v].end_psnr == end_psnr[v]);
        assert_false(views[v].disagrees || views[v].stays_low); // three views are too few to judge one
    }
    const struct vw_matrix single = {photos, ids, 3, 1, psnr, l1, NULL, end_psnr, 3};
    ASSERT_OK(vw_matrix_jackknife(&single, views, standard_errors));
    assert_true(isnan(views[0].without) && isnan(views[0].agreement) && isnan(standard_errors[2]));
}

// The mean without a view, computed anew for every view, gives the jackknife; a view without weight is none.
TEST(a_weighted_mean_is_left_out_by_view) {
    uint32_t photos[] = {1, 2, 3}, ids[] = {7, 8, 9, 10};
    double psnr[] = {1, 2, 3, 50, 4, 5, 0, 60, 0, 0, 3, 70}, l1[12] = {0}, end_psnr[] = {20, 21, 10, 15};
    double weights[] = {2, 1, 5, 0};
    const struct vw_matrix matrix = {photos, ids, 3, 4, psnr, l1, NULL, end_psnr, 9, weights};
    struct vw_view_evidence views[4];
    double standard_errors[3];
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    for (int p = 0; p < 3; p++) {
        const double *row = &psnr[4 * p];
        double mean = (2 * row[0] + row[1] + 5 * row[2]) / 8, squares = 0;
        double without[] = {(row[1] + 5 * row[2]) / 6, (2 * row[0] + 5 * row[2]) / 7, (2 * row[0] + row[1]) / 3};
        for (int v = 0; v < 3; v++) squares += pow(without[v] - mean, 2);
        assert_near(standard_errors[p], sqrt(squares * 2 / 3), 1e-14);
    }
    assert_near(views[3].without, 1, 1e-15); // it had no weight
    weights[2] = weights[1] = 0;
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    assert_true(isnan(standard_errors[0])); // one view has all weight
}

enum { ODD_PHOTOS = 24, ODD_VIEWS = 6 };

// Evaluates views that share the photos' worth, with noise as strong as `noise_share` of it; view 2 shows something
// unrelated when `corrupted`.
static void evaluate(uint64_t seed, double noise_share, bool corrupted, struct vw_view_evidence views[ODD_VIEWS]) {
    static uint32_t photos[ODD_PHOTOS], ids[ODD_VIEWS] = {0, 1, 2, 3, 4, 5};
    static double psnr[ODD_PHOTOS * ODD_VIEWS], l1[ODD_PHOTOS * ODD_VIEWS], end_psnr[ODD_VIEWS],
        standard_errors[ODD_PHOTOS];
    for (uint32_t p = 0; p < ODD_PHOTOS; p++)
        for (uint32_t v = 0; v < ODD_VIEWS; v++) {
            double worth = corrupted && v == 2 ? 0 : test_draw(seed, p, 100);
            psnr[p * ODD_VIEWS + v] = worth + (corrupted && v == 2 ? 1 : noise_share) * test_draw(seed, p, v);
        }
    for (uint32_t v = 0; v < ODD_VIEWS; v++)
        end_psnr[v] = 20 + 4 * test_draw(seed, 1000, v) - (corrupted && v == 2 ? 14 : 0);
    const struct vw_matrix matrix = {photos, ids, ODD_PHOTOS, ODD_VIEWS, psnr, l1, NULL, end_psnr, 5 * ODD_PHOTOS};
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
}

// The thresholds keep their promise over 500 draws each: sound views are left in peace, also where they hardly agree;
// corrupted ones are found.
TEST(odd_views_are_found) {
    enum { ROUNDS = 500 };
    static const struct {
        double noise_share;
        bool corrupted;
        uint32_t found_least, found_most, others_most;
    } cases[] = {
        {0.3, false, 0, 0, 5},       {1, false, 0, 5, 15},      {3, false, 0, 15, 60},
        {0.3, true, 350, ROUNDS, 5}, {1, true, 200, ROUNDS, 5},
    };
    for (size_t i = 0; i < VW_ARRAY_COUNT(cases); i++) {
        uint32_t disagree = 0, low = 0, others = 0;
        for (uint32_t round = 0; round < ROUNDS; round++) {
            struct vw_view_evidence views[ODD_VIEWS];
            evaluate(1000 * i + round, cases[i].noise_share, cases[i].corrupted, views);
            disagree += views[2].disagrees;
            low += views[2].stays_low;
            for (uint32_t v = 0; v < ODD_VIEWS; v++) others += v != 2 && (views[v].disagrees || views[v].stays_low);
        }
        print_message("noise %g%s: view 2 disagrees %u, stays low %u of %u times; others are called odd %u times\n",
                      cases[i].noise_share, cases[i].corrupted ? ", view 2 corrupted" : "", disagree, low, ROUNDS,
                      others);
        assert_in_range(disagree, cases[i].found_least, cases[i].found_most);
        if (cases[i].corrupted) assert_in_range(low, ROUNDS / 4, ROUNDS);
        assert_in_range(others, 0, cases[i].others_most);
    }
}

// A view that no step changes has no agreement; that says nothing against or for the others. The odd one looks
// corrupted only if its PSNR is an outlier, too: else it is the only view of a region.
TEST(a_constant_view_hides_no_odd_one) {
    uint32_t photos[ODD_PHOTOS] = {0}, ids[ODD_VIEWS] = {0, 1, 2, 3, 4, 5};
    double psnr[ODD_PHOTOS * ODD_VIEWS] = {0}, l1[ODD_PHOTOS * ODD_VIEWS] = {0}, standard_errors[ODD_PHOTOS];
    double end_psnr[ODD_VIEWS] = {20, 21, 18, 22, 23, 20};
    for (uint32_t p = 0; p < ODD_PHOTOS; p++) // view 2 says the opposite of the others; view 5 is constant
        for (uint32_t v = 0; v < 5; v++) psnr[p * ODD_VIEWS + v] = (v == 2 ? -1.0 : 1.0) * p;
    struct vw_matrix matrix = {photos, ids, ODD_PHOTOS, ODD_VIEWS, psnr, l1, NULL, end_psnr, 5 * ODD_PHOTOS};
    struct vw_view_evidence views[ODD_VIEWS];
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    assert_true(isnan(views[5].agreement));
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_false(views[v].disagrees || views[v].stays_low);
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_int_equal(views[v].lone, v == 2);
    end_psnr[2] = 15.9; // below the median of 20.5 by more than 3 spreads of 1.48 and 3 dB
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_int_equal(views[v].disagrees, v == 2);
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_false(views[v].lone || views[v].stays_low);
    matrix.visit_count--; // fewer than five per photo
    end_psnr[1] = 0;
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_false(views[v].disagrees || views[v].stays_low);
    matrix.visit_count++;
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    assert_true(views[1].stays_low);
    end_psnr[1] = 21;
    for (uint32_t p = 0; p < ODD_PHOTOS; p++) // three views still vary, too few to judge one
        for (uint32_t v = 3; v < 5; v++) psnr[p * ODD_VIEWS + v] = 0;
    ASSERT_OK(vw_matrix_jackknife(&matrix, views, standard_errors));
    for (uint32_t v = 0; v < ODD_VIEWS; v++) assert_false(views[v].disagrees);
}

// A small ledger that names many photos and views, but has rows of few: its matrix would take more time than there is.
FOLDER_TEST(a_large_matrix_needs_as_many_rows) {
    enum { MORE = 600, NAME_BYTES = 16 };
    AUTO_FREE struct run *run = hand_made();
    uint32_t count = run->image_count + MORE;
    AUTO_FREE struct vw_ledger_image *images = vw_allocate(count, sizeof *images);
    char(*names)[NAME_BYTES] = vw_allocate(MORE, sizeof *names);
    memcpy(images, run->images, run->image_count * sizeof *images);
    for (uint32_t i = 0; i < MORE; i++) {
        uint32_t id = run->image_count + i;
        snprintf(names[i], NAME_BYTES, "more-%u", i);
        images[id] = (struct vw_ledger_image){id, names[i], i % 2 ? "val" : "train", NULL, HEX_A, NULL, 1};
    }
    AUTO_FREE char *path = vw_path_join(*state, "ledger.db");
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    struct vw_ledger_run row = test_run("{}");
    ASSERT_OK(vw_ledger_create(path, &row, images, count, &ledger));
    ASSERT_OK(vw_ledger_append(ledger, run->records, run->count, run->views));
    struct vw_value_input input = input_of(run, 1);
    input.images = images;
    input.image_count = count;
    AUTO(vw_matrix_clear) struct vw_matrix matrix;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    assert_int_equal(matrix.view_count, 0);
    assert_int_equal(matrix.visit_count, 0);
    free(names);
}
