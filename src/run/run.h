// Runs that share a session, and what a run tells besides its scores. See viewworth/run.h.
#ifndef VIEWWORTH_RUN_RUN_H
#define VIEWWORTH_RUN_RUN_H

#include "gpu/compute.h"
#include "run/lasting/lasting_summary.h"
#include "run/outputs/run_outputs.h"
#include "run/plan/plan.h"
#include "run/scoring.h"
#include "run/session.h"
#include "value/series.h"
#include "viewworth/run.h"
#include "viewworth/status.h"
#include "viewworth/value.h"

// Opens a run like vw_run_open(), on a device of a session that several runs share. Opens the session by params->scene
// and params->device unless it is open, and decides its effects at most once. Accepts neither an accuracy level nor a
// budget. The session outlives the run. `*run` is untouched on failure.
enum vw_status vw_run_open_in_session(const struct vw_run_params *params, struct vw_session *session, uint32_t device,
                                      struct vw_run **run);
// Lets a run take up to `steps` more steps, which vw_run_step() then takes, one submission by a call; `*ended`: none is
// left. Together they are vw_run_advance(): a pool of trainings advances several runs in turn, each with the bits and
// the rows that it has alone. A run that has failed, or is interrupted, takes no further step.
enum vw_status vw_run_begin(struct vw_run *run, uint64_t steps);
enum vw_status vw_run_step(struct vw_run *run, bool *ended);
// Finishes a run like vw_run_finish(), but writes only field.vwf and scores.csv. Does nothing on a run that was
// finished when it was opened and has no steps left.
enum vw_status vw_run_score(struct vw_run *run);

enum { VW_TIMED_PASSES_MAX = 96 };

// The results of a run, which it owns and fills on its way.
struct vw_run_results {
    char run_id[VW_HASH_HEX_BYTES], head[VW_HASH_HEX_BYTES];
    char *ledger_path, *scores_path, *field_path, *splats_path;
    const struct vw_gpu_info *device;
    const struct vw_scene *scene;
    uint32_t downscale; // that the scene was opened with
    const struct vw_config *config;
    const struct vw_effect_decision *effects;
    uint32_t effect_count;
    struct vw_step_statistics statistics;            // counts steps in the ledger and at the writer
    struct vw_plan plan;                             // without a record: neither an accuracy level nor a budget chose
    struct vw_gpu_timer passes[VW_TIMED_PASSES_MAX]; // times of passes; none unless params.profile
    uint32_t pass_count;
    // Only in a validated run, but for outputs.has_splats:
    struct vw_scoring scoring;
    struct vw_run_outputs outputs;
    struct vw_lasting_summary lasting; // empty: the run has no lasting credit
};

// Returns the results, which are complete after vw_run_finish().
const struct vw_run_results *vw_run_get_results(const struct vw_run *run);

#endif
