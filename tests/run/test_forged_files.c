// Files that somebody lays into OUT, with right hashes of their own: what a run goes on from, and its field. They
// change no result. label: once
#include "support/ledger_chain.h"

#include "run/recorded/render.h"
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
