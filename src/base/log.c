#include "viewworth/log.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum { BAR_CELLS = 20, LINE_BYTES = 192 };
static const double REDRAW_S = 0.1;

static bool quiet_mode;

void vw_log_set_quiet(bool quiet) { quiet_mode = quiet; }

// On a terminal a line first clears what a progress bar may have left there.
static void print_line(const char *prefix, const char *format, va_list arguments) {
    flockfile(stderr);
    if (isatty(STDERR_FILENO)) fputs("\r\033[K", stderr);
    fputs(prefix, stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    funlockfile(stderr);
}

void vw_log_info(const char *format, ...) {
    if (quiet_mode) return;
    va_list arguments;
    va_start(arguments, format);
    print_line("", format, arguments);
    va_end(arguments);
}

void vw_log_warning(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    print_line("warning: ", format, arguments);
    va_end(arguments);
}

static double read_clock_s(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double vw_now_s(void) { return read_clock_s(CLOCK_MONOTONIC); }

double vw_cpu_s(void) { return read_clock_s(CLOCK_PROCESS_CPUTIME_ID); }

static void format_duration(double duration_s, char *text, size_t text_bytes) {
    unsigned long long seconds = (unsigned long long)(duration_s + 0.5);
    unsigned long long hours = seconds / 3600, minutes = seconds / 60 % 60;
    if (hours) snprintf(text, text_bytes, "%llu:%02llu:%02llu", hours, minutes, seconds % 60);
    else snprintf(text, text_bytes, "%llu:%02llu", minutes, seconds % 60);
}

static double share_done(const struct vw_progress *progress) {
    return progress->total_steps ? (double)progress->done_steps / (double)progress->total_steps : 1.0;
}

static void format_bar(const struct vw_progress *progress, char bar[BAR_CELLS + 1]) {
    int filled = (int)(share_done(progress) * BAR_CELLS);
    if (filled > BAR_CELLS) filled = BAR_CELLS;
    memset(bar, '#', (size_t)filled);
    memset(bar + filled, '.', (size_t)(BAR_CELLS - filled));
    bar[BAR_CELLS] = 0;
}

// "epoch 3/30 [#####...............] 28.41 dB  41.2 steps/s  0:42 left"
static void format_state(const struct vw_progress *progress, double now_s, char line[LINE_BYTES]) {
    char bar[BAR_CELLS + 1], psnr[32] = "", left[32] = "?";
    format_bar(progress, bar);
    if (isfinite(progress->val_psnr_db)) snprintf(psnr, sizeof psnr, " %.2f dB", progress->val_psnr_db);
    double elapsed_s = now_s - progress->started_s;
    double steps_per_s = elapsed_s > 0 ? (double)(progress->done_steps - progress->first_step) / elapsed_s : 0;
    if (steps_per_s > 0)
        format_duration((double)(progress->total_steps - progress->done_steps) / steps_per_s, left, sizeof left);
    uint32_t shown_epoch = progress->epoch < progress->epochs ? progress->epoch + 1 : progress->epochs;
    snprintf(line, LINE_BYTES, "epoch %u/%u [%s]%s  %.1f steps/s  %s left", shown_epoch, progress->epochs, bar, psnr,
             steps_per_s, left);
}

static void draw(struct vw_progress *progress, double now_s) {
    char line[LINE_BYTES];
    format_state(progress, now_s, line);
    if (progress->terminal) fprintf(stderr, "\r%s\033[K", line);
    else fprintf(stderr, "%s\n", line);
    fflush(stderr);
    progress->drawn_s = now_s;
}

void vw_progress_begin(struct vw_progress *progress) {
    progress->terminal = isatty(STDERR_FILENO);
    progress->started_s = vw_now_s();
    progress->drawn_s = progress->started_s;
    progress->first_step = progress->done_steps;
    progress->tenths_printed = (uint32_t)(share_done(progress) * 10);
}

void vw_progress_update(struct vw_progress *progress) {
    if (quiet_mode) return;
    double now_s = vw_now_s();
    uint32_t tenths = (uint32_t)(share_done(progress) * 10);
    bool due = progress->terminal ? now_s - progress->drawn_s >= REDRAW_S : tenths > progress->tenths_printed;
    if (!due) return;
    draw(progress, now_s);
    progress->tenths_printed = tenths;
}

void vw_progress_end(struct vw_progress *progress) {
    if (quiet_mode) return;
    bool shown = !progress->terminal && progress->tenths_printed == (uint32_t)(share_done(progress) * 10);
    if (!shown) draw(progress, vw_now_s());
    if (progress->terminal) fputc('\n', stderr);
}
