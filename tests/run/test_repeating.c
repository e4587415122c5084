// Evidence that fits in itself: rows and files of a forger who computes every hash again. Plain verify does not find
// them; only making steps and retrainings again does. label: once
#include "support/ledger_chain.h"

#include "experiment/worth.h"
#include "ledger/retraining.h"
#include "run/recorded/scored_run.h"
#include "run/run_private.h"
#include "run/verify/verify.h"
#include "support/forged_file.h"
#include "support/small_run.h"
#include "viewworth/log.h"

enum { EPOCHS = 3, PLANTED_STEP = 5 };

static struct vw_run_params params_of(const char *out, const struct vw_config *config) {
    return (struct vw_run_params){
        .scene.path = SMALL_SCENE, .config = config, .out = out, .resume = true, .report.no_thumbnails = true};
}

static void finish(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    struct vw_run *run = small_run_make(&params);
    vw_run_close(&run);
}

static enum vw_status verify(const char *out, uint64_t replay_steps) {
    AUTO(vw_verification_free) struct vw_verification verification = {0};
    return vw_run_verify(&(struct vw_verify_params){.out = out, .replay_steps = replay_steps}, &verification);
}

// Gives a forged ledger the scores and hashes that its rows give, and then all files of a finished run.
static void make_it_fit(const char *out, const struct vw_config *config) {
    const char *path = temporary_path(out, "ledger.db");
    AUTO_FREE char *field = sql_ask(path, "SELECT field_sha256 FROM run");
    struct vw_scoring scoring;
    sql_change(path, "DELETE FROM score");
    chain_rewrite(path);
    struct vw_ledger *ledger = test_ledger_open_to_append(path);
    ASSERT_OK(vw_scoring_make(ledger, config, &scoring));
    ASSERT_OK(vw_ledger_set_field(ledger, field));
    ASSERT_OK(vw_ledger_finish(ledger, "finished", "2026-11-21T04:00:00Z", scoring.scores, scoring.score_count));
    vw_scoring_free(&scoring);
    vw_ledger_close(&ledger);
    finish(out, config);
}

FOLDER_TEST(edited_steps_are_found_by_a_replay) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run"), *ledger_path = vw_path_join(out, "ledger.db");
    finish(out, &config);
    ASSERT_OK(verify(out, UINT64_MAX));
    sql_change(ledger_path, "UPDATE view SET mse = mse / 2 WHERE step = 9;"
                            "UPDATE step SET val_psnr = val_psnr + 3.0102999566398120, val_psnr_pooled = "
                            "val_psnr_pooled + 3.0102999566398120 WHERE step = 9"); // 10 log10(2) dB
    make_it_fit(out, &config);
    ASSERT_OK(verify(out, 0));
    ASSERT_OK(verify(out, 8));
    ASSERT_FAILS(verify(out, 9), VW_ERROR_MISMATCH, "step 9, trained again, differs");
}

// ---- A checkpoint ---------------------------------------------------------------------------------------------------

// Leaves the ledger and the checkpoint of a run that was stopped after PLANTED_STEP.
static void stop(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, PLANTED_STEP));
    vw_run_save_checkpoint(run);
    vw_run_close(&run);
}

static void forge_checkpoints(const char *out) {
    for (int i = 0; i < 2; i++) {
        const char *path = temporary_path(out, i ? "checkpoint_1.vwc" : "checkpoint_0.vwc");
        if (vw_file_exists(path)) forge_payload(path);
    }
}

// Changes the params in a checkpoint, and adds the step to the ledger that follows from them.
static void plant_checkpoint(const char *out, const struct vw_config *config) {
    const struct vw_run_params params = params_of(out, config);
    const struct vw_step_record *records = NULL;
    uint32_t count = 0, view_count = 0;
    uint64_t step = 0;
    bool found = false;
    forge_checkpoints(out);
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_checkpoints_load(&run->checkpoints, run->trainer, PLANTED_STEP, &found, &step));
    assert_true(found && step == PLANTED_STEP);
    vw_trainer_stop_after(run->trainer, PLANTED_STEP + 1);
    ASSERT_OK(vw_trainer_advance(run->trainer, &records, &count));
    assert_int_equal(count, 1);
    const uint32_t *views = vw_trainer_validation_views(run->trainer, &view_count);
    ASSERT_OK(vw_ledger_append(run->ledger, records, count, views));
    vw_run_close(&run);
}

