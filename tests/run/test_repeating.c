// Evidence that fits in itself: rows and files of a forger who computes every hash again. Plain verify does not find
// them; only making steps and retrainings again does. label: once
#include "support/ledger_chain.h"

#include "experiment/worth.h"
#include "ledger/retraining_store.h"
#include "run/run_private.h"
#include "run/verify/verify.h"
#include "support/small_run.h"

enum { EPOCHS = 3 };

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

// ---- Retrainings
// -----------------------------------------------------------------------------------------------------

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
