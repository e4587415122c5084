// Messages of the program on stderr: lines, and the progress of a run.
#ifndef VIEWWORTH_CLI_OUTPUT_PROGRESS_H
#define VIEWWORTH_CLI_OUTPUT_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "viewworth/log.h"
#include "viewworth/run.h"

// Writes lines to stderr, warnings with "warning: " before them. It is the vw_log_sink of the program, whose context is
// a bool: whether only warnings are shown.
void vw_log_to_stderr(void *context, enum vw_log_level level, const char *line);

// Epoch, validation PSNR, steps per second and time left: a bar that is redrawn in place on a terminal; elsewhere a
// line every tenth of the way and at the end. Zero but for the first two before the first run.
struct vw_progress {
    bool quiet; // shows nothing
    struct vw_interrupt interrupt;
    // private
    struct vw_run_state state;
    double started_s, drawn_s;
    uint64_t first_step;
    uint32_t tenths_printed;
    bool running, terminal;
};
// Shows the state, and asks to stop once interrupted. It is a vw_run_progress whose context is a struct vw_progress.
// Several runs may follow one another.
bool vw_progress_show(void *context, const struct vw_run_state *state);
// Ends the display of a run that stopped early, so that what follows is on a line of its own.
void vw_progress_end(struct vw_progress *progress);
// Shows on a terminal a line that the next one of this kind replaces, at most ten times a second; does nothing
// elsewhere. `*drawn_s` begins as 0. An empty line clears it, at any time.
void vw_progress_replace_line(double *drawn_s, const char *line);

#endif
