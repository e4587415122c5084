// The run of viewworth.h as a program uses it: in pieces, stopped, resumed and finished.
// wrap: vw_ledger_append vw_ledger_writer_add vw_checkpoints_save
#include "support/cmocka_test.h"

#include <limits.h>
#include <stdatomic.h>
#include <unistd.h>

#include "run/checkpoints.h"
#include "run/ledger_writer.h"
#include "run/session.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "viewworth/viewworth.h"

enum { PHOTOS = 6, EPOCHS = 4, STEPS = PHOTOS * EPOCHS };

// ---- A slow disk, and what is on it ---------------------------------------------------------------------------------

enum { WRITE_US = 5000 };
static atomic_uint_fast64_t step_on_disk, step_handed_over;

WRAPS(vw_ledger_append);
WRAPS(vw_ledger_writer_add);
WRAPS(vw_checkpoints_save);

enum vw_status __wrap_vw_ledger_append(struct vw_ledger *ledger, const struct vw_step_record *records, uint32_t count,
                                       const uint32_t *validation_views) {
    usleep(WRITE_US);
    enum vw_status status = __real_vw_ledger_append(ledger, records, count, validation_views);
    if (!status) step_on_disk = records[count - 1].step;
    return status;
}

enum vw_status __wrap_vw_ledger_writer_add(struct vw_ledger_writer *writer, const struct vw_step_record *records,
                                           uint32_t count, const struct vw_step_statistics *statistics) {
    step_handed_over = records[count - 1].step;
    return __real_vw_ledger_writer_add(writer, records, count, statistics);
}

void __wrap_vw_checkpoints_save(struct vw_checkpoints *checkpoints, struct vw_trainer *trainer) {
    assert_int_equal(step_on_disk, step_handed_over); // the ledger leads
    __real_vw_checkpoints_save(checkpoints, trainer);
}

// ---- Fixture --------------------------------------------------------------------------------------------------------

// Counts what progress reports, and asks to stop at a step.
struct observer {
    uint64_t stop_at; // 0: never
    uint32_t calls, finished_calls;
    struct vw_run_state last;
};

static bool observe(void *context, const struct vw_run_state *state) {
    struct observer *observer = context;
    assert_true(state->step >= observer->last.step && state->step <= state->total_steps);
    assert_int_equal(state->total_steps, STEPS);
    assert_int_equal(state->epochs, EPOCHS);
    assert_true(state->step <= step_on_disk);
    observer->calls++;
    observer->finished_calls += state->finished;
    observer->last = *state;
    return !observer->stop_at || state->step < observer->stop_at;
}

static struct vw_run_params small_params(const struct vw_config *config, const char *out, struct observer *observer) {
    return (struct vw_run_params){.scene = {.path = SMALL_SCENE},
                                  .config = config,
                                  .out = out,
                                  .progress = observer ? observe : NULL,
                                  .context = observer};
}

static void assert_status(const char *out, const char *status) {
    AUTO(vw_ledger_close) struct vw_ledger *ledger = NULL;
    struct vw_ledger_run row;
    ASSERT_OK(vw_ledger_open(temporary_path(out, "ledger.db"), &ledger));
    ASSERT_OK(vw_ledger_verify(ledger));
    ASSERT_OK(vw_ledger_get_run(ledger, &row));
    assert_string_equal(row.status, status);
}

// Makes a whole run and finds the sums of its step deltas, which do not depend on how the steps were taken.
static void run_whole(const char *out, uint64_t seed, double values[PHOTOS]) {
    const struct vw_config config = small_config(seed, EPOCHS);
    const struct vw_run_params params = small_params(&config, out, NULL);
    const struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    struct vw_run *run = small_run_make(&params);
    ASSERT_OK(vw_run_scores(run, NULL, &scores, &count));
    assert_int_equal(count, PHOTOS);
    for (uint32_t i = 0; i < PHOTOS; i++) values[scores[i].image_id] = scores[i].value;
    vw_run_close(&run);
    assert_null(run);
}

