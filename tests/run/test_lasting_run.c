// The pass of a run from outside: its scores, stopping and resuming, what it refuses, and what it leaves alone.
// label: once
#include "support/ledger_chain.h"

#include "base/inside.h"
#include "run/lasting/lasting.h"
#include "run/verify/verify.h"
#include "support/forged_file.h"
#include "support/small_run.h"
#include "viewworth/viewworth.h"

enum { PHOTOS = 6, EPOCHS = 24, STEPS = PHOTOS * EPOCHS }; // more steps than one submission of a pass

struct observer {
    uint64_t stop_at; // step of a pass at which it stops; 0: never
    bool stops_training;
    uint32_t passes; // reports of a pass
};

static bool observe(void *context, const struct vw_run_state *state) {
    struct observer *observer = context;
    observer->passes += state->backward;
    if (!state->backward) return !observer->stops_training || state->step == 0;
    return !observer->stop_at || state->step < observer->stop_at;
}

static enum vw_status make_run(const char *out, const struct vw_config *config, struct vw_run_params params,
                               struct observer *observer) {
    struct vw_run *run = NULL;
    params.scene = (struct vw_scene_params){.path = SMALL_SCENE};
    params.config = config;
    params.out = out;
    params.progress = observe;
    params.context = observer;
    params.report.no_thumbnails = true;
    enum vw_status status = vw_run_open(&params, &run);
    if (!status) status = vw_run_advance(run, UINT64_MAX);
    if (!status) status = vw_run_finish(run);
    vw_run_close(&run);
    return status;
}

// Computes lasting credit of OUT as `lasting OUT` does.
static enum vw_status follow_by(const char *out, struct vw_lasting_options lasting, struct observer *observer) {
    return vw_lasting_of_folder(&(struct vw_run_params){
        .out = out, .lasting = lasting, .report.no_thumbnails = true, .progress = observe, .context = observer});
}

static enum vw_status follow(const char *out, uint32_t rays, bool gate, struct observer *observer) {
    return follow_by(out, (struct vw_lasting_options){true, rays, !gate, false}, observer);
}

static enum vw_status follow_matrix(const char *out, struct observer *observer) {
    return follow_by(out, (struct vw_lasting_options){true, 0, true, true}, observer);
}

static struct vw_lasting_pass read_pass(const char *out) {
    struct vw_lasting_pass read = {0};
    AUTO(vw_ledger_close) struct vw_ledger *ledger = test_ledger_open(temporary_path(out, "ledger.db"));
    ASSERT_OK(vw_ledger_get_lasting(ledger, &read));
    return read;
}

static void assert_same_pass(const char *out, const char *other) {
    AUTO(vw_lasting_pass_free) struct vw_lasting_pass a = read_pass(out), b = read_pass(other);
    assert_int_equal(a.step_count, STEPS);
    assert_int_equal(b.step_count, STEPS);
    assert_memory_equal(a.steps, b.steps, STEPS * sizeof *a.steps);
}

static void assert_same_gate(const char *out, const char *other) {
    AUTO(vw_lasting_pass_free) struct vw_lasting_pass a = read_pass(out), b = read_pass(other);
    assert_int_equal(a.check_count, b.check_count);
    for (uint32_t i = 0; i < a.check_count; i++) {
        assert_int_equal(a.checks[i].image_id, b.checks[i].image_id);
        assert_true(a.checks[i].predicted_psnr == b.checks[i].predicted_psnr);
        assert_true(a.checks[i].measured_psnr == b.checks[i].measured_psnr);
    }
}

static void assert_verifies(const char *out) {
    AUTO(vw_verification_free) struct vw_verification verification = {0};
    ASSERT_OK(vw_run_verify(&(struct vw_verify_params){.out = out}, &verification));
}

static bool is_there(const char *out, const char *name) { return vw_file_exists_inside(out, name); }

