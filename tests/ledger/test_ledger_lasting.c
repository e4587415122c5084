// The pass of lasting credit in a ledger: written whole, bound by the chain, removed by new steps, refused when it is
// not one; and the scores, growth and gate that follow from it.
#include "support/ledger_chain.h"

#include "value/lasting_scores.h"
#include "value/matrix.h"
#include "viewworth/value.h"

enum { STEPS = 20 }; // steps of test_four_epochs

static void fill(struct vw_lasting_step *steps) {
    for (uint32_t i = 0; i < STEPS; i++)
        steps[i] = (struct vw_lasting_step){i + 1, 0.25 * i - 1, -0.125 * (i + 1), 1 + 0.5 * (i % 7), 2};
}

static const struct vw_gate_check checks[] = {{1, 5, 0.5, 0.75, 0.01, 0.02}, {3, 5, -0.5, NAN, 0.03, NAN}};

static struct vw_lasting_pass pass_of(const struct vw_lasting_step *steps) {
    return (struct vw_lasting_pass){
        .rays = 64, .epochs = 4, .states = 20, .steps = steps, .step_count = STEPS, .checks = checks, .check_count = 2};
}

// The rows of a backward pass for each validation photo.
static double view_psnr[STEPS][TEST_VALIDATION_COUNT];

static void set_views(struct vw_lasting_pass *pass) {
    for (uint32_t i = 0; i < STEPS; i++)
        for (uint32_t v = 0; v < TEST_VALIDATION_COUNT; v++)
            view_psnr[i][v] = 0.25 * i - 1 + (v ? 0.5 : -0.5) * (i % 3);
    pass->views = test_validation_views;
    pass->view_psnr = *view_psnr;
    pass->view_count = TEST_VALIDATION_COUNT;
}

static void set_pass(const char *path, bool by_view) {
    struct vw_lasting_step steps[STEPS];
    fill(steps);
    struct vw_lasting_pass pass = pass_of(steps);
    if (by_view) set_views(&pass);
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open_to_append(path);
    ASSERT_OK(vw_ledger_set_lasting(ledger, &pass, test_scores, TEST_SCORE_COUNT));
    ASSERT_OK(vw_ledger_verify(ledger)); // also in the object that wrote it
}

// Returns a finished run with a pass; its path is to be freed.
static char *record(const char *folder, bool by_view) {
    char *path = test_ledger_record(folder, "ledger.db", &test_four_epochs, 7);
    set_pass(path, by_view);
    return path;
}

static enum vw_status get(const char *path, bool verify, struct vw_lasting_pass *pass) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    enum vw_status status = vw_ledger_open(path, &ledger);
    if (!status) status = verify ? vw_ledger_verify(ledger) : vw_ledger_get_lasting(ledger, pass);
    return status;
}

// ---- The ledger ----------------------------------------------------------------------------------------------------

FOLDER_TEST(a_pass_is_written_and_read) {
    struct vw_lasting_step steps[STEPS];
    struct vw_lasting_pass pass = {0};
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 7);
    ASSERT_OK(get(path, false, &pass));
    assert_int_equal(pass.step_count, 0);
    set_pass(path, false);
    set_pass(path, false); // replaces it
    fill(steps);
    ASSERT_OK(get(path, false, &pass));
    assert_int_equal(pass.step_count, STEPS);
    assert_memory_equal(pass.steps, steps, sizeof steps);
    assert_int_equal(pass.rays, 64);
    assert_int_equal(pass.epochs, 4);
    assert_int_equal(pass.states, 20);
    assert_int_equal(pass.check_count, 2);
    assert_int_equal(pass.checks[1].image_id, 3);
    assert_true(pass.checks[0].measured_psnr == 0.75 && isnan(pass.checks[1].measured_psnr));
    vw_lasting_pass_free(&pass);
    ASSERT_OK(get(path, true, NULL));
    assert_true(chain_holds(path));
    assert_answer(path, "SELECT status || ' ' || finished_utc FROM run", "finished 2026-11-21T04:00:00Z");
    assert_answer(path, "SELECT count(*) FROM score", "3");
}

