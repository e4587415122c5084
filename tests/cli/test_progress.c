// The lines that the program shows of a run's progress on stderr.
#include "support/printed.h"

#include "cli/output/progress.h"

static bool ask_to_stop(void *context) { return *(bool *)context; }

struct shown {
    bool quiet;
    uint32_t stop_after;
};

// Shows a run of 40 steps in 4 epochs, to its end or stopped after step `stop_after`, then writes two lines.
static void show_run(const void *context) {
    const struct shown *shown = context;
    bool stop = false, quiet = shown->quiet;
    struct vw_progress progress = {.quiet = quiet, .interrupt = {ask_to_stop, &stop}};
    for (uint32_t i = 0; i <= 40 && i <= shown->stop_after; i++) {
        const struct vw_run_state state = {.step = i,
                                           .total_steps = 40,
                                           .epoch = i ? (i - 1) / 10 : 0,
                                           .epochs = 4,
                                           .val_psnr_db = i > 4 ? 28.406 : NAN,
                                           .finished = i == 40};
        stop = i == shown->stop_after;
        assert_int_equal(vw_progress_show(&progress, &state), !stop);
    }
    vw_progress_end(&progress);
    vw_log_set_sink(vw_log_to_stderr, &quiet);
    vw_log_info("told %d", 1);
    vw_log_warning("warned %d", 2);
    vw_log_set_sink(NULL, NULL);
}

static int count_bars(const char *text) {
    int lines = 0;
    for (const char *next = text; (next = strstr(next, "epoch ")); next++) lines++;
    return lines;
}

TEST(a_line_each_tenth) {
    AUTO_FREE char *text = printed_on(stderr, show_run, &(struct shown){false, 41});
    assert_int_equal(count_bars(text), 10); // no eleventh: the last tenth is the end
    assert_null(strchr(text, '\r'));
    assert_ptr_equal(strstr(text, "epoch 1/4 [##..................]  "), text); // no PSNR yet
    assert_non_null(strstr(text, "epoch 2/4 [##########..........] 28.41 dB"));
    assert_non_null(strstr(text, "epoch 4/4 [####################] 28.41 dB"));
    assert_non_null(strstr(text, "0:00 left\n"));
    assert_non_null(strstr(text, "\ntold 1\nwarning: warned 2\n"));
}

TEST(a_stopped_run_ends_with_its_state) {
    AUTO_FREE char *text = printed_on(stderr, show_run, &(struct shown){false, 22});
    assert_int_equal(count_bars(text), 5);
    assert_non_null(strstr(text, "epoch 2/4 [##########..........] 28.41 dB")); // state at step 20, the last tenth
}

TEST(quiet_shows_warnings_alone) {
    AUTO_FREE char *text = printed_on(stderr, show_run, &(struct shown){true, 41});
    assert_string_equal(text, "warning: warned 2\n");
}
