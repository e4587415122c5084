#include "cli/output/progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"

enum { BAR_CELLS = 20, LINE_BYTES = 192 };
static const double REDRAW_S = 0.1;

// Writes a line of the log. On a terminal it first clears any remains of a progress bar.
void vw_log_to_stderr(void *context, enum vw_log_level level, const char *line) {
    const bool *quiet = context;
    if (level != VW_LOG_WARNING && *quiet) return;
    fprintf(stderr, "%s%s%s\n", isatty(STDERR_FILENO) ? "\r\033[K" : "", level == VW_LOG_WARNING ? "warning: " : "",
            line);
}

static void format_duration(double duration_s, char *text, size_t text_bytes) {
    unsigned long long seconds = (unsigned long long)(duration_s + 0.5);
    unsigned long long hours = seconds / 3600, minutes = seconds / 60 % 60;
    if (hours) snprintf(text, text_bytes, "%llu:%02llu:%02llu", hours, minutes, seconds % 60);
    else snprintf(text, text_bytes, "%llu:%02llu", minutes, seconds % 60);
}

static double share_done(const struct vw_run_state *state) {
    return state->total_steps ? (double)state->step / (double)state->total_steps : 1.0;
}

static void format_bar(const struct vw_run_state *state, char bar[BAR_CELLS + 1]) {
    int filled = (int)(share_done(state) * BAR_CELLS);
    if (filled > BAR_CELLS) filled = BAR_CELLS;
    memset(bar, '#', (size_t)filled);
    memset(bar + filled, '.', (size_t)(BAR_CELLS - filled));
    bar[BAR_CELLS] = 0;
}

// Formats the state: "epoch 3/30 [#####...............] 28.41 dB  41.2 steps/s  0:42 left"
static void format_state(const struct vw_progress *progress, double now_s, char line[LINE_BYTES]) {
    const struct vw_run_state *state = &progress->state;
    char bar[BAR_CELLS + 1], psnr[32] = "", left[32] = "?";
    format_bar(state, bar);
    if (isfinite(state->val_psnr_db)) snprintf(psnr, sizeof psnr, " %.2f dB", state->val_psnr_db);
    double elapsed_s = now_s - progress->started_s;
    double steps_per_s = elapsed_s > 0 ? (double)(state->step - progress->first_step) / elapsed_s : 0;
    if (steps_per_s > 0) format_duration((double)(state->total_steps - state->step) / steps_per_s, left, sizeof left);
    uint32_t shown_epoch = state->epoch < state->epochs ? state->epoch + 1 : state->epochs;
    if (state->backward) {
        snprintf(line, LINE_BYTES, "lasting credit [%s]  %.1f steps/s  %s left", bar, steps_per_s, left);
        return;
    }
    snprintf(line, LINE_BYTES, "epoch %u/%u [%s]%s  %.1f steps/s  %s left", shown_epoch, state->epochs, bar, psnr,
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

static uint32_t tenths_done(const struct vw_run_state *state) { return (uint32_t)(share_done(state) * 10); }

static void begin(struct vw_progress *progress) {
    progress->running = true;
    progress->terminal = isatty(STDERR_FILENO);
    progress->started_s = progress->drawn_s = vw_now_s();
    progress->first_step = progress->state.step;
    progress->tenths_printed = tenths_done(&progress->state);
}

static void update(struct vw_progress *progress) {
    double now_s = vw_now_s();
    uint32_t tenths = tenths_done(&progress->state);
    bool due = progress->terminal ? now_s - progress->drawn_s >= REDRAW_S : tenths > progress->tenths_printed;
    if (!due) return;
    draw(progress, now_s);
    progress->tenths_printed = tenths;
}

bool vw_progress_show(void *context, const struct vw_run_state *state) {
    struct vw_progress *progress = context;
    progress->state = *state;
    if (!progress->running) begin(progress);
    if (state->finished) vw_progress_end(progress);
    else if (!progress->quiet) update(progress);
    return !vw_interrupt_requested(&progress->interrupt);
}

void vw_progress_end(struct vw_progress *progress) {
    if (!progress->running) return;
    progress->running = false;
    if (progress->quiet) return;
    bool shown = !progress->terminal && progress->tenths_printed == tenths_done(&progress->state);
    if (!shown) draw(progress, vw_now_s());
    if (progress->terminal) fputc('\n', stderr);
}

void vw_progress_replace_line(double *drawn_s, const char *line) {
    double now_s = vw_now_s();
    if (!isatty(STDERR_FILENO) || (*line && now_s - *drawn_s < REDRAW_S)) return;
    fprintf(stderr, "\r%s\033[K", line);
    fflush(stderr);
    *drawn_s = now_s;
}
