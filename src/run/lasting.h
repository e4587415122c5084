// The sweep of lasting credit over a finished run: made, gated, recorded, resumed, and summed up for tables.
//
// A sweep that is stopped leaves two files in OUT: lasting.vws (train/lasting.h) and lasting_credits.vwc, the credits
// up to there. The next one begins with them. Both are removed at the end.
#ifndef VIEWWORTH_RUN_LASTING_H
#define VIEWWORTH_RUN_LASTING_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

struct vw_lasting_wanted {
    bool wanted;
    uint32_t rays; // 0: all, or those of a sweep that is there
    bool no_gate;
};

// VW_ERROR_USAGE for a config (NULL: the default) that no sweep follows.
enum vw_status vw_lasting_check_config(const struct vw_config *config);

// Whether a ledger's sweep is the one that is wanted.
bool vw_lasting_is_there(const struct vw_lasting_wanted *wanted, const struct vw_lasting_sweep *sweep);
// Sweeps a run that has ended and is scored, unless its ledger holds such a sweep; scores it again and writes
// scores.csv. VW_ERROR_MISMATCH when a replayed step differs from the recorded one, VW_ERROR_INTERRUPTED when progress
// asks to stop: the next sweep goes on from there.
enum vw_status vw_run_sweep(struct vw_run *run);

// What the ledger holds of a sweep, for text and JSON.
struct vw_lasting_summary {
    struct vw_lasting_sweep sweep;  // owned; step_count 0: none, and the rest is empty
    struct vw_ledger_score *scores; // owned; of lasting_psnr, best first; their texts are lent by the ledger
    uint32_t score_count;
    const struct vw_ledger_image *images; // lent by the ledger
    uint32_t image_count;
    uint64_t steps_per_epoch;
};
enum vw_status vw_lasting_summary_make(struct vw_ledger *ledger, struct vw_lasting_summary *summary);
void vw_lasting_summary_free(struct vw_lasting_summary *summary);

struct vw_lasting_folder_params {
    const char *out;    // holds a finished run of value
    const char *device; // index or part of the name; NULL: the run's
    struct vw_lasting_wanted wanted;
    bool no_thumbnails;
    vw_run_progress *progress;
    void *context; // of progress
};
// Sweeps the run that a folder holds, and writes its tables and report again; does nothing when it has such a sweep.
// VW_ERROR_USAGE for a run that no sweep follows: imported, without validation, not finished, with halves.
enum vw_status vw_lasting_of_folder(const struct vw_lasting_folder_params *params);

#endif
