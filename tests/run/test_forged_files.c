// Files that somebody lays into OUT, with right hashes of their own: what a run goes on from, and its field. They
// change no result. label: once
#include "support/ledger_chain.h"

#include "experiment/worth.h"
#include "run/recorded/render_view.h"
#include "run/recorded/replayed_run.h"
#include "run/recorded/scored_run.h"
#include "run/run_private.h"
#include "run/verify/verify.h"
#include "support/forged_file.h"
#include "support/small_run.h"
#include "viewworth/log.h"

enum { EPOCHS = 3, KEPT_STEP = 5, CHANGED_BYTES = 64 };

static struct vw_run_params params_of(const char *out, const struct vw_config *config) {
    return (struct vw_run_params){
        .scene.path = SMALL_SCENE, .config = config, .out = out, .resume = true, .report.no_thumbnails = true};
}

static void finish(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    struct vw_run *run = small_run_make(&params);
    vw_run_close(&run);
}

// Leaves a run of KEPT_STEP + 1 steps with a checkpoint of KEPT_STEP.
static void stop(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, KEPT_STEP));
    vw_run_save_checkpoint(run);
    ASSERT_OK(vw_run_advance(run, 1));
    vw_run_close(&run);
}

static uint64_t goes_on_after(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    struct vw_run *run = small_run_open(&params);
    uint64_t step = run->started_after;
    vw_run_close(&run);
    return step;
}

static void assert_same_steps(const char *out, const char *other) {
    AUTO_FREE char *ledger = vw_path_join(out, "ledger.db"), *expected = vw_path_join(other, "ledger.db");
    AUTO_FREE char *chain = sql_ask(expected, SQL_CHAIN);
    assert_answer(ledger, SQL_CHAIN, chain);
}

FOLDER_TEST(a_forged_checkpoint_is_not_used) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *whole = vw_path_join(*state, "whole");
    finish(whole, &config);
    stop(out, &config);
    assert_int_equal(goes_on_after(out, &config), KEPT_STEP); // the run's own one is
    for (int i = 0; i < 2; i++) {
        AUTO_FREE char *name = vw_format_text("checkpoint_%d.vwc", i), *path = vw_path_join(out, name);
        if (!vw_file_exists(path)) continue;
        for (size_t byte = 1; byte <= CHANGED_BYTES; byte++) forge_file(path, byte, 1);
    }
    assert_int_equal(goes_on_after(out, &config), 0);
    finish(out, &config);
    assert_same_steps(out, whole);
}

// A kill between the ledger and the file leaves the file of before.
FOLDER_TEST(the_checkpoint_before_the_last_one_is_used) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db");
    stop(out, &config);
    for (int i = 0; i < 2; i++) {
        AUTO_FREE char *name = vw_format_text("checkpoint_%d.vwc", i);
        struct vw_ledger *ledger = test_ledger_open_to_append(ledger_path);
        ASSERT_OK(vw_ledger_keep(ledger, name, HEX_A));
        vw_ledger_close(&ledger);
    }
    assert_int_equal(goes_on_after(out, &config), KEPT_STEP);
}

static const char *result_of(const struct vw_verification *verification, const char *name) {
    for (uint32_t i = 0; i < verification->item_count; i++)
        if (!strcmp(verification->items[i].name, name)) return verification->items[i].result;
    return "";
}

FOLDER_TEST(verify_names_what_is_not_bound) {
    const struct vw_config config = small_config(0, EPOCHS), other = small_config(1, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *elsewhere = vw_path_join(*state, "other");
    AUTO(vw_verification_free) struct vw_verification verification = {0};
    finish(out, &config);
    finish(elsewhere, &other);
    AUTO_FREE char *copy = vw_format_text("cp '%s'/checkpoint_0.vwc '%s'/checkpoint_1.vwc", elsewhere, out);
    assert_int_equal(system(copy), 0);
    AUTO_FREE char *foreign = vw_path_join(out, "lasting.vws");
    ASSERT_OK(vw_file_write(foreign, "x", 1));
    ASSERT_OK(vw_run_verify(&(struct vw_verify_params){.out = out}, &verification));
    assert_string_equal(result_of(&verification, "checkpoint_0.vwc"), "intact");
    assert_string_equal(result_of(&verification, "checkpoint_1.vwc"), "not bound");
    assert_string_equal(result_of(&verification, "lasting.vws"), "not bound");
    for (uint32_t i = 0; i < verification.list.unlisted_count; i++)
        assert_null(strstr(verification.list.unlisted[i], "checkpoint"));
}

FOLDER_TEST(a_forged_field_is_not_rendered) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *field = vw_path_join(out, "field.vwf");
    finish(out, &config);
    const struct vw_render_params params = {.out = out};
    struct vw_rendered_view rendered = {0};
    ASSERT_OK(vw_render_view(&params, &rendered));
    vw_rendered_view_free(&rendered);
    forge_file(field, 1, 1);
    ASSERT_FAILS(vw_render_view(&params, &rendered), VW_ERROR_INPUT, "the ledger does not hold its hash");
    vw_rendered_view_free(&rendered);
}

// ---- A forger who rewrites the ledger as a whole --------------------------------------------------------------------

#define STEP_OF_HALF_THE_ERROR(step)                                                                                   \
    "UPDATE view SET mse = mse / 2 WHERE step = " step "; UPDATE step SET val_psnr = val_psnr + 3.0102999566398120, "  \
    "val_psnr_pooled = val_psnr_pooled + 3.0102999566398120 WHERE step = " step // 10 log10(2) dB

