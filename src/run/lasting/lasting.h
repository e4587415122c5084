// The backward pass of lasting credit over a finished run: made, gated, recorded and resumed.
//
// A pass that is stopped leaves lasting.vws in OUT (train/adjoint/lasting.h), with the credits up to there. The next
// one begins with it, and removes it at its end.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_H
#define VIEWWORTH_RUN_LASTING_LASTING_H

#include "run/recorded/recorded_run.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

// A pass over recorded steps; all borrowed.
struct vw_backward_params {
    const struct vw_trainer_params *training; // the run's, with the epochs that it took; `validate` set
    struct vw_recorded_steps recorded;        // all steps of the run
    struct vw_lasting_options options;
    const char *out;           // keeps a pass that is stopped, and has one to continue; NULL: neither
    vw_run_progress *progress; // NULL: none
    void *context;
};
// Makes the pass and its gate, whose credits a ledger can take; free it by vw_lasting_pass_free(). VW_ERROR_MISMATCH
// when a replayed step differs from the recorded one, VW_ERROR_INTERRUPTED when progress asks to stop.
enum vw_status vw_backward_make(const struct vw_backward_params *params, struct vw_lasting_pass *made);

// Estimates the seconds of a pass over a run that takes run_s, and of its gate, whose trainings have no scoring.
double vw_lasting_seconds(const struct vw_config *config, bool gated, double run_s, double training_s);

// Computes lasting credit for the run in params->out and writes its tables and report again; does nothing when the
// folder has the result already. The run's ledger tells scene and config; of the params, device (NULL: the run's),
// lasting, report, progress and context count. VW_ERROR_USAGE for a run that no backward pass can follow: imported,
// without validation, not finished, with halves.
enum vw_status vw_lasting_of_folder(const struct vw_run_params *params);

#endif
