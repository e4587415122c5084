// Runs that take their steps together, on one device or on two, leave what each leaves alone: also when one ends
// earlier, fails or is interrupted, or when a device is lost.
#include "support/ledger_sql.h"

#include <sys/stat.h>

#include "run/run.h"
#include "support/small_run.h"
#include "support/temporary_folder.h"
#include "train/training_pool.h"

enum { RUNS = 3, PHOTOS = 6, DEVICES = 2 };

static const uint32_t epochs_of[RUNS] = {4, 2, 4}; // the second ends earlier

struct observer {
    bool stops; // once a submission has been taken
    uint32_t reports;
    uint64_t step; // the last one shown
};

struct fixture {
    const char *folder; // folder of the test
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

static void open_run(struct fixture *f, const char *set, uint32_t index, uint32_t device) {
    const struct vw_config config = small_config(index + 1, epochs_of[index]);
    const struct vw_run_params params = {.scene = {.path = SMALL_SCENE},
                                         .config = &config,
                                         .out = path_of(f, set, index, ""),
                                         .resume = true,
                                         .progress = observe,
                                         .context = &f->observers[index]};
    ASSERT_OK(vw_run_open_in_session(&params, &f->session, device, &f->runs[index]));
}

static void open_runs(struct fixture *f, const char *set, uint32_t device_count) {
    for (uint32_t i = 0; i < RUNS; i++) {
        f->observers[i] = (struct observer){0};
        open_run(f, set, i, i % device_count);
    }
}

static enum vw_status begin(void *context, const struct vw_pool_seat *seat, enum vw_pool_answer *answer) {
    struct fixture *f = context;
    (void)answer;
    return vw_run_begin(f->runs[seat->place], UINT64_MAX);
}

static enum vw_status step(void *context, const struct vw_pool_seat *seat, bool *ended) {
    return vw_run_step(((struct fixture *)context)->runs[seat->place], ended);
}

static enum vw_status end(void *context, const struct vw_pool_seat *seat, enum vw_status status) {
    return ((struct fixture *)context)->statuses[seat->place] = status;
}

static enum vw_status advance(struct fixture *f) {
    const struct vw_training_pool pool = {.devices = f->session.devices,
                                          .device_count = f->session.device_count,
                                          .together = RUNS,
                                          .begin = begin,
                                          .advance = step,
                                          .end = end,
                                          .context = f};
    return vw_training_pool_run(&pool, RUNS);
}

static void close_runs(struct fixture *f) {
    for (uint32_t i = 0; i < RUNS; i++) vw_run_close(&f->runs[i]);
}

static int set_up(void **state) {
    struct fixture *f = vw_allocate(1, sizeof *f);
    f->folder = temporary_folder_create();
    static const char *const preferred[DEVICES - 1] = {NULL}; // again
    const struct vw_session_params params = {.scene = {.path = SMALL_SCENE}, .devices = {NULL, preferred, DEVICES - 1}};
    ASSERT_OK(vw_session_open(&params, &f->session));
    assert_int_equal(f->session.device_count, DEVICES);
    for (uint32_t i = 0; i < RUNS; i++) { // the files that they leave alone
        open_run(f, "alone", i, 0);
        ASSERT_OK(vw_run_advance(f->runs[i], UINT64_MAX));
        ASSERT_OK(vw_run_score(f->runs[i]));
        vw_run_close(&f->runs[i]);
    }
    *state = f;
    return 0;
}

static int tear_down(void **state) {
    AUTO_FREE struct fixture *f = *state;
    close_runs(f);
    vw_session_close(&f->session);
    temporary_folder_remove((char *)f->folder);
    return 0;
}

static void assert_as_alone(const struct fixture *f, const char *set, uint32_t index) {
    static const char *const rows[] = {SQL_CHAIN,
                                       "SELECT group_concat(image_id || method || value || unit) FROM score"};
    for (size_t i = 0; i < VW_ARRAY_COUNT(rows); i++) {
        AUTO_FREE char *expected = sql_ask(path_of(f, "alone", index, "ledger.db"), rows[i]);
        assert_answer(path_of(f, set, index, "ledger.db"), rows[i], expected);
    }
}

static void take_all(struct fixture *f, const char *set) {
    ASSERT_OK(advance(f));
    for (uint32_t i = 0; i < RUNS; i++) {
        ASSERT_OK(f->statuses[i]);
        assert_int_equal(f->observers[i].step, epochs_of[i] * PHOTOS);
        ASSERT_OK(vw_run_score(f->runs[i]));
    }
    close_runs(f);
    for (uint32_t i = 0; i < RUNS; i++) assert_as_alone(f, set, i);
}

TEST_WITHIN(each_leaves_what_it_leaves_alone, set_up, tear_down) {
    struct fixture *f = *state;
    open_runs(f, "spread", DEVICES);
    for (uint32_t d = 0; d < DEVICES; d++)
        assert_int_equal(f->session.devices[d].submissions->member_count, 2 - d); // three runs: 2 and 1
    take_all(f, "spread");
}

TEST_WITHIN(a_device_that_is_lost_ends_its_own_runs, set_up, tear_down) {
    struct fixture *f = *state;
    open_runs(f, "lost", DEVICES);
    struct vw_submissions *lost = f->session.devices[1].submissions;
    lost->failure = vw_fail(VW_ERROR_DEVICE_LOST, "it is gone");
    lost->why = vw_error_save();
    ASSERT_FAILS(advance(f), VW_ERROR_DEVICE_LOST, "it is gone");
    assert_int_equal(f->statuses[1], VW_ERROR_DEVICE_LOST);
    for (uint32_t i = 0; i < RUNS; i += 2) {
        ASSERT_OK(f->statuses[i]);
        ASSERT_OK(vw_run_score(f->runs[i]));
    }
    close_runs(f);
    open_run(f, "lost", 1, 0); // resumed on the device that is left
    ASSERT_OK(vw_run_advance(f->runs[1], UINT64_MAX));
    ASSERT_OK(vw_run_score(f->runs[1]));
    close_runs(f);
    for (uint32_t i = 0; i < RUNS; i++) assert_as_alone(f, "lost", i);
}

// Its driver is then another, since the name of the driver says which loops shaders have.
TEST_WITHIN(devices_that_differ_are_refused, set_up, tear_down) {
    struct fixture *f = *state;
    static const char *const preferred[] = {NULL};
    setenv("VIEWWORTH_LOOPS", "kept", 1);
    enum vw_status status = vw_session_open_others(&(struct vw_device_choice){NULL, preferred, 1}, false, &f->session);
    unsetenv("VIEWWORTH_LOOPS");
    ASSERT_FAILS(status, VW_ERROR_USAGE, "loops kept) differ");
}

// Something stands where the first run's ledger belongs when its first steps are done.
TEST_WITHIN(one_that_fails_does_not_stop_the_others, set_up, tear_down) {
    struct fixture *f = *state;
    open_runs(f, "failing", DEVICES);
    mkdir(path_of(f, "failing", 0, ""), 0777);
    assert_int_equal(mkdir(path_of(f, "failing", 0, "ledger.db"), 0777), 0);
    enum vw_status status = advance(f);
    assert_int_not_equal(status, VW_OK);
    assert_int_equal(status, f->statuses[0]);
    assert_non_null(strstr(vw_error_message(), "failing_0/ledger.db"));
    for (uint32_t i = 1; i < RUNS; i++) {
        ASSERT_OK(f->statuses[i]);
        ASSERT_OK(vw_run_score(f->runs[i]));
    }
    close_runs(f);
    for (uint32_t i = 1; i < RUNS; i++) assert_as_alone(f, "failing", i);
}

TEST_WITHIN(interrupted_ones_resume, set_up, tear_down) {
    struct fixture *f = *state;
    open_runs(f, "stopped", DEVICES);
    for (uint32_t i = 0; i < RUNS; i++) f->observers[i].stops = true;
    assert_int_equal(advance(f), VW_ERROR_INTERRUPTED);
    for (uint32_t i = 0; i < RUNS; i++) {
        assert_int_equal(f->statuses[i], VW_ERROR_INTERRUPTED);
        assert_true(f->observers[i].step < epochs_of[i] * PHOTOS);
    }
    close_runs(f);
    open_runs(f, "stopped", 1);
    take_all(f, "stopped");
}