// Writes names of providers, and gives the params of a run that pays them.
static struct vw_run_params paying(const char *folder, const char *out, const struct vw_config *config) {
    static const char given[] = "name,provider\nview_000,alice\nview_001,bob\n";
    const char *path = temporary_path(folder, "given.csv");
    ASSERT_OK(vw_file_write(path, given, strlen(given)));
    struct vw_run_params params = params_of(out, config);
    params.scene.providers = path;
    return params;
}

static void make(const struct vw_run_params *params) {
    struct vw_run *run = small_run_make(params);
    vw_run_close(&run);
}

// Computes worth from so many retrainings, and pays unless `amount` is NULL.
static enum vw_status worth(const char *out, uint32_t retrainings, const char *amount) {
    const struct vw_worth_run_params params = {
        .out = out, .retrainings = retrainings, .payout.amount = amount, .report.no_thumbnails = true};
    struct vw_worth_run result;
    enum vw_status status = vw_worth_run_make(&params, &result);
    vw_worth_run_free(&result);
    return status;
}

// The first steps are taken again before anybody is paid.
FOLDER_TEST(nobody_is_paid_by_steps_that_were_not_taken) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db");
    struct vw_run_params params = paying(*state, out, &config);
    struct vw_run *run = NULL;
    make(&params);
    params.payout.amount = "100";
    make(&params); // the steps that were taken pay
    ASSERT_OK(worth(out, 0, "100"));
    sql_change(ledger_path, STEP_OF_HALF_THE_ERROR("2"));
    chain_rewrite(ledger_path);
    ASSERT_FAILS(vw_run_open(&params, &run), VW_ERROR_MISMATCH, "step 2, trained again, differs");
    assert_null(run);
    ASSERT_FAILS(worth(out, 0, "100"), VW_ERROR_MISMATCH, "step 2, trained again, differs");
}

// So are those after a checkpoint.
FOLDER_TEST(nobody_is_paid_by_late_steps_that_were_not_taken) {
    enum { PHOTOS = 6, LONG_EPOCHS = 177, KEPT = 1040 };
    const struct vw_config config = small_config(0, LONG_EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db");
    struct vw_run_params params = paying(*state, out, &config);
    _Static_assert((int)VW_STEPS_SAMPLED < (int)KEPT && KEPT < 1050 && 1050 < PHOTOS * LONG_EPOCHS, "in this order");
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, KEPT));
    vw_run_save_checkpoint(run);
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    ASSERT_OK(vw_run_finish(run));
    vw_run_close(&run);
    params.payout.amount = "100";
    make(&params);
    sql_change(ledger_path, STEP_OF_HALF_THE_ERROR("1050"));
    chain_rewrite(ledger_path);
    ASSERT_FAILS(vw_run_open(&params, &run), VW_ERROR_MISMATCH, "step 1050, trained again, differs");
}

// A sample of the ledger's retrainings is made again.
FOLDER_TEST(nobody_is_paid_by_retrainings_that_were_not_made) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db"),
                   *store = vw_path_join(out, "retrainings.db");
    struct vw_run_params params = paying(*state, out, &config);
    char head[VW_HASH_HEX_BYTES];
    struct vw_run *run = NULL;
    make(&params);
    ASSERT_OK(worth(out, 3, NULL));
    params.payout.amount = "100";
    const struct vw_worth_run_params checked = {.out = out, .payout.amount = "100"};
    ASSERT_FAILS(vw_run_open(&params, &run), VW_ERROR_USAGE, "of which no sample was made again");
    ASSERT_OK(vw_worth_check_recorded(&checked, head));
    params.sampled_head = head;
    make(&params);
    ASSERT_OK(worth(out, 0, "100"));
    assert_int_equal(remove(store), 0);
    ASSERT_OK(worth(out, 0, "100")); // the store adds nothing to what the ledger has
    sql_change(ledger_path, "UPDATE retraining SET val_psnr = val_psnr + 1");
    chain_rewrite(ledger_path);
    ASSERT_FAILS(worth(out, 0, "100"), VW_ERROR_MISMATCH, "ledger.db: a retraining on", "nobody is paid by it");
    ASSERT_FAILS(worth(out, 4, "100"), VW_ERROR_MISMATCH, "ledger.db: a retraining on");
    ASSERT_FAILS(vw_worth_check_recorded(&checked, head), VW_ERROR_MISMATCH, "ledger.db: a retraining on");
}

static void count_warnings(void *context, enum vw_log_level level, const char *line) {
    if (level == VW_LOG_WARNING && strstr(line, "is not what its steps give")) ++*(int *)context;
}

// Scores are compared with those made anew before a list is chosen by them.
FOLDER_TEST(nothing_is_chosen_by_scores_that_steps_do_not_give) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db");
    struct vw_scored_run run;
    memset(&run, 0xff, sizeof run);
    assert_true(vw_scored_run_open(*state, &run) != VW_OK); // has no ledger
    vw_scored_run_close(&run);
    finish(out, &config);
    ASSERT_OK(vw_scored_run_open(out, &run));
    vw_scored_run_close(&run);
    sql_change(ledger_path, "UPDATE score SET value = -value WHERE method = 'dv_psnr'");
    chain_rewrite(ledger_path);
    ASSERT_FAILS(vw_scored_run_open(out, &run), VW_ERROR_MISMATCH, "is not what its steps give");
    vw_scored_run_close(&run);
    struct vw_recorded_run read = {0}; // whoever only prints them says so
    int warnings = 0;
    vw_log_set_sink(count_warnings, &warnings);
    enum vw_status status = vw_recorded_open(out, &read);
    vw_log_set_sink(NULL, NULL);
    ASSERT_OK(status);
    assert_int_equal(warnings, 1);
    vw_recorded_close(&read);
}
