// A run: one training of a scene that records every step in a ledger and values the photos. The folder OUT contains it.
//
//     struct vw_run *run = NULL;
//     enum vw_status status = vw_run_open(&(struct vw_run_params){.scene = {.path = "fox"}, .out = "OUT"}, &run);
//     if (!status) status = vw_run_advance(run, UINT64_MAX);
//     if (!status) status = vw_run_finish(run);
//     vw_run_close(&run);
#ifndef VIEWWORTH_RUN_H
#define VIEWWORTH_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "viewworth/ledger.h"
#include "viewworth/report.h"
#include "viewworth/scene.h"
#include "viewworth/status.h"
#include "viewworth/train.h"
#include "viewworth/version.h"

VW_PUBLIC_BEGIN

struct vw_run;

struct vw_run_state {
    uint64_t step, total_steps; // the last step on disk; steps that the run will have, if known
    uint32_t epoch, epochs;     // epoch counts from 0
    double val_psnr_db;         // value of the last validated step on disk; NaN: unknown
    bool finished;              // all steps are taken
    bool backward;              // the backward pass of lasting credit: its own steps, replayed and followed back
};

// Called before the first and after every submission of steps, and at the end. Returning false asks the run to stop.
typedef bool vw_run_progress(void *context, const struct vw_run_state *state);

// Lasting credit (value.h): one backward pass through the finished training.
struct vw_lasting_options {
    bool wanted;   // compute it, unless OUT has it
    uint32_t rays; // per step, that the backward pass uses; 0: all, or those of the result that OUT has
    bool no_gate;  // do not check the result by trainings
    bool matrix;   // also credit each validation photo's own PSNR; each costs up to half a backward pass more
};

struct vw_run_params {
    struct vw_scene_params scene;   // path is needed; gpu is ignored, since the run opens the device
    const struct vw_config *config; // NULL: vw_config_default
    const char *device;             // index or part of the name; NULL: the preferred device
    const char *out;                // needed: the folder of the results; made with the first steps
    bool resume;                    // continue the run in `out`, or extend it by more epochs; start when there is none
    bool train_only;                // neither validation nor scores
    const char *accuracy;           // the level: "draft", "quick", "standard" or "reference"; NULL: config as it is
    double budget_s;                // choose the level and epochs so that all ends within this time; 0: no budget
    uint64_t explicit_fields;       // that accuracy and budget_s leave as they are: bits of vw_config_explicit()
    const char *payout;             // amount to divide among the photos, "99.50"; NULL: none
    struct vw_lasting_options lasting;
    struct vw_report_options report;
    bool profile;              // time every pass
    vw_run_progress *progress; // NULL: none
    void *context;             // passed to progress; borrowed until the run is closed
};

// Locks OUT until the run is closed, opens device and scene, decides which effects are on, and creates or resumes the
// run in OUT. `*run` is untouched on failure. VW_ERROR_USAGE names the field that is missing or wrong, what differs
// from the run in OUT, or the process that writes there already.
enum vw_status vw_run_open(const struct vw_run_params *params, struct vw_run **run);
// Takes up to `steps` steps and records them; UINT64_MAX: all that are left. VW_OK when they are taken, or when none is
// left. VW_ERROR_INTERRUPTED when progress returned false: the ledger keeps the steps and the scores so far, and a
// later run with `resume` continues. After another error the ledger is marked "failed", unless no step was added, a
// repeated step differs from the recorded one, or the scores so far cannot be written.
enum vw_status vw_run_advance(struct vw_run *run, uint64_t steps);
// Scores what is recorded, writes field.vwf, scores.csv, the other tables and report.html, and marks the ledger
// "finished". Steps that are left are not taken; recorded steps that a loaded checkpoint lacks are taken again. Removes
// derived files that it does not make, fails when one cannot be made, and last lists its files in SHA256SUMS; also for
// a run that was finished before.
enum vw_status vw_run_finish(struct vw_run *run);
// Returns the scores of one method, one per train photo, best first. NULL: vw_value_main_method. Call it only after
// vw_run_finish(). The array and its strings are owned by the run. A method without scores gives count 0.
enum vw_status vw_run_scores(const struct vw_run *run, const char *method, const struct vw_ledger_score **scores,
                             uint32_t *count);
// Returns the photos of the run in the order of their image_id, which scores name. Call it once steps are recorded. The
// array and its strings are owned by the run.
enum vw_status vw_run_images(const struct vw_run *run, const struct vw_ledger_image **images, uint32_t *count);
// Closes a run. A run that was not finished keeps its steps, and `resume` continues it.
void vw_run_close(struct vw_run **run);

VW_PUBLIC_END

#endif