FOLDER_TEST(validation_photos_have_rows_of_their_own) {
    struct vw_lasting_pass pass = {0};
    AUTO_FREE char *path = record(*state, false);
    set_pass(path, true);
    ASSERT_OK(get(path, true, NULL));
    assert_true(chain_holds(path));
    ASSERT_OK(get(path, false, &pass));
    assert_int_equal(pass.view_count, TEST_VALIDATION_COUNT);
    assert_memory_equal(pass.views, test_validation_views, sizeof test_validation_views);
    assert_memory_equal(pass.view_psnr, view_psnr, sizeof view_psnr);
    vw_lasting_pass_free(&pass);
    set_pass(path, false); // replaces it by one without
    ASSERT_OK(get(path, false, &pass));
    assert_int_equal(pass.step_count, STEPS);
    assert_int_equal(pass.view_count, 0);
    vw_lasting_pass_free(&pass);
    ASSERT_OK(get(path, true, NULL));
    assert_true(chain_holds(path));
}

FOLDER_TEST(new_steps_remove_the_pass) {
    AUTO_FREE char *path = record(*state, true);
    struct vw_lasting_pass pass = {0};
    struct test_trainer longer = test_four_epochs;
    longer.epochs++;
    AUTO_FREE struct test_recording *recording = test_record(&longer);
    struct vw_ledger *ledger = test_ledger_open_to_append(path);
    ASSERT_OK(vw_ledger_append(ledger, &recording->records[STEPS + 1], 5, test_validation_views));
    ASSERT_OK(vw_ledger_verify(ledger));
    vw_ledger_close(&ledger);
    ASSERT_OK(get(path, false, &pass));
    assert_int_equal(pass.step_count, 0);
    assert_answer(path,
                  "SELECT (SELECT count(*) FROM lasting_step) + (SELECT count(*) FROM lasting_check)"
                  " + (SELECT count(*) FROM lasting_view)",
                  "0");
}

FOLDER_TEST(what_is_no_pass_is_not_written) {
    struct vw_lasting_step steps[STEPS];
    struct vw_ledger *ledger = NULL;
    AUTO_FREE char *path = test_ledger_record(*state, "ledger.db", &test_four_epochs, 7);
    ASSERT_OK(vw_ledger_open_to_append(path, &ledger));
    static const uint32_t others[] = {0, 1};
    for (int i = 0; i < 5; i++) {
        fill(steps);
        struct vw_lasting_pass pass = pass_of(steps);
        set_views(&pass);
        if (i == 0) pass.step_count--;
        if (i == 1) steps[3].loss = INFINITY;
        if (i == 2) steps[3].step = 5;
        if (i == 3) pass.views = others; // one is to train on
        if (i == 4) view_psnr[7][1] = NAN;
        assert_int_equal(vw_ledger_set_lasting(ledger, &pass, NULL, 0), VW_ERROR_USAGE);
    }
    vw_ledger_close(&ledger);
    assert_answer(path, "SELECT count(*) FROM lasting_step", "0");
}

// Edits that the chain finds; with a chain that was computed anew, those that no pass has are refused when read.
FOLDER_TEST(edited_rows_are_found) {
    static const struct {
        const char *sql;
        bool refused; // also by whoever reads it
    } edits[] = {
        {"UPDATE lasting_step SET psnr = psnr + 1e-9 WHERE step = 3", false},
        {"UPDATE lasting_check SET measured_loss = 0 WHERE image_id = 1", false},
        {"UPDATE lasting SET rays = 0", false},
        {"DELETE FROM lasting_check", false},
        {"DELETE FROM lasting_step WHERE step = 20", true},
        {"DELETE FROM lasting_step WHERE step = 4", true},
        {"DELETE FROM lasting", true},
        {"UPDATE lasting_step SET step = 21 WHERE step = 20", true},
        {"UPDATE lasting_step SET psnr = 9e999 WHERE step = 3", true},
        {"UPDATE lasting_step SET psnr = 'much' WHERE step = 3", true},
        {"UPDATE lasting_step SET size_loss = -1 WHERE step = 3", true},
        {"UPDATE lasting_check SET image_id = 99 WHERE image_id = 3", true},
        {"UPDATE lasting_check SET from_step = 4000 WHERE image_id = 3", true},
        {"UPDATE lasting SET states = -1", true},
        {"UPDATE lasting_view SET psnr = psnr + 1e-9 WHERE step = 3 AND image_id = 4", false},
        {"DELETE FROM lasting_view", false},
        {"DELETE FROM lasting_view WHERE image_id = 4", true},
        {"DELETE FROM lasting_view WHERE step = 20", true},
        {"DELETE FROM lasting_view WHERE step = 3 AND image_id = 0", true},
        {"UPDATE lasting_view SET image_id = 1 WHERE image_id = 4", true}, // a photo to train on
        {"UPDATE lasting_view SET image_id = 1 WHERE image_id = 4 AND step = 9", true},
        {"UPDATE lasting_view SET psnr = 9e999 WHERE step = 3", true},
        {"UPDATE lasting_view SET run_id = 'another' WHERE step > 10", false},
        {"INSERT INTO lasting VALUES ('another', 1, 1, 1, '')", true},
    };
    AUTO_FREE char *path = record(*state, true);
    const struct kept_file kept = temporary_keep(path);
    for (size_t i = 0; i < VW_ARRAY_COUNT(edits); i++) {
        AUTO(vw_lasting_pass_free) struct vw_lasting_pass pass = {0};
        temporary_put_back(&kept);
        sql_change(path, edits[i].sql);
        ASSERT_CASE_FAILS(edits[i].sql, get(path, true, NULL), VW_ERROR_MISMATCH, "lasting");
        enum vw_status read = get(path, false, &pass);
        if (read != (edits[i].refused ? VW_ERROR_INPUT : VW_OK))
            fail_msg("%s: reading gave %d, %s", edits[i].sql, (int)read, vw_error_message());
    }
}