static void assert_images(const struct vw_run *run) {
    const struct vw_ledger_image *images = NULL;
    uint32_t count = 0, train_count = 0;
    ASSERT_OK(vw_run_images(run, &images, &count));
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(images[i].image_id, i);
        assert_true(images[i].name && *images[i].name);
        train_count += strcmp(images[i].split, "train") == 0;
    }
    assert_int_equal(train_count, PHOTOS);
}

// Checks that the report that a run leaves has the bytes of one that is made later from its folder.
static void assert_report_is_made_again(const char *out) {
    AUTO_FREE void *first = NULL, *later = NULL;
    size_t first_bytes = 0, later_bytes = 0;
    ASSERT_OK(vw_report_write(&out, 1, temporary_path(out, "later.html"), NULL));
    ASSERT_OK(vw_file_read(temporary_path(out, "report.html"), 64 << 20, &first, &first_bytes));
    ASSERT_OK(vw_file_read(temporary_path(out, "later.html"), 64 << 20, &later, &later_bytes));
    assert_int_equal(first_bytes, later_bytes);
    assert_memory_equal(first, later, first_bytes);
}

FOLDER_TEST(pieces_stops_and_resumes_give_the_same_scores) {
    const char *whole = temporary_path(*state, "whole"), *pieces = temporary_path(*state, "pieces");
    double expected[PHOTOS];
    struct observer observer = {0};
    const struct vw_config config = small_config(1, EPOCHS);
    struct vw_run_params params = small_params(&config, pieces, &observer);
    run_whole(whole, 1, expected);

    step_on_disk = 0;
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, 5));
    assert_int_equal(observer.last.step, 5);
    assert_false(observer.last.finished);
    ASSERT_OK(vw_run_advance(run, 0));
    ASSERT_OK(vw_run_advance(run, 4));
    assert_int_equal(observer.last.step, 9);
    observer.stop_at = 10;
    ASSERT_FAILS(vw_run_advance(run, UINT64_MAX), VW_ERROR_INTERRUPTED, "interrupted");
    uint64_t stopped_at = observer.last.step;
    vw_run_close(&run);
    assert_status(pieces, "interrupted");
    assert_true(stopped_at >= 10 && stopped_at <= STEPS);

    observer = (struct observer){0};
    params.resume = true;
    ASSERT_OK(vw_run_open(&params, &run));
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    assert_int_equal(observer.last.step, STEPS);
    assert_int_equal(observer.finished_calls, 1);
    ASSERT_OK(vw_run_advance(run, UINT64_MAX)); // none is left
    ASSERT_OK(vw_run_finish(run));
    const struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    ASSERT_OK(vw_run_scores(run, "dv_psnr", &scores, &count));
    assert_int_equal(count, PHOTOS);
    for (uint32_t i = 0; i < PHOTOS; i++) {
        assert_true(scores[i].value == expected[scores[i].image_id]);
        if (i > 0) assert_true(scores[i - 1].value >= scores[i].value);
    }
    ASSERT_OK(vw_run_scores(run, "no_such_method", &scores, &count));
    assert_int_equal(count, 0);
    assert_images(run);
    vw_run_close(&run);

    assert_status(pieces, "finished");
    const char *const outputs[] = {"scores.csv", "matrix.csv", "field.vwf", "report.html"};
    for (size_t i = 0; i < sizeof outputs / sizeof *outputs; i++)
        assert_int_equal(access(temporary_path(pieces, outputs[i]), R_OK), 0);
    assert_report_is_made_again(temporary_path(*state, "pieces"));
}

FOLDER_TEST(a_stopped_run_may_go_on_at_once) {
    const char *out = temporary_path(*state, "out");
    struct observer observer = {.stop_at = 8};
    const struct vw_config config = small_config(2, EPOCHS);
    const struct vw_run_params params = small_params(&config, out, &observer);
    struct vw_run *run = small_run_open(&params);
    assert_int_equal(vw_run_advance(run, UINT64_MAX), VW_ERROR_INTERRUPTED);
    observer.stop_at = 0;
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    ASSERT_OK(vw_run_finish(run));
    vw_run_close(&run);
    assert_status(out, "finished");
}

