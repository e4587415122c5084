// The lines that the program shows of a run's progress on stderr.
#include "support/ledger_fixture.h"

#include <fcntl.h>

#include "cli/output/progress.h"

static bool ask_to_stop(void *context) { return *(bool *)context; }

// Shows a run of 40 steps in 4 epochs, to its end or stopped after step `stop_after`, then writes two lines.
static void show_run(bool quiet, uint32_t stop_after) {
    bool stop = false;
    struct vw_progress progress = {.quiet = quiet, .interrupt = {ask_to_stop, &stop}};
    for (uint32_t i = 0; i <= 40 && i <= stop_after; i++) {
        const struct vw_run_state state = {.step = i,
                                           .total_steps = 40,
                                           .epoch = i ? (i - 1) / 10 : 0,
                                           .epochs = 4,
                                           .val_psnr_db = i > 4 ? 28.406 : NAN,
                                           .finished = i == 40};
        stop = i == stop_after;
        assert_int_equal(vw_progress_show(&progress, &state), !stop);
    }
    vw_progress_end(&progress);
    vw_log_set_sink(vw_log_to_stderr, &quiet);
    vw_log_info("told %d", 1);
    vw_log_warning("warned %d", 2);
    vw_log_set_sink(NULL, NULL);
}

// Returns what the run prints when stderr is a file.
static char *printed(const char *folder, bool quiet, uint32_t stop_after) {
    AUTO_FREE char *path = vw_path_join(folder, "stderr");
    int kept = dup(STDERR_FILENO), file = open(path, O_RDWR | O_CREAT | O_TRUNC, 0666);
    dup2(file, STDERR_FILENO);
    show_run(quiet, stop_after);
    dup2(kept, STDERR_FILENO);
    close(kept);
    close(file);
    return temporary_read(path, NULL);
}

static int count_bars(const char *text) {
    int lines = 0;
    for (const char *next = text; (next = strstr(next, "epoch ")); next++) lines++;
    return lines;
}

FOLDER_TEST(a_line_each_tenth) {
    AUTO_FREE char *text = printed(*state, false, 41);
    assert_int_equal(count_bars(text), 10); // no eleventh: the last tenth is the end
    assert_null(strchr(text, '\r'));
    assert_ptr_equal(strstr(text, "epoch 1/4 [##..................]  "), text); // no PSNR yet
    assert_non_null(strstr(text, "epoch 2/4 [##########..........] 28.41 dB"));
    assert_non_null(strstr(text, "epoch 4/4 [####################] 28.41 dB"));
    assert_non_null(strstr(text, "0:00 left\n"));
    assert_non_null(strstr(text, "\ntold 1\nwarning: warned 2\n"));
}

FOLDER_TEST(a_stopped_run_ends_with_its_state) {
    AUTO_FREE char *text = printed(*state, false, 22);
    assert_int_equal(count_bars(text), 5);
    assert_non_null(strstr(text, "epoch 2/4 [##########..........] 28.41 dB")); // state at step 20, the last tenth
}

FOLDER_TEST(quiet_shows_warnings_alone) {
    AUTO_FREE char *text = printed(*state, true, 41);
    assert_string_equal(text, "warning: warned 2\n");
}
