// Runs that differ only by their seed. Each is in its folder OUT/seed_<seed>, as `value` writes it.
#ifndef VIEWWORTH_EXPERIMENT_SEED_RUNS_H
#define VIEWWORTH_EXPERIMENT_SEED_RUNS_H

#include <stdint.h>

#include "experiment/experiment.h"
#include "run/session.h"
#include "viewworth/ledger.h"
#include "viewworth/status.h"

// Makes params->seeds runs, from the seed of the config on. A run that is there is resumed; a finished one stays as it
// is. The runs share the session, which is opened unless it is open; the caller closes it. VW_ERROR_USAGE when OUT or
// a folder in it holds another run: the message says what differs. After VW_ERROR_INTERRUPTED the same
// call resumes.
enum vw_status vw_seed_runs_make(const struct vw_experiment_params *params, struct vw_session *session);
// Returns the path of a file of a seed's run ("field.vwf"), owned by the caller; NULL when memory is short.
char *vw_seed_run_path(const char *out, uint64_t seed, const char *file);
// Opens the ledger of a seed's run; the caller closes it. VW_ERROR_INPUT when there is none.
enum vw_status vw_seed_run_open(const char *out, uint64_t seed, struct vw_ledger **ledger);

#endif