// ---- Cases ---------------------------------------------------------------------------------------------------------

// Makes two runs. "whole": valued, with lasting credit, by one command; "plain": valued only.
static int set_up(void **state) {
    struct vw_config config = small_config(0, EPOCHS);
    struct observer observer = {0};
    char *folder = temporary_folder_create();
    ASSERT_OK(
        make_run(temporary_path(folder, "whole"), &config, (struct vw_run_params){.lasting.wanted = true}, &observer));
    assert_true(observer.passes > 1);
    ASSERT_OK(make_run(temporary_path(folder, "plain"), &config, (struct vw_run_params){0}, &observer));
    *state = folder;
    return 0;
}

static int tear_down(void **state) {
    temporary_folder_remove(*state);
    return 0;
}

static void copy_plain(const char *folder, const char *out) {
    AUTO_FREE char *command = vw_format_text("rm -rf '%s' && cp -r '%s/plain' '%s'", out, folder, out);
    assert_int_equal(system(command), 0);
}

TEST(a_score_is_the_sum_over_the_steps) {
    const char *ledger = temporary_path(*state, "whole/ledger.db");
    assert_answer(ledger,
                  "SELECT count(*) FROM score JOIN (SELECT image_id, sum(lasting_step.psnr) AS psnr, "
                  "sum(lasting_step.loss) AS loss FROM lasting_step JOIN step USING (run_id, step) GROUP BY image_id) "
                  "USING (image_id) WHERE method LIKE 'lasting%' AND abs(value - CASE method WHEN 'lasting_psnr' THEN "
                  "psnr ELSE loss END) < 1e-12 AND stderr IS NULL AND visits = 24",
                  "12");
    assert_answer(ledger, "SELECT count(*) FROM lasting_check WHERE from_step = 108 AND measured_psnr IS NOT NULL",
                  "6");
    assert_answer(ledger, "SELECT epochs || ' ' || states || ' ' || rays FROM lasting", "4 24 0");
    assert_true(chain_holds(ledger));
    assert_verifies(temporary_path(*state, "whole"));
    assert_false(is_there(temporary_path(*state, "whole"), "lasting.vws"));
}

TEST(a_stopped_pass_goes_on) {
    struct observer stopping = {.stop_at = STEPS + 1}, going_on = {0};
    const char *whole = temporary_path(*state, "whole");
    const char *out = temporary_path(*state, "stopped");
    copy_plain(*state, out);
    ASSERT_FAILS(follow(out, 0, false, &stopping), VW_ERROR_INTERRUPTED, "interrupted");
    assert_true(is_there(out, "lasting.vws"));
    assert_verifies(out); // it is the finished run that it was
    struct vw_lasting_pass none = read_pass(out);
    assert_int_equal(none.step_count, 0);
    ASSERT_OK(follow(out, 0, true, &going_on));
    assert_same_pass(out, whole);
    assert_same_gate(out, whole);
    assert_verifies(out);
    assert_false(is_there(out, "lasting.vws"));
    uint32_t reports = going_on.passes;
    ASSERT_OK(follow(out, 0, false, &going_on)); // there is nothing left to do
    assert_int_equal(going_on.passes, reports);
}

static enum vw_status repeat(const char *out) {
    AUTO(vw_verification_free) struct vw_verification verification = {0};
    return vw_run_verify(&(struct vw_verify_params){.out = out, .lasting = true}, &verification);
}

TEST(a_pass_is_made_again) {
    struct observer observer = {0};
    ASSERT_OK(repeat(temporary_path(*state, "whole")));
    const char *out = temporary_path(*state, "views");
    copy_plain(*state, out);
    ASSERT_FAILS(repeat(out), VW_ERROR_USAGE, "has no lasting credit to make again");
    ASSERT_OK(follow_matrix(out, &observer));
    ASSERT_OK(repeat(out));
}

