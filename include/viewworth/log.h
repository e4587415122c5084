// What the program says while it works: lines to stderr, and a progress display. Results go to stdout, by the commands.
#ifndef VIEWWORTH_LOG_H
#define VIEWWORTH_LOG_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/version.h"

VW_PUBLIC_BEGIN

// --quiet: only errors (which main prints) and warnings. Process-wide; set once at start.
void vw_log_set_quiet(bool quiet);
void vw_log_info(const char *format, ...) __attribute__((format(printf, 1, 2)));
void vw_log_warning(const char *format, ...) __attribute__((format(printf, 1, 2))); // also when quiet

// Progress of a training: a bar that is redrawn in place on a terminal, a plain line every tenth of the way (and at the
// end) elsewhere; nothing when quiet. Shows epoch, validation PSNR (when finite), steps per second and time left.
struct vw_progress {
    uint64_t total_steps, done_steps;
    uint32_t epoch, epochs; // epoch counts from 0, as in step records; shown from 1
    double val_psnr_db;     // NaN: unknown
    // private
    double started_s, drawn_s;
    uint64_t first_step; // done_steps when begun
    uint32_t tenths_printed;
    bool terminal;
};
void vw_progress_begin(struct vw_progress *progress);  // after setting total_steps, done_steps, epochs
void vw_progress_update(struct vw_progress *progress); // after changing done_steps, epoch, val_psnr_db
void vw_progress_end(struct vw_progress *progress);    // leaves the last state on a line of its own

// For display only, never for a decision that affects bits.
double vw_now_s(void); // monotonic seconds
double vw_cpu_s(void); // that all threads of the program have computed

VW_PUBLIC_END

#endif