// ---- What follows from it -------------------------------------------------------------------------------------------

FOLDER_TEST(cells_of_the_matrix_are_sums_over_all_steps) {
    AUTO_FREE char *path = record(*state, true);
    AUTO_FREE struct vw_step_record *records = NULL;
    struct vw_value_input input = {.burn_in_epochs = 1};
    struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(path);
    ASSERT_OK(vw_ledger_get_images(ledger, &input.images, &input.image_count));
    ASSERT_OK(vw_ledger_get_steps(ledger, &records, &input.record_count));
    ASSERT_OK(vw_ledger_get_lasting(ledger, &input.lasting));
    input.records = records;
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++) { // test_lasting_run.c adds them up
        const struct vw_ledger_score *score = test_find_score(scores, count, "lasting_psnr", test_train_views[i]);
        assert_true(isnan(score->ci_low) && score->rank_ci_low == 0);
    }
    AUTO(vw_matrix_clear) struct vw_matrix matrix;
    ASSERT_OK(vw_value_matrix(ledger, &input, &matrix));
    assert_true(matrix.lasting && matrix.view_count == TEST_VALIDATION_COUNT);
    for (uint32_t i = 0; i < TEST_TRAIN_COUNT; i++)
        for (uint32_t v = 0; v < TEST_VALIDATION_COUNT; v++) {
            double sum = 0;
            for (uint32_t step = 1; step <= STEPS; step++)
                if (records[step].view == test_train_views[i]) sum += view_psnr[step - 1][v];
            assert_true(matrix.lasting[i * TEST_VALIDATION_COUNT + v] == sum);
        }
    free(scores);
    input.record_count -= TEST_TRAIN_COUNT; // a pass of more steps says nothing of fewer
    ASSERT_OK(vw_value_score(&input, &scores, &count));
    for (uint32_t i = 0; i < count; i++) assert_null(strstr("lasting_psnr lasting_loss", scores[i].method));
    free(scores);
    vw_lasting_pass_free(&input.lasting);
}

TEST(growth_is_of_the_way_back) {
    struct vw_lasting_step steps[STEPS] = {0};
    struct vw_lasting_pass pass = pass_of(steps);
    fill(steps);
    for (uint32_t i = 0; i < STEPS; i++) steps[i].size_psnr = 1;
    pass.epochs = 1; // the last 5 steps
    steps[17].size_psnr = 0.001;
    assert_true(vw_lasting_growth_of(&pass, 5).factor == 1);
    steps[11].size_psnr = 0.5; // step 12
    steps[4].size_psnr = 4;
    steps[2].size_psnr = 3;
    struct vw_lasting_growth growth = vw_lasting_growth_of(&pass, 5);
    assert_true(growth.factor == 8);
    assert_int_equal(growth.first_step, 5);
    assert_int_equal(growth.last_step, 12);
    pass.epochs = 4; // all of them
    assert_true(vw_lasting_growth_of(&pass, 5).factor == 4000);
}

TEST(the_gate_correlates_what_is_known) {
    const struct vw_gate_check known[] = {
        {1, 5, 1, 2, 1, -1}, {2, 5, 2, 4, 2, -2}, {3, 5, 7, NAN, 0, NAN}, {5, 5, 3, 6, 3, -3}};
    struct vw_lasting_pass pass = {.checks = known, .check_count = 4};
    assert_float_equal(vw_lasting_gate(&pass, false), 1, 1e-12);
    assert_float_equal(vw_lasting_gate(&pass, true), -1, 1e-12);
    pass.check_count = 3; // two of them are known
    assert_true(isnan(vw_lasting_gate(&pass, false)));
}
