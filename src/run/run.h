// Runs that share a session, and what a run tells besides its scores. See viewworth/run.h.
#ifndef VIEWWORTH_RUN_RUN_H
#define VIEWWORTH_RUN_RUN_H

#include "run/session.h"
#include "viewworth/run.h"
#include "viewworth/status.h"

// As vw_run_open(), on a session that several runs share: it is opened by params->scene and params->device unless it is
// open, and its effects are decided at most once. The session outlives the run. `*run` is untouched on failure.
enum vw_status vw_run_open_in_session(const struct vw_run_params *params, struct vw_session *session,
                                      struct vw_run **run);
// As vw_run_finish(), but writes only field.vwf and scores.csv, and no other table and no report. Does nothing on a run
// that was finished when it was opened and has no steps left.
enum vw_status vw_run_score(struct vw_run *run);

#endif
