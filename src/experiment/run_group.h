// Valued runs that take their steps at the same time, each in a folder of OUT.
#ifndef VIEWWORTH_EXPERIMENT_RUN_GROUP_H
#define VIEWWORTH_EXPERIMENT_RUN_GROUP_H

#include <stdint.h>

#include "experiment/experiment.h"
#include "run/session.h"
#include "viewworth/ledger.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"

// A run of an experiment as it differs from the others.
enum { VW_PLANNED_RUN_BYTES = 64 };
struct vw_planned_run {
    char folder[VW_PLANNED_RUN_BYTES]; // in OUT: "seed_7"
    char what[VW_PLANNED_RUN_BYTES];   // for the log: "seed     7 (1 of 3)"
    uint64_t seed;
    struct vw_scene_params scene; // its texts are borrowed
    struct vw_session *session;   // its devices are open, and those of all runs; its scene is opened unless it is
};

// Makes the first runs of `count` > 0, as many as are made at a time on the devices of their sessions: `*made`. A run
// that is there is resumed; a finished one stays as it is. The first failure is reported after the others have gone on.
// VW_ERROR_USAGE when a folder holds another run: the message says what differs. After VW_ERROR_INTERRUPTED the same
// call resumes.
enum vw_status vw_run_group_make(const struct vw_experiment_params *params, const struct vw_planned_run *runs,
                                 uint32_t count, uint32_t *made);

// Returns VW_ERROR_USAGE when OUT itself contains a run.
enum vw_status vw_run_group_check_out(const char *out);
// Opens the ledger of the run in OUT/folder; the caller closes it. VW_ERROR_INPUT when there is none, or a link.
enum vw_status vw_run_group_open_ledger(const char *out, const char *folder, struct vw_ledger **ledger);

#endif