// Whoever can write into OUT can plant credits of a stopped pass, with a right hash of their own: the pass continues
// from them, and only making it again finds them.
TEST(a_planted_pass_is_found_by_making_it_again) {
    struct observer stopping = {.stop_at = STEPS + 1}, going_on = {0};
    const char *out = temporary_path(*state, "planted");
    copy_plain(*state, out);
    ASSERT_FAILS(follow(out, 0, false, &stopping), VW_ERROR_INTERRUPTED, "interrupted");
    forge_file(temporary_path(out, "lasting.vws"), 4 * sizeof(double), 1); // the lowest byte of the last step's psnr
    ASSERT_OK(follow(out, 0, false, &going_on));
    assert_verifies(out);
    ASSERT_FAILS(repeat(out), VW_ERROR_MISMATCH, "lasting credit of step 144, made again");
}

TEST(a_pass_by_validation_photo_goes_on) {
    struct observer stopping = {.stop_at = STEPS + 1}, going_on = {0};
    const char *whole = temporary_path(*state, "whole");
    const char *out = temporary_path(*state, "views");
    const char *stopped = temporary_path(*state, "stopped_views");
    copy_plain(*state, out);
    ASSERT_OK(follow(out, 0, false, &going_on));
    uint32_t reports = going_on.passes;
    ASSERT_OK(follow_matrix(out, &going_on)); // a pass without is not enough
    assert_true(going_on.passes > reports);
    reports = going_on.passes;
    ASSERT_OK(follow_matrix(out, &going_on));
    ASSERT_OK(follow(out, 0, false, &going_on)); // and one with is
    assert_int_equal(going_on.passes, reports);
    assert_same_pass(out, whole);
    copy_plain(*state, stopped);
    ASSERT_FAILS(follow_matrix(stopped, &stopping), VW_ERROR_INTERRUPTED, "interrupted");
    ASSERT_OK(follow_matrix(stopped, &going_on));
    struct vw_lasting_pass a = read_pass(out), b = read_pass(stopped);
    assert_int_equal(a.view_count, 2);
    assert_int_equal(b.view_count, 2);
    assert_memory_equal(a.view_psnr, b.view_psnr, STEPS * 2 * sizeof *a.view_psnr);
    vw_lasting_pass_free(&a);
    vw_lasting_pass_free(&b);
    // Rows are means over the views (see test_lasting.c; with so few rays up to 0.7 % off), which differ from each
    // other.
    assert_answer(
        temporary_path(out, "ledger.db"),
        "SELECT count(*) || '|' || (max(abs(mean - psnr) / size) < 0.02) || '|' || (max(range / size) > 0.1) FROM "
        "lasting_step JOIN (SELECT step, avg(psnr) AS mean, avg(abs(psnr)) AS size, max(psnr) - min(psnr) AS "
        "range FROM lasting_view GROUP BY step) USING (step)",
        "144|1|1");
    assert_verifies(out);
}

TEST(a_damaged_file_of_a_pass_starts_it_anew) {
    struct observer stopping = {.stop_at = STEPS + 1}, going_on = {0};
    const char *out = temporary_path(*state, "damaged"), *path = temporary_path(out, "lasting.vws");
    size_t size_bytes = 0;
    copy_plain(*state, out);
    ASSERT_FAILS(follow(out, 0, false, &stopping), VW_ERROR_INTERRUPTED, "interrupted");
    AUTO_FREE void *bytes = temporary_read(path, &size_bytes);
    ((char *)bytes)[size_bytes / 2] ^= 1;
    ASSERT_OK(vw_file_write(path, bytes, size_bytes));
    ASSERT_OK(follow(out, 0, false, &going_on));
    assert_same_pass(out, temporary_path(*state, "whole"));
}