// Closing is enough: the checkpoint and the ledger are where the run was left.
FOLDER_TEST(a_run_that_is_only_closed_can_be_resumed) {
    const char *out = temporary_path(*state, "out");
    struct observer observer = {0};
    const struct vw_config config = small_config(3, EPOCHS);
    struct vw_run_params params = small_params(&config, out, &observer);
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, 7));
    vw_run_close(&run);
    assert_status(out, "interrupted");
    assert_int_equal(vw_run_open(&params, &run), VW_ERROR_USAGE); // not without `resume`
    assert_non_null(strstr(vw_error_message(), "already contains a run"));
    assert_null(run);
    params.resume = true;
    observer = (struct observer){0};
    ASSERT_OK(vw_run_open(&params, &run));
    ASSERT_OK(vw_run_advance(run, 1));
    assert_int_equal(observer.last.step, 8);
    vw_run_close(&run);
}

// Finishing early values the steps so far; a later run takes the others.
FOLDER_TEST(a_run_may_be_finished_before_its_end) {
    const char *out = temporary_path(*state, "out");
    const struct vw_config config = small_config(8, EPOCHS);
    struct vw_run_params params = small_params(&config, out, NULL);
    const struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, 2 * PHOTOS));
    ASSERT_OK(vw_run_finish(run));
    ASSERT_OK(vw_run_finish(run)); // does nothing
    ASSERT_OK(vw_run_scores(run, NULL, &scores, &count));
    assert_int_equal(count, PHOTOS);
    assert_int_equal(scores[0].visits, 1); // burn-in is an epoch
    assert_int_equal(vw_run_advance(run, 1), VW_ERROR_USAGE);
    vw_run_close(&run);
    assert_status(out, "finished");
    assert_int_equal(access(temporary_path(out, "checkpoint_0.vwc"), R_OK), 0); // so that few steps are repeated
    params.resume = true;
    run = small_run_make(&params);
    ASSERT_OK(vw_run_scores(run, NULL, &scores, &count));
    assert_int_equal(scores[0].visits, EPOCHS - 1);
    vw_run_close(&run);
}

static void assert_same_field(const char *left, const char *right) {
    char command[1024];
    snprintf(command, sizeof command, "cmp '%s/field.vwf' '%s/field.vwf'", left, right);
    assert_int_equal(system(command), 0);
}

// The field is that of the last recorded step, also where the checkpoint that was loaded is older, or none is there.
FOLDER_TEST(finishing_a_resumed_run_keeps_its_field) {
    const char *whole = temporary_path(*state, "whole"), *resumed = temporary_path(*state, "resumed");
    const struct vw_config config = small_config(9, EPOCHS);
    struct vw_run *run = NULL;
    for (int i = 0; i < 2; i++) {
        const struct vw_run_params params = small_params(&config, i ? resumed : whole, NULL);
        ASSERT_OK(vw_run_open(&params, &run));
        ASSERT_OK(vw_run_advance(run, 2 * PHOTOS));
        if (!i) ASSERT_OK(vw_run_finish(run));
        vw_run_close(&run);
    }
    for (int i = 0; i < 3; i++) {
        struct vw_run_params params = small_params(&config, resumed, NULL);
        params.resume = true;
        ASSERT_OK(vw_run_open(&params, &run));
        ASSERT_OK(vw_run_finish(run));
        vw_run_close(&run);
        assert_same_field(whole, resumed);
        const char *const checkpoints[] = {"checkpoint_0.vwc", "checkpoint_1.vwc"};
        for (int c = 0; c < 2 && i == 1; c++) (void)remove(temporary_path(resumed, checkpoints[c]));
    }
}

static bool keep_last(void *context, const struct vw_run_state *state) {
    *(struct vw_run_state *)context = *state;
    return true;
}

FOLDER_TEST(the_last_report_is_of_the_last_step) {
    const struct vw_config config = small_config(10, EPOCHS);
    struct vw_run_params params = small_params(&config, temporary_path(*state, "out"), NULL);
    struct vw_run_state last = {0};
    params.progress = keep_last;
    params.context = &last;
    struct vw_run *run = small_run_open(&params);
    ASSERT_OK(vw_run_advance(run, UINT64_MAX));
    vw_run_close(&run);
    assert_true(last.finished);
    assert_int_equal(last.step, EPOCHS * PHOTOS);
    assert_int_equal(last.total_steps, last.step);
    assert_int_equal(last.epochs, EPOCHS);
    assert_int_equal(last.epoch + 1, last.epochs);
}

