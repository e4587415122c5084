// The sweep of lasting credit over a finished run: made, gated, recorded and resumed.
//
// A sweep that is stopped leaves two files in OUT: lasting.vws (train/adjoint/lasting.h) and lasting_credits.vwc, the
// credits up to there. The next one begins with them. Both are removed at the end.
#ifndef VIEWWORTH_RUN_LASTING_LASTING_H
#define VIEWWORTH_RUN_LASTING_LASTING_H

#include "viewworth/run.h"
#include "viewworth/status.h"

// Sweeps a run that has ended and is scored, unless its ledger holds such a sweep; scores it again and writes
// scores.csv. VW_ERROR_MISMATCH when a replayed step differs from the recorded one, VW_ERROR_INTERRUPTED when progress
// asks to stop: the next sweep continues from there.
enum vw_status vw_run_sweep(struct vw_run *run);

#endif
