// Runs that take their steps together leave what each leaves alone: also when one ends earlier, fails or is
// interrupted.
#include "support/cmocka_test.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/memory.h"
#include "run/run.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"

enum { RUNS = 3, PHOTOS = 6 };

static const uint32_t epochs_of[RUNS] = {4, 2, 4}; // the second ends earlier

struct observer {
    bool stops; // once a batch has been taken
    uint32_t reports;
    uint64_t step; // the last one shown
};

struct fixture {
    const char *folder; // of the test
    struct vw_session session;
    struct observer observers[RUNS];
    struct vw_run *runs[RUNS];
    enum vw_status statuses[RUNS];
};

static bool observe(void *context, const struct vw_run_state *state) {
    struct observer *observer = context;
    observer->step = state->step;
    observer->reports++; // the first comes before any step
    return !observer->stops || observer->reports < 2;
}

static const char *path_of(const struct fixture *f, const char *set, uint32_t index, const char *file) {
    char name[64];
    snprintf(name, sizeof name, "%s_%u%s%s", set, index, *file ? "/" : "", file);
    return temporary_path(f->folder, name);
}

static void open_run(struct fixture *f, const char *set, uint32_t index) {
    const struct vw_config config = small_config(index + 1, epochs_of[index]);
    const struct vw_run_params params = {.scene = {.path = SMALL_SCENE},
                                         .config = &config,
                                         .out = path_of(f, set, index, ""),
                                         .resume = true,
                                         .progress = observe,
                                         .context = &f->observers[index]};
    ASSERT_OK(vw_run_open_in_session(&params, &f->session, &f->runs[index]));
}

static void open_runs(struct fixture *f, const char *set) {
    for (uint32_t i = 0; i < RUNS; i++) {
        f->observers[i] = (struct observer){0};
        open_run(f, set, i);
    }
}

static enum vw_status advance(struct fixture *f) { return vw_runs_advance(f->runs, RUNS, f->statuses); }

static void close_runs(struct fixture *f) {
    for (uint32_t i = 0; i < RUNS; i++) vw_run_close(&f->runs[i]);
}

static int set_up(void **state) {
    struct fixture *f = vw_allocate(1, sizeof *f);
    f->folder = temporary_folder_create();
    for (uint32_t i = 0; i < RUNS; i++) { // what they leave alone
        open_run(f, "alone", i);
        ASSERT_OK(vw_run_advance(f->runs[i], UINT64_MAX));
        ASSERT_OK(vw_run_score(f->runs[i]));
        vw_run_close(&f->runs[i]);
    }
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    struct fixture *f = *state;
    close_runs(f);
    vw_session_close(&f->session);
    temporary_folder_remove((char *)f->folder);
    free(f);
    return 0;
}

// All rows, with the hashes that chain them.
static char *read_rows(const char *out) {
    char *ledger = vw_format_text("%s/ledger.db", out), *rows = NULL;
    char *command =
        vw_format_text("sqlite3 '%s' 'SELECT * FROM step; SELECT * FROM view; SELECT * FROM score'", ledger);
    FILE *stream = popen(command, "r");
    size_t capacity = 0;
    assert_non_null(stream);
    assert_true(getdelim(&rows, &capacity, 0, stream) > 0);
    assert_int_equal(pclose(stream), 0);
    free(command);
    free(ledger);
    return rows;
}

static void assert_as_alone(const struct fixture *f, const char *set, uint32_t index) {
    char *expected = read_rows(path_of(f, "alone", index, "")), *rows = read_rows(path_of(f, set, index, ""));
    assert_string_equal(expected, rows);
    free(expected);
    free(rows);
}

static void each_leaves_what_it_leaves_alone(void **state) {
    struct fixture *f = *state;
    open_runs(f, "together");
    ASSERT_OK(advance(f));
    for (uint32_t i = 0; i < RUNS; i++) {
        assert_int_equal(f->statuses[i], VW_OK);
        assert_int_equal(f->observers[i].step, epochs_of[i] * PHOTOS);
        ASSERT_OK(vw_run_score(f->runs[i]));
    }
    close_runs(f);
    for (uint32_t i = 0; i < RUNS; i++) assert_as_alone(f, "together", i);
}

// Something stands where the first run's ledger belongs when its first steps are done.
static void one_that_fails_does_not_stop_the_others(void **state) {
    struct fixture *f = *state;
    open_runs(f, "failing");
    mkdir(path_of(f, "failing", 0, ""), 0777);
    assert_int_equal(mkdir(path_of(f, "failing", 0, "ledger.db"), 0777), 0);
    enum vw_status status = advance(f);
    assert_int_not_equal(status, VW_OK);
    assert_int_equal(status, f->statuses[0]);
    assert_non_null(strstr(vw_error_message(), "failing_0/ledger.db"));
    for (uint32_t i = 1; i < RUNS; i++) {
        assert_int_equal(f->statuses[i], VW_OK);
        ASSERT_OK(vw_run_score(f->runs[i]));
    }
    close_runs(f);
    for (uint32_t i = 1; i < RUNS; i++) assert_as_alone(f, "failing", i);
}

static void an_interrupted_one_stops_all_and_all_resume(void **state) {
    struct fixture *f = *state;
    open_runs(f, "stopped");
    f->observers[2].stops = true;
    assert_int_equal(advance(f), VW_ERROR_INTERRUPTED);
    for (uint32_t i = 0; i < RUNS; i++) {
        assert_int_equal(f->statuses[i], VW_ERROR_INTERRUPTED);
        assert_true(f->observers[i].step < epochs_of[i] * PHOTOS);
    }
    close_runs(f);
    open_runs(f, "stopped");
    ASSERT_OK(advance(f));
    for (uint32_t i = 0; i < RUNS; i++) ASSERT_OK(vw_run_score(f->runs[i]));
    close_runs(f);
    for (uint32_t i = 0; i < RUNS; i++) assert_as_alone(f, "stopped", i);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(each_leaves_what_it_leaves_alone, set_up, tear_down),
        cmocka_unit_test_setup_teardown(one_that_fails_does_not_stop_the_others, set_up, tear_down),
        cmocka_unit_test_setup_teardown(an_interrupted_one_stops_all_and_all_resume, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