FOLDER_TEST(a_run_may_train_only) {
    const char *out = temporary_path(*state, "out");
    const struct vw_config config = small_config(5, EPOCHS);
    struct vw_run_params params = small_params(&config, out, NULL);
    const struct vw_ledger_score *scores = NULL;
    uint32_t count = 1;
    params.train_only = true;
    struct vw_run *run = small_run_make(&params);
    ASSERT_OK(vw_run_scores(run, NULL, &scores, &count));
    assert_int_equal(count, 0);
    vw_run_close(&run);
    assert_int_equal(access(temporary_path(out, "field.vwf"), R_OK), 0);
    assert_int_not_equal(access(temporary_path(out, "scores.csv"), R_OK), 0);
}

static void assert_refused(const struct vw_run_params *params, const char *text) {
    struct vw_run *run = NULL;
    assert_int_equal(vw_run_open(params, &run), VW_ERROR_USAGE);
    assert_null(run);
    if (!strstr(vw_error_message(), text)) fail_msg("\"%s\" does not say \"%s\"", vw_error_message(), text);
}

FOLDER_TEST(wrong_params_are_refused_by_name) {
    const char *out = temporary_path(*state, "out");
    struct vw_config config = small_config(6, EPOCHS);
    const struct vw_run_params good = small_params(&config, out, NULL);
    struct vw_run_params params = {0};
    assert_refused(NULL, "vw_run_params");
    assert_refused(&params, "scene.path");
    params = good;
    params.out = NULL;
    assert_refused(&params, "vw_run_params.out");
    params = good;
    params.accuracy = "best";
    assert_refused(&params, "\"best\" is not one of draft");
    params = good;
    params.budget_s = 1;
    assert_refused(&params, "10s to 1000h");
    params = good;
    params.payout = "much";
    assert_refused(&params, "--payout");
    params = good;
    params.train_only = true;
    params.accuracy = "draft";
    assert_refused(&params, "train_only");
    params = good;
    config.rays = 0;
    assert_refused(&params, "rays");
    assert_int_not_equal(access(out, F_OK), 0); // no folder is left
}

FOLDER_TEST(calls_out_of_order_are_refused) {
    const struct vw_config config = small_config(7, EPOCHS);
    const struct vw_run_params params = small_params(&config, temporary_path(*state, "out"), NULL);
    const struct vw_ledger_image *images = NULL;
    const struct vw_ledger_score *scores = NULL;
    uint32_t count = 0;
    struct vw_run *run = small_run_open(&params);
    assert_int_equal(vw_run_finish(run), VW_ERROR_USAGE);
    ASSERT_FAILS(vw_run_scores(run, NULL, &scores, &count), VW_ERROR_USAGE, "vw_run_finish");
    vw_run_close(&run);
    vw_run_close(&run); // run is NULL
    assert_int_equal(vw_run_advance(NULL, 1), VW_ERROR_USAGE);
    assert_int_equal(vw_run_finish(NULL), VW_ERROR_USAGE);
    assert_int_equal(vw_run_scores(NULL, NULL, &scores, &count), VW_ERROR_USAGE);
    assert_int_equal(vw_run_images(NULL, &images, &count), VW_ERROR_USAGE);
    assert_int_equal(vw_run_open(&params, NULL), VW_ERROR_USAGE);
    assert_int_equal(vw_report_write(NULL, 0, NULL, NULL), VW_ERROR_USAGE);
}

FOLDER_TEST(files_of_a_gpu_are_found) {
    const char *const files[] = {"nvidia0", "dri/renderD128", "kfd", "dxg"};
    char path[PATH_MAX];
    temporary_file(*state, "nvidiactl", ""); // there without a card, too
    temporary_file(*state, "dri/card0", ""); // a screen's
    assert_false(vw_find_gpu_file(*state, path, sizeof path));
    for (size_t i = 0; i < VW_ARRAY_COUNT(files); i++) {
        const char *file = temporary_file(*state, files[i], "");
        assert_true(vw_find_gpu_file(*state, path, sizeof path));
        assert_string_equal(path, file);
        assert_int_equal(unlink(file), 0);
    }
}