TEST(the_gate_of_a_pass_without_one_comes_later) {
    struct observer going_on = {0};
    const char *whole = temporary_path(*state, "whole"), *out = temporary_path(*state, "ungated");
    copy_plain(*state, out);
    ASSERT_OK(follow(out, 0, false, &going_on));
    assert_answer(temporary_path(out, "ledger.db"), "SELECT count(*) FROM lasting_check", "0");
    ASSERT_OK(follow(out, 0, true, &going_on));
    assert_same_pass(out, whole);
    assert_same_gate(out, whole);
}

// Forged as well as can be: with a chain that fits. The replay finds it.
TEST(a_step_that_does_not_repeat_is_refused) {
    struct observer observer = {0};
    const char *out = temporary_path(*state, "forged");
    copy_plain(*state, out);
    sql_change(temporary_path(out, "ledger.db"), "UPDATE step SET train_loss = train_loss * 1.001 WHERE step = 7");
    chain_rewrite(temporary_path(out, "ledger.db"));
    ASSERT_FAILS(follow(out, 0, false, &observer), VW_ERROR_MISMATCH, "step 7, trained again");
    struct vw_lasting_pass none = read_pass(out);
    assert_int_equal(none.step_count, 0);
}

TEST(what_no_pass_can_follow_is_refused) {
    struct vw_config config = small_config(0, EPOCHS), posed = config;
    struct observer observer = {0}, stopping = {.stops_training = true};
    const char *out = temporary_path(*state, "refused");
    strcpy(posed.effects, "pose");
    ASSERT_FAILS(make_run(out, &posed, (struct vw_run_params){.lasting.wanted = true}, &observer), VW_ERROR_USAGE,
                 "--effects -pose");
    assert_false(is_there(out, "ledger.db")); // before the first step
    ASSERT_FAILS(make_run(out, &config, (struct vw_run_params){.lasting.wanted = true, .train_only = true}, &observer),
                 VW_ERROR_USAGE, "lasting, which need validation");
    config.epochs = 2;
    ASSERT_OK(make_run(out, &config, (struct vw_run_params){.train_only = true}, &observer));
    ASSERT_FAILS(follow(out, 0, false, &observer), VW_ERROR_USAGE, "run without validation");
    out = temporary_path(*state, "interrupted");
    config.epochs = 4000;
    ASSERT_FAILS(make_run(out, &config, (struct vw_run_params){0}, &stopping), VW_ERROR_INTERRUPTED, "interrupted");
    ASSERT_FAILS(follow(out, 0, false, &observer), VW_ERROR_USAGE, "the run is interrupted, not finished");
    assert_int_equal(observer.passes, 0);
}

// With momentum, and as part of what a run extends.
TEST(an_extended_run_is_followed_again) {
    struct vw_config config = small_config(0, EPOCHS);
    struct observer observer = {0};
    const char *out = temporary_path(*state, "extended");
    config.epochs = 3;
    config.beta1 = 0.9;
    ASSERT_OK(make_run(out, &config, (struct vw_run_params){.lasting.wanted = true}, &observer));
    assert_answer(temporary_path(out, "ledger.db"), "SELECT count(*) FROM lasting_check", "0"); // momentum: no gate
    ASSERT_OK(vw_file_write(temporary_path(out, "lasting.vws"), "stopped", 7)); // as a kill may leave it
    config.epochs = 4;
    ASSERT_OK(make_run(out, &config, (struct vw_run_params){.resume = true}, &observer));
    assert_false(is_there(out, "lasting.vws"));
    assert_answer(temporary_path(out, "ledger.db"),
                  "SELECT (SELECT count(*) FROM lasting_step) + (SELECT count(*) FROM score WHERE method LIKE "
                  "'lasting%')",
                  "0");
    ASSERT_OK(make_run(out, &config, (struct vw_run_params){.resume = true, .lasting.wanted = true}, &observer));
    assert_answer(temporary_path(out, "ledger.db"), "SELECT count(*) FROM lasting_step", "24");
    assert_verifies(out);
}

TEST_GROUP(set_up, tear_down)