FOLDER_TEST(a_planted_checkpoint_is_found_by_a_replay) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run");
    stop(out, &config);
    plant_checkpoint(out, &config);
    const struct vw_run_params params = params_of(out, &config);
    struct vw_run *run = small_run_open(&params);
    assert_int_equal(run->started_after, PLANTED_STEP); // the run continues from it
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    ASSERT_OK(vw_run_finish(run));
    vw_run_close(&run);
    ASSERT_OK(verify(out, 0));
    ASSERT_OK(verify(out, PLANTED_STEP));
    ASSERT_FAILS(verify(out, UINT64_MAX), VW_ERROR_MISMATCH, "step 6, trained again, differs");
}

FOLDER_TEST(a_checkpoint_that_does_not_lead_to_the_recorded_steps_ends_the_run) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *out = vw_path_join(*state, "run");
    const struct vw_run_params params = params_of(out, &config);
    stop(out, &config);
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, 1));
    run->moved = false; // keeps the checkpoint
    vw_run_close(&run);
    forge_checkpoints(out);
    run = small_run_open(&params);
    ASSERT_FAILS(vw_run_advance(run, UINT64_MAX), VW_ERROR_MISMATCH, "trained again, differs");
    vw_run_close(&run);
}

// ---- Retrainings ----------------------------------------------------------------------------------------------------

static void make_worth(const char *out, uint32_t retrainings) {
    const struct vw_worth_run_params params = {.out = out, .retrainings = retrainings, .report.no_thumbnails = true};
    struct vw_worth_run result;
    ASSERT_OK(vw_worth_run_make(&params, &result));
    vw_worth_run_free(&result);
}

static enum vw_status repeat_retrainings(const char *out, uint32_t most) {
    uint32_t repeated = 0;
    return vw_worth_repeat(&(struct vw_worth_run_params){.out = out}, most, &repeated);
}

// Puts another result, with hashes of its own, in the place of the first retraining of a store.
static void plant(const char *folder, const char *from) {
    const char *made = temporary_path(from, "retrainings.db"), *path = temporary_path(folder, "retrainings.db");
    AUTO_FREE char *id = sql_ask(made, "SELECT retraining_id FROM retraining ORDER BY seed LIMIT 1");
    AUTO_FREE char *scene = sql_ask(made, "SELECT scene_hash FROM retraining");
    const struct vw_retrain_params retraining = {.seed = 1, .epochs = EPOCHS};
    const struct vw_retrain_result result = {.val_psnr = 99};
    struct vw_retraining_store *store = NULL;
    AUTO_FREE char *removal = vw_format_text("DELETE FROM retraining WHERE retraining_id = '%s'", id);
    if (vw_file_exists(path)) sql_change(path, removal);
    ASSERT_OK(vw_retraining_store_open(path, &store));
    ASSERT_OK(vw_retraining_store_add(store, id, scene, &retraining, &result, NULL, 0));
    vw_retraining_store_close(&store);
}

FOLDER_TEST(a_planted_retraining_is_found_by_making_it_again) {
    const struct vw_config config = small_config(0, EPOCHS);
    AUTO_FREE char *honest = vw_path_join(*state, "honest"), *out = vw_path_join(*state, "run");
    finish(honest, &config);
    finish(out, &config);
    make_worth(honest, 3);
    ASSERT_OK(repeat_retrainings(honest, UINT32_MAX));
    plant(out, honest);
    make_worth(out, 3); // takes the planted one
    assert_answer(temporary_path(out, "ledger.db"), "SELECT val_psnr FROM retraining WHERE retraining = 0", "99.0");
    ASSERT_OK(verify(out, UINT64_MAX));
    ASSERT_FAILS(repeat_retrainings(out, 1), VW_ERROR_MISMATCH, "retraining 0, made again");
    plant(honest, honest); // after the ledger has the true one
    ASSERT_OK(verify(honest, UINT64_MAX));
    ASSERT_FAILS(repeat_retrainings(honest, 1), VW_ERROR_MISMATCH, "retrainings.db: retraining ");
}

// ---- Scores ---------------------------------------------------------------------------------------------------------

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
